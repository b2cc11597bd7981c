#include "noiseloom/core/standard_streams.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>

#include "noiseloom/core/error.h"

namespace noiseloom {

void reserve_standard_streams() {
  // open() gives the lowest free number, so that going upward fills exactly the gaps. Read-only, the null device
  // answers every write with an error.
  for (int fd = 0; fd <= STDERR_FILENO; ++fd)
    if (::fcntl(fd, F_GETFD) == -1 && errno == EBADF && ::open("/dev/null", O_RDONLY) == -1) return;
}

void flush_standard_output() {
  errno = 0;
  const bool flushed = std::fflush(stdout) == 0;
  if (flushed && std::ferror(stdout) == 0) return;
  const std::string words = errno != 0 ? std::strerror(errno) : "an earlier write failed";
  throw EnvironmentError("standard output: cannot be written: " + words);
}

}  // namespace noiseloom
