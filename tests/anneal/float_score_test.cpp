// The quick sums of the history against those of the score.
#include "anneal/float_score.h"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cmath>
#include <vector>

#include "anneal/texture_fixture.h"
#include "noiseloom/problem/score.h"
#include "support/sanitizers.h"

namespace noiseloom {
namespace {

using namespace testing_support;
using test::Texture;

struct Sums {
  double in_float = 0;
  double in_double = 0;
};

Sums sums_of(const Footprint& footprint, const test::Space& space, unsigned seed) {
  const ValueKernel kernel = test::kernel_of(space, ValueKernelKind::distance, footprint.extents().num_axes());
  const Texture texture(footprint, kernel, seed);
  const FieldLayout layout(footprint, space.channels);
  const FloatScore score(footprint, space.distance, layout);
  std::vector<std::vector<float>> planar;
  for (const SliceIndex slice : footprint.extents().slices()) {
    planar.push_back(texture.field(slice).planar());
  }
  Sums sums;
  for (const SliceIndex slice : footprint.extents().slices()) {
    sums.in_float += score.slice_sum(slice, texture.field_of());
    sums.in_double += weighted_distance_sum(footprint, space.distance, space.channels, slice,
                                            [&](SliceIndex s) { return planar[static_cast<std::size_t>(s)].data(); });
  }
  return sums;
}

// Widths that fill whole blocks and do not, offsets that are their own opposite, axes of length 1 and 2.
TEST(FloatScore, SumsWhatTheScoreSums) {
  const std::vector<FilterSpec> filters = {
      product({group({0, 1}, box(3)), group({2}, ema(0.1, 0.1))}), product({group({0, 1}, gauss(1.0))}),
      sum({group({0, 1}, box(4)), group({2}, box(3))}), product({group({0, 1, 2}, gauss_energy(0.9))}),
      product({group({2}, box(3))})};
  for (const auto& sizes :
       {std::vector<std::int64_t>{17, 5, 4}, {16, 6, 2}, {31, 2, 3}, {33, 1, 1}, {2, 4, 5}, {1, 1, 6}}) {
    for (const FilterSpec& filter : filters) {
      const Footprint footprint(Extents(sizes), filter);
      for (const test::Space& space : test::all_spaces()) {
        const Sums sums = sums_of(footprint, space, 7);
        EXPECT_NEAR(sums.in_float, sums.in_double, 1e-6 * std::abs(sums.in_double)) << space.name << " " << sizes[0];
      }
    }
  }
}

// What is common to all distances is what R amplifies: 1e-7 of them, times 62, is 6e-6 of R.
TEST(FloatScore, IsRightWhereRAmplifiesMost) {
  const Extents extents = testing_support::under_sanitizers ? Extents({19, 16, 8}) : Extents({37, 32, 16});
  const Footprint footprint(extents, product({group({0, 1}, box(5)), group({2}, ema(0.1, 0.1))}));
  for (const test::Space& space : test::all_spaces()) {
    const Sums sums = sums_of(footprint, space, 3);
    const double amplification = footprint.weight_sum() / footprint.weight_zero();
    EXPECT_LT(amplification * std::abs(sums.in_float / sums.in_double - 1), 1e-5) << space.name;
  }
}

TEST(FloatScore, IsNotUsedWhereItWouldShow) {
  const Extents extents({64, 64, 64});
  const Footprint usual(extents, product({group({0, 1}, box(5)), group({2}, ema(0.1, 0.1))}));
  const Footprint wide(extents, product({group({0, 1}, box(15)), group({2}, ema(0.01, 0))}));
  for (const DistanceKind kind : {DistanceKind::absolute, DistanceKind::angle}) {
    EXPECT_TRUE(FloatScore::fits(usual, kind, FieldLayout(usual, 1)));
    EXPECT_FALSE(FloatScore::fits(wide, kind, FieldLayout(wide, 1)));
  }
  const FilterSpec filter = product({group({0, 1}, gauss(1.3)), group({2}, ema(0.1, 0.1))});
  const Footprint whole(extents, filter);
  const Footprint narrow(extents, product({group({0, 1}, gauss(1.0)), group({2}, ema(0.1, 0.1))}));
  EXPECT_FALSE(FloatScore::fits(whole, DistanceKind::absolute, FieldLayout(narrow, 1)));
  // What is laid out for an energy that leaves taps out has the border that the score needs.
  EXPECT_TRUE(FloatScore::fits(whole, DistanceKind::absolute, FieldLayout(Footprint(extents, filter, 0.05), 1)));
}

TEST(FloatScore, HasTheSameBitsOnAllInstructionSets) {
  const Footprint footprint(Extents({37, 9, 4}), product({group({0, 1}, gauss(1.0)), group({2}, ema(0.1, 0.1))}));
  for (const test::Space& space : test::all_spaces()) {
    hwy::SetSupportedTargetsForTest(HWY_STATIC_TARGET);
    const double reference = sums_of(footprint, space, 5).in_float;
    hwy::SetSupportedTargetsForTest(0);
    for (std::int64_t targets = hwy::SupportedTargets(); targets != 0; targets &= targets - 1) {
      hwy::SetSupportedTargetsForTest(targets & -targets);
      EXPECT_EQ(sums_of(footprint, space, 5).in_float, reference) << space.name;
      hwy::SetSupportedTargetsForTest(0);
    }
  }
}

}  // namespace
}  // namespace noiseloom
