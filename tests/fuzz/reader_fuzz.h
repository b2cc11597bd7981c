// What the fuzz targets of the texture readers share: a folder for the files that are tried, and a program around a
// target.
//
// With libFuzzer (see CMakeLists.txt here) a source is a target; without, a program:
//   NAME_fuzz --seeds FOLDER     writes small sound inputs to begin with
//   NAME_fuzz --mutate COUNT     tries that many inputs made from them, the same ones each time
//   NAME_fuzz FILE...            tries each
#pragma once

#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "noiseloom/core/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

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

inline void try_bytes(const std::string& bytes) {
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
}

// Bytes changed, cut out, repeated, and numbers that are often limits put in.
inline std::string mutated(std::string bytes, std::mt19937_64& random) {
  const auto below = [&](std::size_t n) { return n == 0 ? 0 : static_cast<std::size_t>(random() % n); };
  const std::size_t changes = 1 + below(6);
  for (std::size_t change = 0; change < changes && !bytes.empty(); ++change) {
    const std::size_t at = below(below(2) == 0 ? bytes.size() : std::min<std::size_t>(bytes.size(), 256));
    switch (below(5)) {
      case 0:
        bytes[at] = static_cast<char>(random());
        break;
      case 1:
        bytes[at] = static_cast<char>(bytes[at] ^ 1 << below(8));
        break;
      case 2:
        bytes.resize(at);
        break;
      case 3:
        bytes.insert(at, bytes.substr(below(bytes.size()), below(64)));
        break;
      default: {
        static constexpr std::uint32_t limits[] = {0, 1, 0x7fffffff, 0x80000000, 0xffffffff, 0x10000, 0xff};
        const std::uint32_t limit = limits[below(std::size(limits))];
        for (std::size_t i = 0; i < 4 && at + i < bytes.size(); ++i) bytes[at + i] = static_cast<char>(limit >> 8 * i);
      }
    }
  }
  return bytes;
}

// The program, for targets with these seeds.
inline int run(int argc, char** argv, const std::vector<std::string>& seeds) {
  const std::string option = argc == 3 ? argv[1] : "";
  if (option == "--seeds") {
    for (std::size_t i = 0; i < seeds.size(); ++i)
      std::ofstream(std::string(argv[2]) + "/seed" + std::to_string(i), std::ios::binary) << seeds[i];
    return 0;
  }
  if (option == "--mutate") {
    std::mt19937_64 random(1);
    const long count = std::atol(argv[2]);
    for (const std::string& seed : seeds) try_bytes(seed);
    for (long i = 0; i < count; ++i) try_bytes(mutated(seeds[static_cast<std::size_t>(i) % seeds.size()], random));
    std::printf("%ld inputs tried\n", count);
    return 0;
  }
  for (int i = 1; i < argc; ++i) try_bytes(bytes_of(argv[i]));
  std::printf("%d files tried\n", argc - 1);
  return 0;
}

}  // namespace noiseloom::fuzz
