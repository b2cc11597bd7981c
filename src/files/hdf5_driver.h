// A virtual file driver: HDF5 moves its bytes through FileOps, on a descriptor that the caller opened and will close.
//
// A write that fails is kept and not shown to HDF5: the library cannot close a file that it cannot flush, would try
// again at exit, and all that is at stake is a temporary file. From the first failure on nothing more is written; the
// caller asks with rethrow().
#pragma once

#include <exception>
#include <memory>
#include <string>

#include "files/hdf5_handle.h"
#include "noiseloom/files/file_ops.h"

namespace noiseloom::hdf5 {

class DriverFile {
 public:
  DriverFile(FileOps& ops, int fd) : ops_(ops), fd_(fd) {}
  void read(std::uint64_t offset, std::span<std::byte> bytes) { ops_.read(fd_, offset, bytes); }
  void write(std::uint64_t offset, std::span<const std::byte> bytes) noexcept;
  void truncate(std::uint64_t size) noexcept;
  std::uint64_t size() { return ops_.size(fd_); }
  // Drops everything that is still to come: for a file that is being given up.
  void abandon() { dead_ = true; }
  // Throws what the first failed write threw, if one did.
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  FileOps& ops_;
  int fd_;
  bool dead_ = false;
  std::exception_ptr error_;
};

// `fcpl` and `fapl` are the caller's lists (the driver is set on fapl); `name` stands in messages only.
Handle create_file(const std::shared_ptr<DriverFile>& file, const std::string& name, hid_t fcpl, hid_t fapl);
Handle open_file(const std::shared_ptr<DriverFile>& file, const std::string& name, hid_t fapl);

}  // namespace noiseloom::hdf5
