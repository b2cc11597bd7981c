#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <ctime>
#include <string>
#include <system_error>

#include "noiseloom/files/run_file.h"

namespace noiseloom {
namespace {

std::string holder_text() {
  char host[256] = "unknown host";
  ::gethostname(host, sizeof host - 1);
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  char since[32] = {};
  std::strftime(since, sizeof since, "%Y-%m-%d %H:%M:%S UTC", &utc);
  return "process " + std::to_string(::getpid()) + " on " + host + ", since " + since;
}

std::string read_holder(int fd) {
  char text[512] = {};
  const ssize_t bytes = ::pread(fd, text, sizeof text - 1, 0);
  std::string holder(text, bytes > 0 ? static_cast<std::size_t>(bytes) : 0);
  while (!holder.empty() && holder.back() == '\n') holder.pop_back();
  return holder.empty() ? "a run that has just started" : holder;
}

int open_lock_file(const std::string& lock_path) {
  const int fd = ::open(lock_path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (fd >= 0) return fd;
  const int error = errno;
  const std::string folder = parent_directory(lock_path);
  if (error == ENOENT || error == ENOTDIR) throw UserError(folder, "there is no such folder to write into");
  throw EnvironmentError(folder + ": cannot write into this folder (" + lock_path +
                         "): " + std::system_category().message(error));
}

enum class Attempt { locked, held, unsupported };

Attempt try_lock(int fd, const std::string& lock_path) {
  while (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
    if (errno == EINTR) continue;
    if (errno == EWOULDBLOCK) return Attempt::held;
    if (errno == ENOSYS || errno == ENOLCK || errno == EOPNOTSUPP) return Attempt::unsupported;
    throw EnvironmentError(lock_path + ": cannot lock: " + std::system_category().message(errno));
  }
  return Attempt::locked;
}

// False where the file was removed by its former holder between our opening and our locking it.
bool still_there(int fd, const std::string& lock_path) {
  struct stat ours {};
  struct stat there {};
  return ::fstat(fd, &ours) == 0 && ::stat(lock_path.c_str(), &there) == 0 && ours.st_ino == there.st_ino &&
         ours.st_dev == there.st_dev;
}

}  // namespace

RunLock::RunLock(const std::string& path) : lock_path_(path + ".lock") {
  for (;;) {
    fd_ = open_lock_file(lock_path_);
    try {
      const Attempt attempt = try_lock(fd_, lock_path_);
      if (attempt == Attempt::held) {
        throw UserError(path, "another run is writing it: " + read_holder(fd_) + "; wait for it or stop it first");
      }
      enforced_ = attempt == Attempt::locked;
    } catch (...) {
      ::close(fd_);
      throw;
    }
    if (!enforced_ || still_there(fd_, lock_path_)) break;
    ::close(fd_);
  }
  // Only a courtesy to whoever comes second: that it cannot be written is no reason to stop.
  const std::string text = holder_text() + "\n";
  if (::ftruncate(fd_, 0) == 0) [[maybe_unused]]
    const ssize_t written = ::pwrite(fd_, text.data(), text.size(), 0);
}

RunLock::~RunLock() {
  ::unlink(lock_path_.c_str());  // while it is still held, so that nobody else's file is removed
  ::close(fd_);
}

}  // namespace noiseloom
