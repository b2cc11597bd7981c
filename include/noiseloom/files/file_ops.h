// Every operation on files that a checkpoint needs, behind one small interface, so that a test can make the k-th of
// them fail or stop.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace noiseloom {

// All functions throw EnvironmentError with the path and the system's own words. A call that a signal interrupted is
// repeated, and counts as done where the interrupted one turns out to have done it. A write past a file size limit
// fails like any other only where SIGXFSZ is ignored; main() does that.
class FileOps {
 public:
  virtual ~FileOps() = default;
  virtual int create(const std::string& path) = 0;  // for reading and writing; the file must not exist
  virtual int open(const std::string& path) = 0;    // for reading
  virtual void write(int fd, std::uint64_t offset, std::span<const std::byte> bytes) = 0;  // whole, or throws
  virtual void read(int fd, std::uint64_t offset, std::span<std::byte> bytes) = 0;         // whole, or throws
  virtual std::uint64_t size(int fd) = 0;
  virtual void truncate(int fd, std::uint64_t size) = 0;  // shorter, or longer with zeros
  virtual void sync(int fd) = 0;                          // to the disk itself
  virtual void close(int fd) = 0;                         // the descriptor is gone even when this throws
  virtual bool exists(const std::string& path) = 0;
  virtual void rename(const std::string& from, const std::string& to) = 0;  // replaces `to`
  // A second name for a file. False where the file system, or the system for this file, allows none.
  virtual bool link(const std::string& from, const std::string& to) = 0;
  virtual void sync_directory(const std::string& path) = 0;  // makes renames survive a power cut
  virtual void remove(const std::string& path) = 0;
};

// The real file system. Threads may use it together.
FileOps& posix_file_ops();

// The folder part of a path: "." where there is none.
std::string parent_directory(const std::string& path);

// Where a file written to `path` ends up: symbolic links are followed, also one whose target does not exist yet. Links
// among the folders stay as they are. Throws EnvironmentError, for links that lead in a circle too.
std::string follow_links(const std::string& path);

}  // namespace noiseloom
