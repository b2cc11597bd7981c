// Work that may crash, done in a process of its own: libraries that read the files of users are not all safe from what
// a damaged file says, and one that crashes must not take the program with it.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>

namespace noiseloom {

struct ApartResult {
  bool is_whole = false;  // body came to its end
  int signal = 0;         // that ended it before; 0 for an exception
  std::string bytes = {};
};

// Calls `body` in a copy of this process and gives the bytes that it returned; nothing else that it does is seen here.
// The copy may take `more_memory` bytes of address space beyond what it begins with. Throws EnvironmentError where
// there can be no copy. No other thread may be at work meanwhile.
ApartResult run_apart(const std::function<std::string()>& body,
                      std::uintmax_t more_memory = std::numeric_limits<std::uintmax_t>::max());

}  // namespace noiseloom
