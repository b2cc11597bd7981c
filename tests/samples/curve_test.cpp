#include "samples/curve.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "noiseloom/samples/sample_space.h"

namespace noiseloom {
namespace {

// The middles of all cells of a grid of `side` cells each way, in the order of the curve.
std::vector<std::array<float, 4>> cells_along(Curve curve, int dimensions, int side) {
  std::vector<std::pair<std::uint64_t, std::array<float, 4>>> cells;
  const auto count = static_cast<int>(std::lround(std::pow(side, dimensions)));
  for (int k = 0; k < count; ++k) {
    std::array<float, 4> middle{};
    int rest = k;
    for (int axis = 0; axis < dimensions; ++axis, rest /= side) {
      middle[static_cast<std::size_t>(axis)] = (static_cast<float>(rest % side) + 0.5F) / static_cast<float>(side);
    }
    cells.emplace_back(curve_place(curve, dimensions, middle.data()), middle);
  }
  std::sort(cells.begin(), cells.end());
  std::vector<std::array<float, 4>> result;
  for (const auto& [place, middle] : cells) result.push_back(middle);
  return result;
}

// It visits all cells, each step to a cell that shares a side: only a Hilbert curve, in whatever orientation, does so
// at every level at once.
TEST(Curve, HilbertStepsToANeighbourAtEveryLevel) {
  for (const int dimensions : {2, 3, 4}) {
    for (const int side : {2, 4, 8}) {
      const auto cells = cells_along(Curve::hilbert, dimensions, side);
      for (std::size_t k = 1; k < cells.size(); ++k) {
        float moved = 0;
        for (std::size_t axis = 0; axis < 4; ++axis) moved += std::fabs(cells[k][axis] - cells[k - 1][axis]);
        ASSERT_FLOAT_EQ(moved * static_cast<float>(side), 1) << dimensions << " dimensions, step " << k;
      }
    }
  }
}

TEST(Curve, MortonInterleavesTheBitsOfACell) {
  const std::array<float, 2> point = {0.25F, 0.5F};  // bits 01 and 10, the first axis lowest
  EXPECT_EQ(curve_place(Curve::morton, 2, point.data()) >> 44, 0b1001U);
  const std::array<float, 3> other = {0.75F, 0.5F, 0.25F};  // 11, 10, 01
  EXPECT_EQ(curve_place(Curve::morton, 3, other.data()) >> 57, 0b011101U);
}

// The strata of 4^k samples of the square are the cells of a grid, so that neighbours along the curve are neighbours
// there; and the samples are those that other methods place.
TEST(Curve, ListsHoldTheSamplesOfTheSpaceInTheOrderOfTheCurve) {
  for (const int channels : {2, 3, 4}) {
    SampleSpec spec;
    spec.space = "vector" + std::to_string(channels);
    const std::vector<float> plain = SampleSource(spec, 4096, 2, 1).list(SliceIndex(1));
    spec.curve = Curve::hilbert;
    const std::vector<float> sorted = SampleSource(spec, 4096, 2, 1).list(SliceIndex(1));
    ASSERT_EQ(sorted.size(), plain.size());
    const auto step = static_cast<std::size_t>(channels);
    std::vector<std::vector<float>> a;
    std::vector<std::vector<float>> b;
    for (std::size_t i = 0; i < plain.size(); i += step) {
      a.emplace_back(&plain[i], &plain[i] + step);
      b.emplace_back(&sorted[i], &sorted[i] + step);
    }
    const double side = std::round(std::pow(4096, 1.0 / channels));
    for (std::size_t k = 1; k < b.size(); ++k) {
      double moved = 0;
      for (std::size_t c = 0; c < step; ++c) {
        moved += std::fabs(std::floor(static_cast<double>(b[k][c]) * side) -
                           std::floor(static_cast<double>(b[k - 1][c]) * side));
      }
      ASSERT_EQ(moved, 1) << channels << " channels, step " << k;
    }
    std::sort(a.begin(), a.end());
    std::sort(b.begin(), b.end());
    EXPECT_EQ(a, b);
  }
}

}  // namespace
}  // namespace noiseloom
