// Preloaded into a program under test: the process is killed (SIGKILL) just before its k-th operation on a file whose
// name contains a given part. KILL_AT = k counts from 1; KILL_PART = part of the name. With KILL_SIGNAL = n it gets
// that signal instead (SIGSTOP suspends it there). With COUNT_FILE set, the number of operations is written there at
// exit.

#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

namespace {

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

std::atomic<long> operations{0};

void count(const char* path) {
  const char* part = std::getenv("KILL_PART");
  if (part == nullptr || path == nullptr || std::strstr(path, part) == nullptr) return;
  const long number = ++operations;
  const char* at = std::getenv("KILL_AT");
  const char* instead = std::getenv("KILL_SIGNAL");
  if (at != nullptr && number == std::atol(at)) kill(getpid(), instead != nullptr ? std::atoi(instead) : SIGKILL);
}

void count_fd(int fd) {
  char path[4096] = {};
  const std::string link = "/proc/self/fd/" + std::to_string(fd);
  if (readlink(link.c_str(), path, sizeof(path) - 1) > 0) count(path);
}

struct AtExit {
  ~AtExit() {
    const char* file = std::getenv("COUNT_FILE");
    if (file == nullptr) return;
    if (FILE* out = std::fopen(file, "w")) {
      std::fprintf(out, "%ld\n", operations.load());
      std::fclose(out);
    }
  }
} at_exit;

}  // namespace

extern "C" {

ssize_t pwrite(int fd, const void* data, size_t size, off_t offset) {
  count_fd(fd);
  return next<ssize_t(int, const void*, size_t, off_t)>("pwrite")(fd, data, size, offset);
}
ssize_t pwrite64(int fd, const void* data, size_t size, off64_t offset) {
  count_fd(fd);
  return next<ssize_t(int, const void*, size_t, off64_t)>("pwrite64")(fd, data, size, offset);
}
int ftruncate(int fd, off_t size) noexcept {
  count_fd(fd);
  return next<int(int, off_t)>("ftruncate")(fd, size);
}
int ftruncate64(int fd, off64_t size) noexcept {
  count_fd(fd);
  return next<int(int, off64_t)>("ftruncate64")(fd, size);
}
int fsync(int fd) {
  count_fd(fd);
  return next<int(int)>("fsync")(fd);
}
int rename(const char* from, const char* to) noexcept {
  count(to);
  return next<int(const char*, const char*)>("rename")(from, to);
}
int link(const char* from, const char* to) noexcept {
  count(to);
  return next<int(const char*, const char*)>("link")(from, to);
}
int unlink(const char* path) noexcept {
  count(path);
  return next<int(const char*)>("unlink")(path);
}
int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = va_arg(arguments, mode_t);
  va_end(arguments);
  count(path);
  return next<int(const char*, int, ...)>("open")(path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = va_arg(arguments, mode_t);
  va_end(arguments);
  count(path);
  return next<int(const char*, int, ...)>("open64")(path, flags, mode);
}
}
