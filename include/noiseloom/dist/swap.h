// What a visit does to a slice: the unit that travels between ranks.
#pragma once

#include <cstdint>
#include <vector>

#include "noiseloom/core/extents.h"

namespace noiseloom {

// The samples of two cells of one slice change places.
struct Swap {
  std::uint32_t a;
  std::uint32_t b;
  friend bool operator==(const Swap&, const Swap&) = default;
};

struct SliceSwaps {
  SliceIndex slice;
  std::vector<Swap> swaps;  // in the order in which they were made
};

// The fewest swaps that do the same to a slice of `num_cells` cells: at most num_cells - 1, where a hot visit makes
// several for every cell.
std::vector<Swap> fewest_swaps(const std::vector<Swap>& swaps, std::int64_t num_cells);

}  // namespace noiseloom
