#include "noiseloom/core/apart.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

void bound_memory(std::uintmax_t more) {
  std::uintmax_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const std::uintmax_t used = pages * static_cast<std::uintmax_t>(::sysconf(_SC_PAGESIZE));
  rlimit bound{};
  if (used == 0 || more > std::numeric_limits<std::uintmax_t>::max() - used || ::getrlimit(RLIMIT_AS, &bound) != 0)
    return;
  bound.rlim_cur = std::min<std::uintmax_t>(bound.rlim_cur, used + more);
  ::setrlimit(RLIMIT_AS, &bound);
}

bool write_all(int file, const std::string& bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ::ssize_t count = ::write(file, bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno != EINTR) return false;
    done += static_cast<std::size_t>(std::max<::ssize_t>(count, 0));
  }
  return true;
}

std::string read_all(int file) {
  std::string bytes(static_cast<std::size_t>(std::max<::off_t>(::lseek(file, 0, SEEK_END), 0)), '\0');
  for (std::size_t done = 0; done < bytes.size();) {
    const ::ssize_t count = ::pread(file, bytes.data() + done, bytes.size() - done, static_cast<::off_t>(done));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0)
      throw EnvironmentError(std::string("what another process wrote cannot be read: ") + std::strerror(errno));
    done += static_cast<std::size_t>(count);
  }
  return bytes;
}

}  // namespace

ApartResult run_apart(const std::function<std::string()>& body, std::uintmax_t more_memory) {
  struct File {
    int number = ::memfd_create("noiseloom", MFD_CLOEXEC);
    ~File() {
      if (number >= 0) ::close(number);
    }
  } file;
  const ::pid_t child = file.number < 0 ? -1 : ::fork();
  if (child < 0) throw EnvironmentError(std::string("cannot start a process: ") + std::strerror(errno));
  if (child == 0) {
    // No core files, and nothing but this is done here: no destructor, no buffer of the parent's.
    const rlimit none{0, 0};
    ::setrlimit(RLIMIT_CORE, &none);
    bound_memory(more_memory);
    bool is_written = false;
    try {
      is_written = write_all(file.number, body());
    } catch (...) {  // said by the status
    }
    ::_exit(is_written ? 0 : 1);
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR) throw EnvironmentError(std::string("cannot wait for a process: ") + std::strerror(errno));
  if (WIFSIGNALED(status)) return {.is_whole = false, .signal = WTERMSIG(status), .bytes = {}};
  if (WEXITSTATUS(status) != 0) return {};
  return {.is_whole = true, .signal = 0, .bytes = read_all(file.number)};
}

}  // namespace noiseloom
