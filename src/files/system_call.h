// Calls of the system that a signal may interrupt.
#pragma once

#include <cerrno>

namespace noiseloom {

// The result of a system call, repeated as long as a signal interrupts it.
template <class Call>
auto uninterrupted(Call call) {
  auto result = call();
  while (result < 0 && errno == EINTR) result = call();
  return result;
}

}  // namespace noiseloom
