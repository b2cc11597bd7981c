#include "noiseloom/construct/lattice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "construct/lattice_oracle.h"
#include "support/construct_problems.h"
#include "support/sanitizers.h"

namespace noiseloom {
namespace {

using namespace testing_support;

Lattice lattice_of(const Extents& extents, const FilterSpec& filter) {
  return *find_lattice(Footprint(extents, filter));
}

// Under a box of n pixels no texture has R below 1 / n.
TEST(Lattice, IsAllButAsGoodAsCanBeUnderSmallBoxes) {
  const std::tuple<Extents, int, double> cases[] = {
      {Extents({64, 64}), 2, 1.02},  {Extents({64, 64}), 3, 1.2},    {Extents({64, 64}), 4, 1.001},
      {Extents({64, 64}), 5, 1.2},   {Extents({64, 64}), 8, 1.001},  {Extents({96, 96}), 4, 1.001},
      {Extents({48, 48}), 4, 1.001}, {Extents({128, 32}), 4, 1.001},
  };
  for (std::size_t k = 0; k < std::size(cases); k += testing_support::stride) {
    const auto& [slice, size, most] = cases[k];
    const FilterSpec filter = product({group({0, 1}, box(size))});
    const Lattice lattice = lattice_of(slice, filter);
    const double bound = 1.0 / (size * size);
    EXPECT_GE(lattice.relative_error, 0.999 * bound);
    EXPECT_LT(lattice.relative_error, most * bound) << slice.to_string() << ", box " << size;
    EXPECT_NEAR(oracle::relative_error(slice, filter, lattice), lattice.relative_error, 0.02 * lattice.relative_error);
  }
}

// Also where many pixels have equal phases, a filter reaches over more slices than there are phases, or slices begin
// between two phases.
TEST(Lattice, HasTheErrorThatItSays) {
  const GroupSpec average = group({2}, ema(0.1, 0.1));
  const FilterSpec volume = product({group({0, 1}, box(3)), average});
  const FilterSpec added = sum({group({0, 1}, gauss(1)), average});
  const std::vector<std::pair<Extents, FilterSpec>> cases = {
      {Extents({32, 48, 6}), volume},
      {Extents({33, 35, 5}), volume},
      {Extents({31, 37, 7}), volume},
      {Extents({32, 32, 8}), added},
      {Extents({24, 30, 4, 3}), product({group({0, 1, 2, 3}, box(3))})},
      {Extents({32, 32}), product({group({0, 1}, box(8))})},
      {Extents({32, 32, 32}), product({group({0, 1}, box(2)), group({2}, box(16))})},
      {Extents({64, 1, 5}), product({group({0}, box(3)), average})},
      {Extents({1, 61}), product({group({1}, gauss(1))})},
      {Extents({32, 32, 4}), product({group({0, 1}, taps({3}, {-0.2, 1, -0.2}))})},
      {Extents({40, 24, 6}), product({group({0, 1}, box(4)), group({2}, box(2))})},
      {Extents({40, 22, 6}), product({group({0, 1}, box(4)), group({2}, gauss(0.5))})},
      {Extents({25, 35, 4}), product({group({0, 1}, box(5)), group({2}, gauss(0.8))})},
      {Extents({48, 32, 3, 2}), product({group({0, 1}, box(4)), group({2}, gauss(0.8)), group({3}, box(2))})},
      {Extents({64, 64, 6}), product({group({0, 1}, box(4)), group({2}, box(2))})},
      {Extents({37, 3}), product({group({0, 1}, box(3))})},
  };
  for (std::size_t k = 0; k < cases.size(); k += testing_support::stride) {
    const auto& [extents, filter] = cases[k];
    const Lattice lattice = lattice_of(extents, filter);
    EXPECT_NEAR(oracle::relative_error(extents, filter, lattice), lattice.relative_error,
                0.06 * lattice.relative_error + 0.001)
        << extents.to_string();
  }
}

// As filters that reach over many slices ask for (construction comes to 0.030).
TEST(Lattice, IsAheadByPartsOfPhases) {
  const Extents extents({16, 16, 64});
  const FilterSpec filter = product({group({0, 1}, box(3)), group({2}, box(32))});
  const Lattice lattice = lattice_of(extents, filter);
  const double error = oracle::relative_error(extents, filter, lattice);
  EXPECT_LT(error, 0.02);
  EXPECT_NEAR(lattice.relative_error, error, 0.4 * error);  // of few pixels
}

// Against all lattices over x, y and t, with some that order pixels of equal phase.
TEST(Lattice, IsNearlyTheBestOfAll) {
  const Extents extents({16, 12, 6});
  const FilterSpec filter = product({group({0, 1}, box(3)), group({2}, box(2))});
  const Footprint overlap(extents, filter);
  double least = 1e9;
  for (std::int64_t a = 0; a < 16; ++a) {
    for (std::int64_t b = 0; b < 12; ++b) {
      for (std::int64_t c = 0; c < 6; ++c) {
        for (const auto& [a2, b2] : {std::pair(1, 0), std::pair(0, 1), std::pair(5, 1)}) {
          least = std::min(least, oracle::relative_error(extents, filter, Lattice{{a, b, c}, {a2, b2}, 0}));
        }
      }
    }
  }
  EXPECT_LT(lattice_of(extents, filter).relative_error, 1.2 * least);
}

// Places ascend by the phase, then by the second, then in the order of memory, around where the seed has it begin. The
// last of these lattices leave pixels of equal phases.
TEST(Lattice, HasPixelsInTheOrderOfTheirPhases) {
  const std::pair<Extents, Lattice> cases[] = {
      {Extents({32, 32, 4}), {{3, 2, 1}, {1, 1}, 0}}, {Extents({17, 6, 4}), {{3, 2, 1}, {1, 1}, 0}},
      {Extents({1, 5, 3}), {{0, 2, 1}, {0, 1}, 0}},   {Extents({40, 24}), {{16, 9}, {15, 4}, 0}},
      {Extents({32, 32}), {{8, 10}, {0, 1}, 0}},      {Extents({12, 18}), {{4, 6}, {6, 3}, 0}},
      {Extents({6, 4}), {{0, 0}, {0, 0}, 0}},
  };
  for (const auto& of_case : cases) {
    const Extents& extents = of_case.first;
    const Lattice& lattice = of_case.second;
    for (const SliceIndex slice : first_indices<SliceIndex>(extents.num_slices())) {
      std::vector<std::uint32_t> places = oracle::places_of_slice(lattice, extents, slice);
      std::ranges::sort(places);
      for (std::uint32_t i = 0; i < places.size(); ++i) ASSERT_EQ(places[i], i) << extents.to_string();
    }
    const std::vector<std::uint32_t> places = lattice_places(lattice, extents, 7);
    bool found = false;
    for (std::int64_t shift = 0; shift < extents.cells_per_slice() && !found; ++shift) {
      found = places == oracle::places_by_phase(lattice, extents, shift % extents.width(), shift / extents.width());
    }
    EXPECT_TRUE(found) << extents.to_string();
  }
}

TEST(Lattice, BeginsWhereTheSeedSays) {
  const Extents extents({64, 64});
  const Lattice lattice{{19, 23}, {0, 1}, 0};
  EXPECT_EQ(lattice_places(lattice, extents, 1), lattice_places(lattice, extents, 1));
  EXPECT_NE(lattice_places(lattice, extents, 1), lattice_places(lattice, extents, 2));
}

// No longer than it is let: what was kept of the first part of the search is asked about once more in the second.
TEST(Lattice, IsNotLookedForAnyFurther) {
  for (const int calls : {0, 1, 3, 20}) {
    int left = calls;
    EXPECT_FALSE(find_lattice(Footprint(Extents({32, 32, 4}), product({group({0, 1}, box(3)), group({2}, box(3))})),
                              [&] { return left-- > 0; }));
    EXPECT_LT(left, 0);
    constexpr int most_kept = 256;
    EXPECT_GE(left, calls == 0 ? -1 : -(most_kept + 2)) << calls;
  }
}

// A step in x is the same step of places everywhere, over the seam as well, but for pixels of equal phase.
TEST(Lattice, ClosesAroundTheTorus) {
  const Extents extents({16, 16});
  const std::vector<std::uint32_t> places = lattice_places({{5, 3}, {0, 1}, 0}, extents, 1);
  for (std::uint32_t y = 0; y < 16; ++y) {
    for (std::uint32_t x = 0; x < 16; ++x) {
      const std::uint32_t step = (places[y * 16 + (x + 1) % 16] + 256 - places[y * 16 + x]) % 256;
      ASSERT_EQ(step, 5 * 16U) << x << ' ' << y;
    }
  }
}

}  // namespace
}  // namespace noiseloom
