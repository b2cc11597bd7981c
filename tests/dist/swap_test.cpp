#include "noiseloom/dist/swap.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

namespace noiseloom {
namespace {

std::vector<std::uint32_t> carried_out(const std::vector<Swap>& swaps, std::uint32_t num_cells) {
  std::vector<std::uint32_t> cells(num_cells);
  std::iota(cells.begin(), cells.end(), 0U);
  for (const Swap& swap : swaps) std::swap(cells[swap.a], cells[swap.b]);
  return cells;
}

TEST(FewestSwaps, DoTheSame) {
  std::mt19937 engine(5);
  for (const std::uint32_t num_cells : {1U, 2U, 3U, 97U}) {
    for (const int count : {0, 1, 5, 1000}) {
      std::vector<Swap> swaps;
      for (int k = 0; k < count; ++k) {
        swaps.push_back(
            {static_cast<std::uint32_t>(engine() % num_cells), static_cast<std::uint32_t>(engine() % num_cells)});
      }
      const std::vector<Swap> fewest = fewest_swaps(swaps, num_cells);
      EXPECT_EQ(carried_out(fewest, num_cells), carried_out(swaps, num_cells));
      EXPECT_LT(fewest.size(), num_cells);
      EXPECT_LE(fewest.size(), swaps.size());
    }
  }
}

TEST(FewestSwaps, OfSwapsThatUndoEachOtherAreNone) {
  EXPECT_TRUE(fewest_swaps({{1, 4}, {2, 3}, {3, 2}, {4, 1}}, 5).empty());
}

}  // namespace
}  // namespace noiseloom
