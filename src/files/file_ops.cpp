#include "noiseloom/files/file_ops.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <map>
#include <mutex>
#include <system_error>

#include "files/system_call.h"
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

// Names of one and the same file.
bool same_file(const struct stat& a, const std::string& path) {
  struct stat b {};
  return ::lstat(path.c_str(), &b) == 0 && a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

// Moves whole ranges with a call that may move less: `call` is given what is left and the offset.
template <class Byte, class Call>
std::size_t move_all(std::span<Byte> bytes, std::uint64_t offset, Call call, int& error) {
  std::size_t moved = 0;
  while (moved < bytes.size()) {
    const std::span<Byte> left = bytes.subspan(moved).first(std::min(bytes.size() - moved, largest_transfer));
    const ssize_t done = uninterrupted([&] { return call(left, narrow<off_t>(offset + moved)); });
    error = done < 0 ? errno : 0;
    if (done <= 0) break;
    moved += static_cast<std::size_t>(done);
  }
  return moved;
}

class PosixFileOps final : public FileOps {
 public:
  int create(const std::string& path) override {
    return remember(uninterrupted([&] { return ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666); }),
                    path, "create");
  }

  int open(const std::string& path) override {
    return remember(uninterrupted([&] { return ::open(path.c_str(), O_RDONLY | O_CLOEXEC); }), path, "open");
  }

  void write(int fd, std::uint64_t offset, std::span<const std::byte> bytes) override {
    int error = 0;
    const auto call = [&](std::span<const std::byte> left, off_t at) {
      return ::pwrite(fd, left.data(), left.size(), at);
    };
    if (move_all(bytes, offset, call, error) == bytes.size()) return;
    fail(path_of(fd), "write", error != 0 ? error : ENOSPC);  // nothing was written and no reason given
  }

  void read(int fd, std::uint64_t offset, std::span<std::byte> bytes) override {
    int error = 0;
    const auto call = [&](std::span<std::byte> left, off_t at) { return ::pread(fd, left.data(), left.size(), at); };
    const std::size_t moved = move_all(bytes, offset, call, error);
    if (moved == bytes.size()) return;
    if (error != 0) fail(path_of(fd), "read", error);
    throw EnvironmentError(path_of(fd) + ": cannot read: ends at byte " + std::to_string(offset + moved) + ", " +
                           std::to_string(bytes.size() - moved) + " bytes too early");
  }

  std::uint64_t size(int fd) override {
    struct stat status {};
    if (uninterrupted([&] { return ::fstat(fd, &status); }) != 0) fail(path_of(fd), "find the size", errno);
    return narrow<std::uint64_t>(status.st_size);
  }

  void truncate(int fd, std::uint64_t size) override {
    if (uninterrupted([&] { return ::ftruncate(fd, narrow<off_t>(size)); }) != 0) {
      fail(path_of(fd), "set the length", errno);
    }
  }

  void sync(int fd) override {
    // Repeated after a signal only: after any other failure the kernel may have dropped the pages that it could not
    // write, and would then report success.
    if (uninterrupted([&] { return ::fsync(fd); }) != 0) fail(path_of(fd), "write to disk", errno);
  }

  void close(int fd) override {
    const std::string path = forget(fd);
    // Never repeated: Linux gives the descriptor up even where it reports a signal, and another thread may have it.
    if (::close(fd) != 0 && errno != EINTR) fail(path, "close", errno);
  }

  bool exists(const std::string& path) override {
    struct stat status {};
    if (uninterrupted([&] { return ::lstat(path.c_str(), &status); }) == 0) return true;
    if (errno != ENOENT && errno != ENOTDIR) fail(path, "look up", errno);
    return false;
  }

  void rename(const std::string& from, const std::string& to) override {
    struct stat source {};
    const bool known = ::lstat(from.c_str(), &source) == 0;
    if (uninterrupted([&] { return std::rename(from.c_str(), to.c_str()); }) == 0) return;
    const int error = errno;
    // An interrupted call, or one that a network file system sent twice, finds that it is done already.
    if (error == ENOENT && known && same_file(source, to)) return;
    fail(from, "rename to " + to, error);
  }

  bool link(const std::string& from, const std::string& to) override {
    if (uninterrupted([&] { return ::link(from.c_str(), to.c_str()); }) == 0) return true;
    const int error = errno;
    struct stat source {};
    if (error == EEXIST && ::lstat(from.c_str(), &source) == 0 && same_file(source, to)) return true;
    // EPERM: FAT and its like, and files of other people where the system protects them (fs.protected_hardlinks).
    for (const int none : {EPERM, EACCES, ENOSYS, EOPNOTSUPP, ENOTSUP, EMLINK, EXDEV, EINVAL}) {
      if (error == none) return false;
    }
    fail(from, "give a second name (" + to + ")", error);
  }

  void sync_directory(const std::string& path) override {
    const int fd = uninterrupted([&] { return ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); });
    if (fd < 0) fail(path, "open the folder", errno);
    const int error = uninterrupted([&] { return ::fsync(fd); }) == 0 ? 0 : errno;
    ::close(fd);
    // Some network file systems know no fsync of folders; they make renames durable by themselves.
    if (error != 0 && error != EINVAL && error != ENOTSUP) fail(path, "write the folder to disk", error);
  }

  void remove(const std::string& path) override {
    bool again = false;  // an interrupted call may have removed the file
    const auto call = [&] {
      const int result = ::unlink(path.c_str());
      const bool gone = again && result < 0 && errno == ENOENT;
      again = true;
      return gone ? 0 : result;
    };
    if (uninterrupted(call) != 0) fail(path, "remove", errno);
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

std::string follow_links(const std::string& path) {
  constexpr int most_links = 40;  // as the kernel itself
  std::string at = path;
  for (int links = 0; links < most_links; ++links) {
    std::string target(PATH_MAX, '\0');
    const ssize_t length = uninterrupted([&] { return ::readlink(at.c_str(), target.data(), target.size()); });
    if (length < 0) return at;  // no link, or nothing there: what opens it says what is wrong
    target.resize(static_cast<std::size_t>(length));
    if (target.starts_with('/')) {
      at = target;
    } else {
      at = at.find('/') == std::string::npos ? target : parent_directory(at) + "/" + target;
    }
  }
  fail(path, "follow the symbolic link", ELOOP);
}

}  // namespace noiseloom
