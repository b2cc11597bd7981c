// Messages of programs whose work must survive the loss of whatever they write to: a log on a full disk, a reader that
// went away, a descriptor that was never open. (The streams of stdio throw or keep a part for later.)
#pragma once

#include <string_view>

namespace noiseloom {

// Writes all of `text` to a descriptor, past the buffers of stdio. Returns 0, or the errno of the write that failed
// (EPIPE: nobody reads any more). A descriptor that takes nothing for five seconds counts as failed, with EAGAIN.
int write_text(int descriptor, std::string_view text) noexcept;

// To standard error. What cannot be written is lost: a message is never worth the work that it reports on.
void print_error(std::string_view text) noexcept;

}  // namespace noiseloom
