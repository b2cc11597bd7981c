// Index arithmetic beyond 2^31 and 2^32 cells, without allocating them.
#include <gtest/gtest.h>

#include <cmath>

#include "noiseloom/problem/footprint.h"
#include "noiseloom/problem/score.h"
#include "noiseloom/samples/sample_space.h"
#include "noiseloom/samples/space.h"
#include "support/filter_specs.h"

namespace noiseloom {
namespace {

using namespace testing_support;

constexpr std::int64_t huge = std::int64_t{1} << 20;

TEST(HardCases, ExtentsInvertForTheLargestNumberOfSlices) {
  const Extents extents({1 << 15, (1 << 15) + 1, 46337, 46337, 1});  // nearly 2^31 slices of 2^30 cells
  EXPECT_EQ(extents.num_cells() / extents.num_slices(), extents.cells_per_slice());
  EXPECT_EQ(extents.num_cells() % extents.num_slices(), 0);
  const SliceIndex last(extents.num_slices() - 1);
  for (const SliceIndex slice : {SliceIndex(0), SliceIndex(46336), SliceIndex(46337), SliceIndex(1 << 30), last}) {
    EXPECT_EQ(extents.slice_index(extents.slice_coord(slice)), slice);
  }
  EXPECT_EQ(extents.slice_at(SliceIndex(0), {-1, -1, -1}), last);
  EXPECT_EQ(extents.slice_at(last, {1, 1, 1}), SliceIndex(0));
}

// Of 2^50 cells: an overlap that fits its axes does not depend on their length.
TEST(HardCases, FootprintDoesNotDependOnTheSizeOfHugeTextures) {
  const FilterSpec filter = product({group({0, 1}, gauss(1.5)), group({2}, box(5))});
  const Footprint large(Extents({huge, huge + 1, 1 << 10}), filter);
  const Footprint small(Extents({64, 65, 32}), filter);
  EXPECT_EQ(large.weight_zero(), small.weight_zero());
  EXPECT_EQ(large.weight_sum(), small.weight_sum());
  ASSERT_EQ(large.slices().size(), small.slices().size());
  for (std::size_t s = 0; s < small.slices().size(); ++s) {
    const auto& [large_offset, large_taps] = large.slices()[s];
    const auto& [small_offset, small_taps] = small.slices()[s];
    EXPECT_EQ(large_offset, small_offset);
    ASSERT_EQ(large_taps.size(), small_taps.size());
    for (std::size_t k = 0; k < small_taps.size(); ++k) {
      EXPECT_EQ(large_taps[k].dx, small_taps[k].dx);
      EXPECT_EQ(large_taps[k].dy, small_taps[k].dy);
      EXPECT_EQ(large_taps[k].weight, small_taps[k].weight);
    }
  }
}

// Beyond 2^24 strata a float lies beside its stratum, by 2^-24 of the range at most; tent by the root of that.
TEST(HardCases, StrataBeyondFourBillionKeepTheirOrder) {
  const std::int64_t n = huge * huge + 1;
  for (const char* const kind : {"uniform", "circle", "gauss"}) {
    SampleSpec spec;
    spec.space = kind;
    const double middle = 0.5;
    float before = -100;
    for (const std::int64_t id : {std::int64_t{0}, n / 1000, n / 3, n / 2, n - n / 7, n - 1}) {
      float sample = 0;
      sample_space(spec).sample(n, id, &middle, &sample);
      EXPECT_TRUE(std::isfinite(sample)) << spec.space;
      EXPECT_LT(before, sample);
      EXPECT_NEAR(static_cast<double>(sample_space(spec).invert(n, &sample)) / static_cast<double>(n),
                  static_cast<double>(id) / static_cast<double>(n), 1e-6);
      before = sample;
    }
  }
}

TEST(HardCases, DirectionsOfStrataBeyondFourBillionAreUnitVectors) {
  const std::int64_t n = huge * huge + 1;
  const double middle[] = {0.5, 0.5};
  for (const char* const kind : {"sphere", "hemisphere", "hemisphere-cosine"}) {
    SampleSpec spec;
    spec.space = kind;
    for (const std::int64_t id : {std::int64_t{0}, n / 3, n / 2, n - 1}) {
      float v[3];
      sample_space(spec).sample(n, id, middle, v);
      EXPECT_NEAR(std::hypot(v[0], v[1], v[2]), 1, 2e-7) << spec.space << " " << id;
      EXPECT_GT(sample_space(spec).density(v), 0);
    }
  }
}

TEST(HardCases, MeanDistanceOfHugeTexturesIsSharedOutWithoutOverflow) {
  for (const DistanceKind kind : {DistanceKind::absolute, DistanceKind::angle}) {
    const MeanDistance mean(kind, kind == DistanceKind::angle ? 3 : 1, huge * huge, 1 << 20);
    EXPECT_FALSE(mean.exact());
    EXPECT_GT(mean.num_tasks(), 0);
  }
}

}  // namespace
}  // namespace noiseloom
