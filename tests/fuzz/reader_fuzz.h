// What the fuzz targets share: a folder for the files that are tried, and what a reader may throw.
#pragma once

#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

#include "noiseloom/core/error.h"

namespace noiseloom::fuzz {

// In memory, where the system has such a folder; removed at the end.
class Folder {
 public:
  Folder() {
    const bool in_memory = std::filesystem::is_directory("/dev/shm");
    path_ = std::string(in_memory ? "/dev/shm" : "/tmp") + "/noiseloom-fuzz-" + std::to_string(::getpid());
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string write(const std::string& name, const std::string& bytes) const {
    const std::string path = path_ + "/" + name;
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return path;
  }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

inline const Folder& folder() {
  static const Folder only;
  return only;
}

inline std::string text_of(const std::uint8_t* data, std::size_t size) {
  return std::string(reinterpret_cast<const char*>(data), size);
}

inline std::string bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return std::string{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

// A reader throws these, and nothing else.
inline void expect_reason(const std::function<void()>& read) {
  try {
    read();
  } catch (const UserError&) {
  } catch (const EnvironmentError&) {
  }
}

}  // namespace noiseloom::fuzz
