// What is chosen from the problem, and how it cools.
#include "noiseloom/anneal/swap_choices.h"

#include <gtest/gtest.h>

#include "anneal/texture_fixture.h"
#include "noiseloom/anneal/cooling.h"

namespace noiseloom {
namespace {

using namespace testing_support;

TEST(SwapChoices, SieveWhereTapsCostMuch) {
  OptimizerSpec usual;
  usual.sieve_features = 16;
  const auto wants = [&](DistanceKind kind, ValueKernelKind value_kind, std::int64_t taps,
                         const OptimizerSpec& optimizer, bool is_served = true) {
    return wants_sieve(optimizer, {value_kind, kind, 3, 1, 1}, is_served, taps);
  };
  constexpr auto distance = ValueKernelKind::distance;
  EXPECT_TRUE(wants(DistanceKind::euclidean, distance, 80, usual));
  EXPECT_FALSE(wants(DistanceKind::euclidean, distance, 24, usual));
  EXPECT_TRUE(wants(DistanceKind::angle, distance, 24, usual));
  EXPECT_TRUE(wants(DistanceKind::euclidean, ValueKernelKind::stbn, 24, usual));
  EXPECT_FALSE(wants(DistanceKind::absolute, distance, 800, usual));
  EXPECT_FALSE(wants(DistanceKind::circle, distance, 800, usual));
  EXPECT_TRUE(wants(DistanceKind::absolute, ValueKernelKind::stbn, 24, usual));
  EXPECT_FALSE(wants(DistanceKind::angle, distance, 24, usual, false));
  OptimizerSpec other = usual;
  other.sieve_features = 0;
  EXPECT_FALSE(wants(DistanceKind::angle, distance, 24, other));
  other = usual;
  other.precision = Precision::float64;
  EXPECT_FALSE(wants(DistanceKind::angle, distance, 24, other));
  other = usual;
  other.method = Method::fast;
  EXPECT_FALSE(wants(DistanceKind::angle, distance, 24, other));
}

TEST(SwapChoices, VisitsAreLongerWithASieve) {
  OptimizerSpec optimizer;
  optimizer.stop.iterations = 2000;
  constexpr std::int64_t cells = 128 * 128 * 32;
  EXPECT_EQ(visit_length(optimizer, cells, false, false), 8);
  EXPECT_EQ(visit_length(optimizer, cells, true, false), 16);
  EXPECT_EQ(visit_length(optimizer, cells, true, true), 64);
  optimizer.stop.iterations = 100;
  EXPECT_EQ(visit_length(optimizer, cells, true, true), 4);
}

// A run that ends in time has sweeps enough to cool in.
TEST(SwapChoices, VisitsAreShorterWhereTimeIsShort) {
  OptimizerSpec optimizer;
  optimizer.stop = {0, 60, 0, 0};
  EXPECT_EQ(visit_length(optimizer, 128 * 128 * 32, true, true), 59);
  EXPECT_EQ(visit_length(optimizer, 128 * 128, false, true), 64);
  optimizer.stop.time_s = 15;
  EXPECT_EQ(visit_length(optimizer, 128 * 128 * 32, true, true), 14);
  optimizer.stop.time_s = 1;
  EXPECT_EQ(visit_length(optimizer, 128 * 128 * 32, true, true), 4);
  EXPECT_EQ(visit_length(optimizer, 128 * 128 * 32, true, false), 8);
  optimizer.stop = {0, 0, 0.1, 0};
  EXPECT_EQ(visit_length(optimizer, 128 * 128 * 32, true, true), 16);
}

TEST(SwapChoices, ThePapersMethodAloneJudgesByEveryTap) {
  OptimizerSpec optimizer;
  EXPECT_EQ(energy_cutoff(optimizer), 1e-3);
  optimizer.method = Method::fast;
  EXPECT_EQ(energy_cutoff(optimizer), 0);
  optimizer.cutoff = 0.01;
  EXPECT_EQ(energy_cutoff(optimizer), 0.01);
  optimizer = {.cutoff = 0};
  EXPECT_EQ(energy_cutoff(optimizer), 0);
}

TEST(SwapChoices, CoolsByTheKindOfTheFilter) {
  const Extents extents({16, 16, 32});
  const auto groups = [](Combine combine, const KernelSpec& temporal) {
    FilterSpec filter = product({group({0, 1}, gauss(1)), group({2}, temporal)});
    filter.combine = combine;
    return filter;
  };
  const Footprint sum(extents, groups(Combine::sum, ema(0.1, 0.1)));
  const Footprint product_far(extents, groups(Combine::product, ema(0.1, 0.1)));
  const Footprint product_near(extents, groups(Combine::product, gauss(1)));
  const Footprint apart(extents, product({group({0, 1}, gauss(1))}));
  OptimizerSpec optimizer;
  EXPECT_TRUE(acts_by_same_pixels(sum));
  for (const Footprint* other : {&product_far, &product_near, &apart}) EXPECT_FALSE(acts_by_same_pixels(*other));
  EXPECT_LT(temperature_range(optimizer, sum).start, temperature_range(optimizer, apart).start);
  EXPECT_GT(cooling_exponent(optimizer, sum, true), 2);
  EXPECT_EQ(cooling_exponent(optimizer, sum, true, 0.3), 1);  // a run that joins the schedule
  EXPECT_EQ(temperature_range(optimizer, sum, 0.3).start, temperature_range(optimizer, apart).start);
  EXPECT_EQ(cooling_exponent(optimizer, product_far, true), 1);
  EXPECT_EQ(cooling_exponent(optimizer, apart, true), 1);
  EXPECT_LT(cooling_exponent(optimizer, product_near, true), 1);
  EXPECT_EQ(cooling_exponent(optimizer, product_near, false), 1);  // without a sieve it has few features
  optimizer.stop.time_s = 1;
  EXPECT_EQ(cooling_exponent(optimizer, apart, true), 1.3);
  optimizer.temperature_end = 1e-3;  // the user's own schedule
  EXPECT_EQ(temperature_range(optimizer, sum).start, temperature_range({}, apart).start);
  EXPECT_EQ(cooling_exponent(optimizer, sum, true), 1);
  EXPECT_EQ(temperature_range(optimizer, sum).end, 1e-3);
}

TEST(SwapChoices, ManyFeaturesWhereOtherSlicesCountMuch) {
  const auto wants = [](const KernelSpec& temporal, bool with_sieve) {
    return wants_many_features(
        Footprint(Extents({16, 16, 32}), product({group({0, 1}, gauss(1)), group({2}, temporal)})), with_sieve);
  };
  EXPECT_TRUE(wants(gauss(1), true));
  EXPECT_FALSE(wants(gauss(1), false));
  EXPECT_FALSE(wants(ema(0.1, 0.1), true));
  EXPECT_FALSE(wants_many_features(Footprint(Extents({16, 16}), product({group({0, 1}, gauss(1))})), true));
}

// Steps shrink as it cools: none of a range ever grows, and the far end stays where partner() can mirror it.
TEST(SwapChoices, StepsShrinkWithTheTemperature) {
  for (const DistanceKind kind : {DistanceKind::absolute, DistanceKind::circle, DistanceKind::euclidean,
                                  DistanceKind::angle, DistanceKind::axis, DistanceKind::manhattan}) {
    for (const int channels : {1, 2, 3, 4}) {
      StepRange before = step_range(kind, channels, 0);
      EXPECT_EQ(before.far, 2);
      for (int k = 1; k <= 10; ++k) {
        const StepRange range = step_range(kind, channels, k / 10.0);
        EXPECT_GT(range.near, before.near);
        EXPECT_GT(range.far, before.far);
        EXPECT_LT(range.far, range.near);
        before = range;
      }
    }
  }
}

TEST(SwapChoices, BackgroundGrowsTowardsTheEnd) {
  OptimizerSpec optimizer;
  optimizer.background_features = 8;
  EXPECT_EQ(num_features(optimizer, 0, false), 8);
  EXPECT_EQ(num_features(optimizer, 0.8, false), 32);
  EXPECT_EQ(num_features(optimizer, 1, false), 64);
  EXPECT_EQ(num_features(optimizer, 0, true), 32);
  EXPECT_EQ(num_features(optimizer, 0.8, true), 64);
  optimizer.background_features = 48;
  EXPECT_EQ(num_features(optimizer, 0.8, false), 64);
  optimizer.background_features = 0;
  EXPECT_EQ(num_features(optimizer, 1, false), 0);
  EXPECT_EQ(num_features(optimizer, 1, true), 0);
}

// Features stand for taps that would cost more than they do; never for a few taps of the same pixel.
TEST(SwapChoices, FewTapsOfTheSamePixelAreTakenOneByOne) {
  const auto has_features = [](const Extents& extents, const FilterSpec& filter) {
    ProblemSpec problem;
    problem.extents = extents;
    problem.filter = filter;
    const SampleSource source(problem.samples, extents.cells_per_slice(), extents.num_slices(), 1);
    const Footprint footprint(extents, filter);
    const ValueKernel kernel = make_value_kernel(problem, source.channels(), source.distance());
    return features_between_slices({}, footprint, kernel, source, 8).has_value();
  };
  EXPECT_FALSE(has_features(Extents({16, 16, 8}), product({group({2}, box(3))})));
  EXPECT_FALSE(has_features(Extents({16, 16, 64}), product({group({2}, ema(0.1, 0.1))})));
  EXPECT_FALSE(has_features(Extents({16, 16, 8, 8}), product({group({2, 3}, box(3))})));
  EXPECT_TRUE(has_features(Extents({4, 4, 1024}), product({group({2}, ema(0.1, 0.1))})));
  EXPECT_TRUE(has_features(Extents({16, 16, 8}), product({group({0, 1}, box(3)), group({2}, box(3))})));
}

}  // namespace
}  // namespace noiseloom
