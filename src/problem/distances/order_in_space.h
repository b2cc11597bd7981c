// Samples in an order in which neighbours are near each other in their space.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace noiseloom {

// Indices of the samples of `list`, [sample][channel], fewer than 2^32: by the bits of their ranks along each channel
// (the first eight), interleaved [Morton66]. The order depends on the values of the samples alone, but where these are
// within a step of the ranks: there on their order in the list. Takes 20 bytes a sample for its time.
std::vector<std::uint32_t> order_in_space(std::span<const float> list, int channels);

}  // namespace noiseloom
