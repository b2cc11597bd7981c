// Preloaded into a program under test: the process is killed (SIGKILL) just before its k-th operation on a file whose
// name contains a given part. KILL_AT = k counts from 1; KILL_PART = part of the name. With KILL_SIGNAL = n it gets
// that signal instead (SIGSTOP suspends it there). With COUNT_FILE set, the number of operations is written there at
// exit. With FAIL_FROM = j and FAIL_TO = k the operations j to k fail with the error FAIL_ERRNO, as those of a network
// file system do whose server was started anew; with SLOW_MS = n each takes so many milliseconds longer. With
// CLOCK_JUMP = n the clock of the wall, and no other, is n seconds off from the operation FAIL_FROM on, which then does
// not fail.

#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
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

long number_in(const char* variable) {
  const char* text = std::getenv(variable);
  return text != nullptr ? std::atol(text) : 0;
}

// Whether the operation is to fail; errno says why.
bool fails(const char* path) {
  const char* part = std::getenv("KILL_PART");
  if (part == nullptr || path == nullptr || std::strstr(path, part) == nullptr) return false;
  const long number = ++operations;
  const char* at = std::getenv("KILL_AT");
  const char* instead = std::getenv("KILL_SIGNAL");
  if (at != nullptr && number == std::atol(at)) kill(getpid(), instead != nullptr ? std::atoi(instead) : SIGKILL);
  if (const long milliseconds = number_in("SLOW_MS"); milliseconds > 0)
    usleep(static_cast<useconds_t>(1000 * milliseconds));
  if (number < number_in("FAIL_FROM") || number > number_in("FAIL_TO") || number_in("CLOCK_JUMP") != 0) return false;
  errno = static_cast<int>(number_in("FAIL_ERRNO"));
  return true;
}

bool fails_fd(int fd) {
  char path[4096] = {};
  const std::string link = "/proc/self/fd/" + std::to_string(fd);
  return readlink(link.c_str(), path, sizeof(path) - 1) > 0 && fails(path);
}

long clock_is_off() { return operations >= number_in("FAIL_FROM") ? number_in("CLOCK_JUMP") : 0; }

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

int clock_gettime(clockid_t clock, struct timespec* now) noexcept {
  const int result = next<int(clockid_t, struct timespec*)>("clock_gettime")(clock, now);
  if (clock == CLOCK_REALTIME) now->tv_sec += clock_is_off();
  return result;
}
time_t time(time_t* now) noexcept {
  const time_t jumped = next<time_t(time_t*)>("time")(now) + clock_is_off();
  if (now != nullptr) *now = jumped;
  return jumped;
}

ssize_t pwrite(int fd, const void* data, size_t size, off_t offset) {
  if (fails_fd(fd)) return -1;
  return next<ssize_t(int, const void*, size_t, off_t)>("pwrite")(fd, data, size, offset);
}
ssize_t pwrite64(int fd, const void* data, size_t size, off64_t offset) {
  if (fails_fd(fd)) return -1;
  return next<ssize_t(int, const void*, size_t, off64_t)>("pwrite64")(fd, data, size, offset);
}
int ftruncate(int fd, off_t size) noexcept {
  if (fails_fd(fd)) return -1;
  return next<int(int, off_t)>("ftruncate")(fd, size);
}
int ftruncate64(int fd, off64_t size) noexcept {
  if (fails_fd(fd)) return -1;
  return next<int(int, off64_t)>("ftruncate64")(fd, size);
}
int fsync(int fd) {
  if (fails_fd(fd)) return -1;
  return next<int(int)>("fsync")(fd);
}
int rename(const char* from, const char* to) noexcept {
  if (fails(to)) return -1;
  return next<int(const char*, const char*)>("rename")(from, to);
}
int link(const char* from, const char* to) noexcept {
  if (fails(to)) return -1;
  return next<int(const char*, const char*)>("link")(from, to);
}
int unlink(const char* path) noexcept {
  if (fails(path)) return -1;
  return next<int(const char*)>("unlink")(path);
}
int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = va_arg(arguments, mode_t);
  va_end(arguments);
  if (fails(path)) return -1;
  return next<int(const char*, int, ...)>("open")(path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = va_arg(arguments, mode_t);
  va_end(arguments);
  if (fails(path)) return -1;
  return next<int(const char*, int, ...)>("open64")(path, flags, mode);
}
}
