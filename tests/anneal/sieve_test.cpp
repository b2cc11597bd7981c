// Estimates of dE by features of all slices, and what is done with them.
#include "anneal/deltas/sieve.h"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "anneal/deltas/delta_fields.h"
#include "anneal/feature_fixture.h"
#include "anneal/moves/sieve_margin.h"
#include "noiseloom/anneal/slice_mover.h"
#include "support/sanitizers.h"

namespace noiseloom {
namespace {

using namespace testing_support;
using test::samples_of;
using test::Space;
using test::Texture;

struct SieveCase {
  std::string name;
  Extents extents;
  FilterSpec filter;
  double cutoff = 0;
  double tolerance = 2e-4;
};

FilterSpec weighted_sum(std::vector<GroupSpec> groups) { return {Combine::sum, std::move(groups)}; }

std::vector<SieveCase> sieve_cases() {
  return {{"one slice", Extents({19, 17}), product({group({0, 1}, gauss(0.8))})},
          {"gauss x ema", Extents({19, 17, 5}), product({group({0, 1}, gauss(0.8)), group({2}, ema(0.1, 0.1))})},
          {"box x box over two slice axes, folded", Extents({5, 7, 3, 2}),
           product({group({0, 1}, box(5)), group({2, 3}, box(2))})},
          {"a disc, which is not separable", Extents({13, 11, 3}),
           product({group({0, 1}, gauss_energy(0.9)), group({2}, box(2))})},
          {"the same pixel of other slices", Extents({17, 19, 5}),
           weighted_sum({group({0, 1}, gauss(0.8)), group({2}, ema(0.1, 0.1))})},
          {"a cut-off that takes corners", Extents({19, 23, 4}),
           weighted_sum({group({0, 1}, gauss_energy(1.2)), group({2}, gauss_energy(1.0))}), 1e-4, 4e-3},
          {"one row of taps", Extents({19, 5, 3}), product({group({0}, gauss(0.8)), group({2}, box(2))})}};
}

// What a Sieve promises, with the kernel by features. Small taps see the slice as it was `bound`.
double expected_estimate(const Footprint& footprint, const Texture& texture, const Texture& bound,
                         const ValueKernel& kernel, const FeatureMap& map, SliceIndex slice, CellPair pair) {
  const test::PairKernel by_features = test::kernel_by_features(map, kernel.channels);
  std::vector<SliceTaps> told(footprint.slices().begin(), footprint.slices().end());
  std::vector<SliceTaps> untold{told.front()};
  const double least = Sieve::least_weight_told(told.front().taps);
  std::erase_if(told.front().taps, [&](const PlaneTap& tap) { return std::abs(tap.weight) < least; });
  std::erase_if(untold.front().taps, [&](const PlaneTap& tap) { return std::abs(tap.weight) >= least; });
  const Extents& extents = footprint.extents();
  const double all = test::change_by(told, extents, texture, slice, pair, by_features) +
                     test::change_by(untold, extents, texture, slice, pair, by_features, &bound);
  float a[8];
  float b[8];
  texture.field(slice).get(pair.i, a);
  texture.field(slice).get(pair.j, b);
  double weight = 0;
  for (const PlaneTap& tap : footprint.slices()[0].taps) {
    const std::int64_t x = (pair.i % extents.width() + tap.dx + extents.width()) % extents.width();
    const std::int64_t y = (pair.i / extents.width() + tap.dy + extents.height()) % extents.height();
    if (x + extents.width() * y == pair.j) weight += tap.weight;
  }
  // A sample is no way from itself. (In float, a unit vector's length says otherwise.)
  return all + 4 * weight * test::oracle_kernel(kernel, a, b);
}

std::vector<CellPair> some_pairs(Cell cells) {
  const Cell last = cells - 1;
  return {test::pair(0, last), test::pair(last / 2, 3), test::pair(last / 3, last - 1), test::pair(0, 1)};
}

// After swaps too, and of a direct neighbour.
TEST(Sieve, EstimatesTheChangeByTheLowRankKernelOfAllSlices) {
  for (const SieveCase& one : sieve_cases()) {
    for (const Space& space : test::all_spaces()) {
      SCOPED_TRACE(one.name + " " + space.name);
      const Footprint footprint(one.extents, one.filter, one.cutoff);
      ASSERT_TRUE(Sieve::serves(footprint));
      const ValueKernel kernel = test::kernel_of(space, ValueKernelKind::distance, one.extents.num_axes());
      Texture texture(footprint, kernel, 5);
      const Texture bound(footprint, kernel, 5);
      const FeatureMap map(kernel, 19, samples_of(texture, 1));
      const auto delta = make_swap_delta(footprint, kernel, Precision::float32, nullptr, std::nullopt, &map);
      const SliceIndex slice(one.extents.num_slices() - 1);
      delta->bind(slice, texture.field(slice), texture.field_of());
      for (const bool swapped : {false, true}) {
        std::vector<CellPair> pairs = some_pairs(one.extents.cells_per_slice());
        if (testing_support::under_sanitizers) pairs.resize(3);
        for (std::size_t k = 0; k < 3 && swapped; ++k) {
          delta->swap(pairs[k]);
          texture.field(slice).swap(pairs[k].i, pairs[k].j);
        }
        std::vector<double> estimates(pairs.size());
        delta->estimate(pairs, estimates.data());
        for (std::size_t k = 0; k < pairs.size(); ++k) {
          const double expected = expected_estimate(footprint, texture, bound, kernel, map, slice, pairs[k]);
          EXPECT_NEAR(estimates[k], expected,
                      one.tolerance * footprint.weight_zero() + one.tolerance * std::abs(expected))
              << pairs[k].i << " " << pairs[k].j;
        }
      }
    }
  }
}

TEST(Sieve, TellsAllButSmallTapsWhichComeToLittle) {
  const Extents extents({61, 61});
  GroupSpec peak = group({0, 1}, gauss_energy(1.9));
  peak.weight = 0.95;
  GroupSpec foot = group({0, 1}, gauss_energy(6));
  foot.weight = 0.05;
  for (const FilterSpec& filter :
       {product({group({0, 1}, gauss_energy(1.9))}), product({group({0, 1}, box(5))}), weighted_sum({peak, foot})}) {
    const Footprint footprint(extents, filter);
    const std::vector<PlaneTap>& taps = footprint.slices()[0].taps;
    const double least = Sieve::least_weight_told(taps);
    double largest = 0;
    double all = 0;
    double untold = 0;
    for (const PlaneTap& tap : taps) {
      largest = std::max(largest, tap.weight);
      all += tap.weight;
      if (tap.weight < least) untold += tap.weight;
    }
    EXPECT_GT(untold, 0);
    EXPECT_LE(untold, 0.1 * all);
    EXPECT_LE(least, 0.12 * largest);  // the first of at least 0.08
  }
  // The foot alone comes to a third, so that some of its taps are told, which are all small.
  const Footprint with_foot(extents, weighted_sum({peak, foot}));
  EXPECT_LT(Sieve::least_weight_told(with_foot.slices()[0].taps), 0.05 * with_foot.weight_zero());
  EXPECT_EQ(Sieve::least_weight_told({}), 0);
}

TEST(DeltaFields, PairsThatAreNotNearHaveNoWeight) {
  for (const Extents& extents : {Extents({19, 17, 2}), Extents({23, 1, 2}), Extents({5, 7, 2})}) {
    const Footprint footprint(extents, product({group({0}, gauss(0.8)), group({1}, box(3)), group({2}, box(2))}));
    for (const std::int64_t height : {extents.height(), std::min<std::int64_t>(extents.height(), 9)}) {
      const WindowSize window{extents.width(), height};
      const DeltaFields fields(footprint, 2, window, false);
      std::int64_t num_near = 0;
      for (Cell i = 0; i < window.width * window.height; ++i) {
        for (Cell j = 0; j < window.width * window.height; ++j) {
          if (i == j || fields.pair_weight(fields.position(i), fields.position(j)) == 0) continue;
          ++num_near;
          EXPECT_TRUE(fields.may_be_near(i, j)) << i << " " << j;
        }
      }
      EXPECT_GT(num_near, 0);
    }
  }
  const Footprint footprint(Extents({19, 40}), product({group({0, 1}, box(3))}));
  EXPECT_FALSE(DeltaFields(footprint, 2, WindowSize{19, 40}, false).may_be_near(0, 19 * 20));
}

TEST(Sieve, OfAWindowEstimatesAsOfTheWholeSlice) {
  const Extents extents({23, 19, 3});
  for (const FilterSpec& filter : {product({group({0, 1}, gauss(0.8)), group({2}, box(2))}),
                                   weighted_sum({group({0, 1}, box(3)), group({2}, ema(0.1, 0.1))})}) {
    const Footprint footprint(extents, filter);
    const ValueKernel kernel = test::kernel_of(test::all_spaces()[4], ValueKernelKind::distance, 3);
    Texture texture(footprint, kernel, 5);
    const FeatureMap map(kernel, 16, samples_of(texture, 1));
    for (const WindowSize size : {WindowSize{9, 7}, WindowSize{23, 7}, WindowSize{9, 19}}) {
      const auto whole = make_swap_delta(footprint, kernel, Precision::float32, nullptr, std::nullopt, &map);
      const auto part = make_swap_delta(footprint, kernel, Precision::float32, nullptr, size, &map);
      const Corner corner{size.width == 23 ? 0 : 20, size.height == 19 ? 0 : 15};
      whole->bind(SliceIndex(1), texture.field(SliceIndex(1)), texture.field_of());
      part->bind(SliceIndex(1), corner, texture.field(SliceIndex(1)), texture.field_of());
      const auto in_slice = [&](std::uint32_t cell) {
        return static_cast<std::uint32_t>(
            slice_cell(texture.field(SliceIndex(1)).layout(), corner, part->layout(), cell));
      };
      const auto cells = static_cast<std::uint32_t>(size.width * size.height);
      for (std::uint32_t i = 0; i < cells; ++i) {
        const CellPair here[] = {{i, (i * 5 + 1) % cells}};
        const CellPair there[] = {{in_slice(here[0].i), in_slice(here[0].j)}};
        if (here[0].i == here[0].j) continue;
        double estimates[2];
        part->estimate(here, &estimates[0]);
        whole->estimate(there, &estimates[1]);
        EXPECT_NEAR(estimates[0], estimates[1], 1e-4);
        if (i % 3 != 0) continue;
        part->swap(here[0]);
        whole->swap(there[0]);
      }
    }
  }
}

TEST(Sieve, HasTheSameBitsOnAllInstructionSets) {
  for (const SieveCase& one : sieve_cases()) {
    const Footprint footprint(one.extents, one.filter, one.cutoff);
    const ValueKernel kernel = test::kernel_of(test::all_spaces()[9], ValueKernelKind::distance, 3);
    const Texture texture(footprint, kernel, 5);
    const FeatureMap map(kernel, 19, samples_of(texture, 1));
    const auto values = [&](std::int64_t target) {
      hwy::SetSupportedTargetsForTest(target);
      const auto delta = make_swap_delta(footprint, kernel, Precision::float32, nullptr, std::nullopt, &map);
      delta->bind(SliceIndex(0), texture.field(SliceIndex(0)), texture.field_of());
      std::vector<double> all;
      // As many as a vector holds are estimated together, and what is left one by one.
      for (const Cell count : {Cell{16}, Cell{13}, Cell{8}, Cell{5}}) {
        std::vector<CellPair> pairs;
        for (Cell i = 1; i <= count; ++i) pairs.push_back(test::pair(i, 2 * i % 7));
        std::vector<double> together(pairs.size());
        delta->estimate(pairs, together.data());
        for (std::size_t k = 0; k < pairs.size(); ++k) {
          double alone = 0;
          delta->estimate(std::span(pairs).subspan(k, 1), &alone);
          EXPECT_EQ(together[k], alone) << count << " " << k << " " << target;
        }
        all.insert(all.end(), together.begin(), together.end());
      }
      for (Cell i = 1; i < one.extents.cells_per_slice(); ++i) {
        const CellPair pairs[] = {test::pair(i, 0)};
        all.emplace_back();
        delta->estimate(pairs, &all.back());
        if (i % 2 == 0) delta->swap(pairs[0]);
      }
      hwy::SetSupportedTargetsForTest(0);
      return all;
    };
    const std::vector<double> reference = values(HWY_STATIC_TARGET);
    for (std::int64_t targets = hwy::SupportedTargets(); targets != 0; targets &= targets - 1) {
      EXPECT_EQ(values(targets & -targets), reference) << one.name << " " << targets;
    }
  }
}

TEST(Sieve, ServesPlanesAndSamePixelsAlone) {
  const Extents extents({16, 16, 8, 4});
  const auto serves = [&](const FilterSpec& filter) { return Sieve::serves(Footprint(extents, filter)); };
  EXPECT_TRUE(serves(product({group({0, 1}, box(3))})));
  EXPECT_TRUE(serves(product({group({0, 1}, box(3)), group({2, 3}, box(3))})));
  EXPECT_TRUE(serves(weighted_sum({group({0, 1}, box(3)), group({2}, box(3)), group({3}, box(3))})));
  EXPECT_FALSE(serves(weighted_sum({group({0, 1}, box(3)), group({1, 2}, box(3))})));
}

TEST(SieveMargin, GrowsWithTheErrorsOfCandidatesThatAreAsFarApart) {
  SieveMargin margin;
  for (int k = 0; k < 64; ++k) {
    margin.learn(k % 2 == 0 ? 5 : -5, 1, 1 + (k % 4 < 2 ? 0.01 : -0.01));
    margin.learn(1000, 10, 10 + (k % 2 == 0 ? 1 : -1));
  }
  margin.conclude();
  for (const std::int32_t step : {5, -5, 7, 1000, -1000}) {
    EXPECT_TRUE(margin.lets_through(step, 0.5, 0.5));
    EXPECT_TRUE(margin.lets_through(step, std::numeric_limits<double>::quiet_NaN(), 0.5));
  }
  EXPECT_FALSE(margin.lets_through(5, 0.65, 0.5));
  EXPECT_TRUE(margin.lets_through(1000, 0.65, 0.5));
  EXPECT_FALSE(margin.lets_through(1000, 1.5, 0.5));
}

TEST(SieveMargin, LetsEverythingThroughWhereEstimatesSayNothing) {
  SieveMargin useless;
  for (int k = 0; k < 64; ++k) useless.learn(5, k % 2 == 0 ? 1 : -1, k % 4 < 2 ? 1 : -1);
  useless.conclude();
  EXPECT_TRUE(useless.lets_through(5, 1e30, 0));
  SieveMargin nothing_learnt;
  nothing_learnt.conclude();
  EXPECT_TRUE(nothing_learnt.lets_through(5, 1e30, 0));
}

// Equal samples: every change is 0, every estimate right.
TEST(SieveMargin, LetsTiesThroughWhereEstimatesAreExact) {
  SieveMargin margin;
  margin.learn(5, 0, 0);
  margin.conclude();
  EXPECT_TRUE(margin.lets_through(5, 0, 0));
  EXPECT_FALSE(margin.lets_through(5, 1e-9, 0));
}

class SievedMover : public ::testing::Test {
 protected:
  const Extents extents_{Extents({48, 48})};
  const Footprint footprint_{extents_, product({group({0, 1}, gauss(0.8))})};
  const ValueKernel kernel_ = test::kernel_of(test::all_spaces()[3], ValueKernelKind::distance, 2);
  Texture texture_{footprint_, kernel_, 3};
  const FeatureMap map_{kernel_, 16, samples_of(texture_, 1)};

  VisitResult visited(const FeatureMap* sieve, double temperature) const {
    AnnealMover mover(make_swap_delta(footprint_, kernel_, Precision::float32, nullptr, std::nullopt, sieve));
    const Permutation ids = identity_permutation(48 * 48);
    return mover.visit({SliceIndex(0), 0, 9, 8}, temperature, PartnerDraw(48 * 48, {64}, false),
                       texture_.field(SliceIndex(0)), ids, texture_.field_of());
  }
};

// The same candidates, and nearly as many swaps: those that the sieve holds back would mostly have been refused.
TEST_F(SievedMover, FindsNearlyAllSwaps) {
  const VisitResult all = visited(nullptr, 0);
  const VisitResult sieved = visited(&map_, 0);
  EXPECT_NEAR(static_cast<double>(sieved.candidates), static_cast<double>(all.candidates), 20);
  EXPECT_LT(sieved.energy, 0.97 * all.energy);
  EXPECT_GT(static_cast<double>(sieved.num_swaps), 0.9 * static_cast<double>(all.num_swaps));
}

// What is swapped is judged by all taps.
TEST_F(SievedMover, SwapsChangeTheEnergyByTheirSum) {
  const double start = texture_.energy();
  const VisitResult result = visited(&map_, 0.01);
  for (const Swap& swap : result.swaps) texture_.field(SliceIndex(0)).swap(swap.a, swap.b);
  EXPECT_GT(result.swaps.size(), 100U);
  EXPECT_NEAR(texture_.energy() - start, result.energy, 1e-5 * std::abs(start));
}

}  // namespace
}  // namespace noiseloom
