// Whether the shell leaves the image libraries enough address space (ulimit -v). They take about 400 MB before main()
// begins, and where there is less, one of them aborts from a thread of its own, without a word of what is missing.
#pragma once

#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>

namespace noiseloom {

// Says so where it does not. Works before any library has been set up: it allocates nothing and uses no stream.
inline bool enough_address_space() {
  constexpr rlim_t least = 500'000'000;
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY || limit.rlim_cur >= least) return true;
  char text[256];
  const int length = std::snprintf(text, sizeof text,
                                   "out of memory: this shell allows a process %llu MB of address space (ulimit -v), "
                                   "and the image libraries alone take about 400; accepted: %llu MB and more\n",
                                   static_cast<unsigned long long>(limit.rlim_cur / 1'000'000),
                                   static_cast<unsigned long long>(least / 1'000'000));
  [[maybe_unused]] const ssize_t done = ::write(STDERR_FILENO, text, static_cast<std::size_t>(length));
  return false;
}

}  // namespace noiseloom
