// FileOps that count and fail or stop at the k-th operation.
#pragma once

#include <unistd.h>

#include <functional>
#include <limits>
#include <string>

#include "noiseloom/core/error.h"
#include "noiseloom/files/file_ops.h"

namespace noiseloom {

// Passes everything on until operation `fail_at` (counted from 0). That one is half done if it is a write, and then
// fails with an EnvironmentError, or ends the process as kill -9 would. Syncs are counted and left out: a test cannot
// cut the power.
class FailingFileOps final : public FileOps {
 public:
  enum class Mode {
    fail_once,   // later operations work again
    fail_on,     // every later one fails too
    end_process  // _exit(stopped_status)
  };
  static constexpr int never = std::numeric_limits<int>::max();
  static constexpr int stopped_status = 42;

  FailingFileOps(FileOps& real, int fail_at, Mode mode) : real_(real), fail_at_(fail_at), mode_(mode) {}

  // As on a file system where a file has one name.
  void take_links_away() { has_links_ = false; }
  int num_operations() const { return count_; }
  bool failed() const { return count_ > fail_at_; }

  int create(const std::string& path) override {
    step("create");
    return real_.create(path);
  }
  int open(const std::string& path) override {
    step("open");
    return real_.open(path);
  }
  void write(int fd, std::uint64_t offset, std::span<const std::byte> bytes) override {
    step("write", [&] { real_.write(fd, offset, bytes.first(bytes.size() / 2)); });
    real_.write(fd, offset, bytes);
  }
  void read(int fd, std::uint64_t offset, std::span<std::byte> bytes) override {
    step("read");
    real_.read(fd, offset, bytes);
  }
  std::uint64_t size(int fd) override {
    step("size");
    return real_.size(fd);
  }
  void truncate(int fd, std::uint64_t size) override {
    step("truncate");
    real_.truncate(fd, size);
  }
  void sync(int) override { step("sync"); }
  void close(int fd) override {
    step("close", [&] { real_.close(fd); });  // the descriptor is gone either way
    real_.close(fd);
  }
  bool exists(const std::string& path) override {
    step("exists");
    return real_.exists(path);
  }
  void rename(const std::string& from, const std::string& to) override {
    step("rename");
    real_.rename(from, to);
  }
  bool link(const std::string& from, const std::string& to) override {
    step("link");
    return has_links_ && real_.link(from, to);
  }
  void sync_directory(const std::string&) override { step("sync_directory"); }
  void remove(const std::string& path) override {
    step("remove");
    real_.remove(path);
  }

 private:
  void step(
      const char* operation, const std::function<void()>& half_done = [] {}) {
    const int number = count_++;
    const bool fails = mode_ == Mode::fail_on ? number >= fail_at_ : number == fail_at_;
    if (!fails) return;
    half_done();
    if (mode_ == Mode::end_process) ::_exit(stopped_status);
    throw EnvironmentError("operation " + std::to_string(number) + ", " + operation + ", was made to fail");
  }

  FileOps& real_;
  int fail_at_;
  Mode mode_;
  int count_ = 0;
  bool has_links_ = true;
};

}  // namespace noiseloom
