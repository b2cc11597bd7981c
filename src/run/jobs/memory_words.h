// Words for the moment when memory runs out: std::bad_alloc says neither what for nor how much there was.
#pragma once

#include <new>
#include <string>
#include <system_error>

#include "noiseloom/core/error.h"

namespace noiseloom {

// "out of memory while taking up the texture: this process holds 3.2 GiB ...".
std::string out_of_memory_text(const std::string& doing);
std::string no_threads_text(const std::string& doing, const std::string& system_words);

// Calls body(). Throws EnvironmentError in such words in place of std::bad_alloc, and of what the standard library
// throws when the system has no memory or no thread left. Every other failure (of a file, say) passes as it is. `doing`
// completes "while ...".
template <class Body>
void naming_shortage(const std::string& doing, const Body& body) {
  try {
    body();
  } catch (const std::bad_alloc&) {
    throw EnvironmentError(out_of_memory_text(doing));
  } catch (const std::system_error& error) {
    if (error.code() == std::errc::not_enough_memory) throw EnvironmentError(out_of_memory_text(doing));
    if (error.code() != std::errc::resource_unavailable_try_again) throw;
    throw EnvironmentError(no_threads_text(doing, error.code().message()));
  }
}

}  // namespace noiseloom
