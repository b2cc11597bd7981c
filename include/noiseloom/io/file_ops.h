// Every operation on files that a checkpoint needs, behind one small interface, so that a test can make the k-th of
// them fail or stop.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace noiseloom {

// All functions throw EnvironmentError with the path and the system's own words.
class FileOps {
 public:
  virtual ~FileOps() = default;
  // Opens for reading and writing; with create, the file must not exist.
  virtual int open(const std::string& path, bool create) = 0;
  virtual void write(int fd, std::uint64_t offset, std::span<const std::byte> bytes) = 0;  // whole, or throws
  virtual void read(int fd, std::uint64_t offset, std::span<std::byte> bytes) = 0;         // whole, or throws
  virtual std::uint64_t size(int fd) = 0;
  virtual void truncate(int fd, std::uint64_t size) = 0;
  virtual void sync(int fd) = 0;
  virtual void close(int fd) = 0;
  virtual void rename(const std::string& from, const std::string& to) = 0;
  virtual void sync_directory(const std::string& path) = 0;
  virtual void remove(const std::string& path) = 0;
};

// The real file system.
FileOps& posix_file_ops();

}  // namespace noiseloom
