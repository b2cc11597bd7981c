#include "noiseloom/files/file_ops.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <map>
#include <mutex>
#include <system_error>

#include "noiseloom/core/error.h"
#include "noiseloom/core/extents.h"

namespace noiseloom {
namespace {

constexpr std::size_t largest_transfer = std::size_t{1} << 30;  // Linux moves less than 2 GiB in one call

[[noreturn]] void fail(const std::string& path, const std::string& doing, int error) {
  std::string text = path + ": cannot " + doing + ": " + std::system_category().message(error);
  if (error == EFBIG) text += " (a limit of the file system, or of the shell: ulimit -f)";
  throw EnvironmentError(text);
}

class PosixFileOps final : public FileOps {
 public:
  int create(const std::string& path) override {
    return remember(::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666), path, "create");
  }

  int open(const std::string& path) override {
    return remember(::open(path.c_str(), O_RDONLY | O_CLOEXEC), path, "open");
  }

  void write(int fd, std::uint64_t offset, std::span<const std::byte> bytes) override {
    while (!bytes.empty()) {
      const ssize_t done = ::pwrite(fd, bytes.data(), std::min(bytes.size(), largest_transfer), narrow<off_t>(offset));
      if (done < 0 && errno == EINTR) continue;
      if (done < 0) fail(path_of(fd), "write", errno);
      bytes = bytes.subspan(static_cast<std::size_t>(done));
      offset += static_cast<std::uint64_t>(done);
    }
  }

  void read(int fd, std::uint64_t offset, std::span<std::byte> bytes) override {
    while (!bytes.empty()) {
      const ssize_t done = ::pread(fd, bytes.data(), std::min(bytes.size(), largest_transfer), narrow<off_t>(offset));
      if (done < 0 && errno == EINTR) continue;
      if (done < 0) fail(path_of(fd), "read", errno);
      if (done == 0) {
        throw EnvironmentError(path_of(fd) + ": cannot read: ends at byte " + std::to_string(offset) + ", " +
                               std::to_string(bytes.size()) + " bytes too early");
      }
      bytes = bytes.subspan(static_cast<std::size_t>(done));
      offset += static_cast<std::uint64_t>(done);
    }
  }

  std::uint64_t size(int fd) override {
    struct stat status {};
    if (::fstat(fd, &status) != 0) fail(path_of(fd), "find the size", errno);
    return narrow<std::uint64_t>(status.st_size);
  }

  void truncate(int fd, std::uint64_t size) override {
    while (::ftruncate(fd, narrow<off_t>(size)) != 0) {
      if (errno != EINTR) fail(path_of(fd), "set the length", errno);
    }
  }

  void sync(int fd) override {
    // Not repeated after a failure: the kernel may have dropped the unwritten pages and would then report success.
    if (::fsync(fd) != 0) fail(path_of(fd), "write to disk", errno);
  }

  void close(int fd) override {
    const std::string path = forget(fd);
    if (::close(fd) != 0 && errno != EINTR) fail(path, "close", errno);
  }

  bool exists(const std::string& path) override {
    struct stat status {};
    if (::lstat(path.c_str(), &status) == 0) return true;
    if (errno != ENOENT && errno != ENOTDIR) fail(path, "look up", errno);
    return false;
  }

  void rename(const std::string& from, const std::string& to) override {
    if (std::rename(from.c_str(), to.c_str()) != 0) fail(from, "rename to " + to, errno);
  }

  void sync_directory(const std::string& path) override {
    const int fd = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0) fail(path, "open the folder", errno);
    const int error = ::fsync(fd) == 0 ? 0 : errno;
    ::close(fd);
    // Some network file systems know no fsync of folders; they make renames durable by themselves.
    if (error != 0 && error != EINVAL && error != ENOTSUP) fail(path, "write the folder to disk", error);
  }

  void remove(const std::string& path) override {
    if (::unlink(path.c_str()) != 0) fail(path, "remove", errno);
  }

 private:
  int remember(int fd, const std::string& path, const char* doing) {
    if (fd < 0) fail(path, doing, errno);
    const std::lock_guard lock(mutex_);
    paths_[fd] = path;
    return fd;
  }

  std::string path_of(int fd) {
    const std::lock_guard lock(mutex_);
    const auto found = paths_.find(fd);
    return found == paths_.end() ? "file " + std::to_string(fd) : found->second;
  }

  std::string forget(int fd) {
    const std::string path = path_of(fd);
    const std::lock_guard lock(mutex_);
    paths_.erase(fd);
    return path;
  }

  std::mutex mutex_;
  std::map<int, std::string> paths_;  // of the open descriptors, for messages
};

}  // namespace

FileOps& posix_file_ops() {
  static PosixFileOps ops;
  return ops;
}

std::string parent_directory(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

}  // namespace noiseloom
