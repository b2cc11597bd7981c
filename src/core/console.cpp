#include "noiseloom/core/console.h"

#include <poll.h>
#include <unistd.h>

#include <cerrno>

namespace noiseloom {
namespace {

constexpr int patience_ms = 5000;

// True when a descriptor that does not block (a pipe that another program set so) takes bytes again.
bool takes_more(int descriptor) {
  pollfd entry{descriptor, POLLOUT, 0};
  return ::poll(&entry, 1, patience_ms) > 0;
}

}  // namespace

int write_text(int descriptor, std::string_view text) noexcept {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written >= 0) {
      text.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
      if (!takes_more(descriptor)) return EAGAIN;
    } else if (errno != EINTR) {
      return errno;
    }
  }
  return 0;
}

void print_error(std::string_view text) noexcept { write_text(STDERR_FILENO, text); }

}  // namespace noiseloom
