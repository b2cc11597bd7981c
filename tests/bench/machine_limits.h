// What this machine allows a candidate at most, measured in the same run as the candidates are.
#pragma once

#include <cstddef>

#include "noiseloom/problem/value_kernel.h"

namespace noiseloom {

// Blocks that the arithmetic is measured on: so many of weights, and of each channel at either end.
inline constexpr std::size_t limit_blocks = 16;

// Seconds that the arithmetic of one block takes (16 taps, at both ends): the code of the inner loop itself, on blocks
// that lie aligned in the first cache, in one stream without an end. The best of some rounds.
double seconds_per_block(const ValueKernel& kernel);

// Seconds that one line of 64 bytes takes out of the second cache, where the next ones are known. The best of some
// rounds.
double seconds_per_line();

}  // namespace noiseloom
