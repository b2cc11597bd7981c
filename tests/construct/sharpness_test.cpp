#include "noiseloom/construct/sharpness.h"

#include <gtest/gtest.h>

#include <cmath>

#include "noiseloom/problem/score.h"
#include "support/construct_problems.h"
#include "support/mpi_session.h"
#include "support/sanitizers.h"

namespace noiseloom {
namespace {

using namespace testing_support;

std::vector<double> errors_of(const std::vector<SharpnessTrial>& trials) {
  std::vector<double> errors;
  for (const SharpnessTrial& trial : trials) errors.push_back(trial.relative_error);
  return errors;
}

TEST(Sharpness, IsFoundFromTheFilter) {
  const FilterSpec gaussian = product({group({0, 1}, gauss(1.3435)), group({2}, ema(0.1, 0.1))});
  EXPECT_EQ(best_sharpness(try_sharpness(Extents({64, 64, 16}), gaussian)), 1.5);
  const FilterSpec boxes = product({group({0, 1}, box(5)), group({2}, ema(0.1, 0.1))});
  EXPECT_EQ(best_sharpness(try_sharpness(Extents({64, 64, 16}), boxes)), 1.1);
  const auto blue = product({group({0, 1}, gauss_energy(1.9)), group({2}, gauss_energy(1.9))});
  EXPECT_TRUE(try_sharpness(Extents({64, 64, 16}), blue).empty());
  EXPECT_EQ(best_sharpness({}), 1);
}

// 64x64x32 is 0.0348 with 2.5, 0.0347 with 3 and 0.0461 with 5.
TEST(Sharpness, OnACircleIsFoundWithTheSlicesThatActOnEachOther) {
  if (testing_support::under_sanitizers) GTEST_SKIP() << "asks how well, not where";
  const GroupSpec plane = group({0, 1}, binomial(2));
  const Extents volume({64, 64, 32});
  const double alone = best_sharpness(try_sharpness(volume, product({plane}), SampleScale::circle));
  EXPECT_GE(alone, 4);
  const FilterSpec both = product({plane, group({2}, ema(0.1, 0.1))});
  const double coupled = best_sharpness(try_sharpness(volume, both, SampleScale::circle));
  EXPECT_GE(coupled, 2);
  EXPECT_LE(coupled, 3);
  EXPECT_EQ(errors_of(try_sharpness(Extents({64, 64, 32}), both, SampleScale::circle)),
            errors_of(try_sharpness(Extents({128, 77, 64}), both, SampleScale::circle)));
}

TEST(Sharpness, IsTheTrialOfTheLeastError) {
  const auto trials = try_sharpness(Extents({24, 24}), product({group({0, 1}, gauss(1))}));
  ASSERT_GT(trials.size(), 2U);
  EXPECT_EQ(trials.front().sharpness, 1);
  for (std::size_t k = 1; k < trials.size(); ++k) EXPECT_LT(trials[k - 1].sharpness, trials[k].sharpness);
  for (const SharpnessTrial& trial : trials) {
    EXPECT_TRUE(trial.relative_error > 0 && trial.relative_error < 1) << trial.sharpness;
    if (trial.sharpness == best_sharpness(trials)) continue;
    EXPECT_GT(trial.relative_error, trials[0].relative_error * 0.5);
  }
  EXPECT_EQ(best_sharpness({{1, 0.3}, {1.2, 0.1}, {1.4, 0.1}, {1.6, 0.2}}), 1.2);  // the lowest of equals
  EXPECT_EQ(best_sharpness({}), 1);
}

// The twin is a slice of its own, of at most 64 pixels.
TEST(Sharpness, DoesNotDependOnTheSizeOfVolumes) {
  const auto filter = [](int slice_axes) {
    FilterSpec spec = product({group({0, 1}, gauss(1))});
    if (slice_axes > 0) spec.groups.push_back(group({2}, ema(0.1, 0.1)));
    if (slice_axes > 1) spec.groups.push_back(group({3}, box(3)));
    return spec;
  };
  const auto alone = errors_of(try_sharpness(Extents({24, 20}), filter(0)));
  EXPECT_EQ(errors_of(try_sharpness(Extents({24, 20, 7}), filter(1))), alone);
  EXPECT_EQ(errors_of(try_sharpness(Extents({24, 20, 64}), filter(1))), alone);
  EXPECT_EQ(errors_of(try_sharpness(Extents({24, 20, 5, 3}), filter(2))), alone);
  const FilterSpec narrow = product({group({0, 1}, box(2))});
  EXPECT_EQ(errors_of(try_sharpness(Extents({65, 1}), narrow)), errors_of(try_sharpness(Extents({64, 1}), narrow)));
  EXPECT_EQ(errors_of(try_sharpness(Extents({3, 1 << 20}), narrow)),
            errors_of(try_sharpness(Extents({3, 64}), narrow)));
}

TEST(Sharpness, OfASumIsThatOfItsSpatialGroups) {
  const auto alone = errors_of(try_sharpness(Extents({24, 20}), product({group({0, 1}, gauss(1))})));
  const FilterSpec both = sum({group({0, 1}, gauss(1), 0.25), group({2}, ema(0.1, 0.1), 0.75)});
  const auto of_sum = errors_of(try_sharpness(Extents({24, 20, 6}), both));
  ASSERT_EQ(of_sum.size(), alone.size());
  for (std::size_t k = 0; k < alone.size(); ++k) EXPECT_NEAR(of_sum[k], alone[k], 1e-9);
}

TEST(Sharpness, IsNotTriedWhereTheFilterReachesNoOtherPixelOfASlice) {
  const Extents extents({16, 16, 4});
  EXPECT_TRUE(try_sharpness(extents, product({group({2}, ema(0.1, 0.1))})).empty());
  EXPECT_TRUE(try_sharpness(extents, product({group({0, 1}, box(1)), group({2}, box(2))})).empty());
  EXPECT_TRUE(try_sharpness(extents, product({group({0, 1}, gauss(0.05))})).empty());
  EXPECT_TRUE(try_sharpness(Extents({1, 1, 4}), product({group({0, 1}, gauss(2)), group({2}, box(2))})).empty());
  EXPECT_FALSE(try_sharpness(extents, product({group({0}, box(2))})).empty());
}

TEST(Sharpness, IsFoundForTablesOverSpaceAndSlices) {
  const FilterSpec joint = product({group({0, 1, 2}, joint_taps())});
  const auto trials = try_sharpness(Extents({16, 12, 4}), joint);
  ASSERT_FALSE(trials.empty());
  for (const SharpnessTrial& trial : trials) EXPECT_TRUE(trial.relative_error > 0 && trial.relative_error < 1);
  // At most four slices are tried.
  EXPECT_EQ(errors_of(try_sharpness(Extents({16, 12, 9}), joint)), errors_of(trials));
  EXPECT_NE(errors_of(try_sharpness(Extents({16, 12, 3}), joint)), errors_of(trials));
  // Taps of one dimension, along x and t.
  EXPECT_FALSE(try_sharpness(Extents({16, 12, 4}), product({group({0, 2}, taps_with_negative_ones())})).empty());
}

TEST(Sharpness, IsGivenUpWhereNobodyWantsItAnyMore) {
  const Extents extents({16, 12});
  const FilterSpec filter = product({group({0, 1}, gauss(1))});
  int all = 0;
  const auto trials = try_sharpness(extents, filter, SampleScale::line, [&] { return ++all > 0; });
  EXPECT_EQ(errors_of(trials), errors_of(try_sharpness(extents, filter)));
  // Also in the last round of the last trial.
  for (const int last : {1, 3, all}) {
    int asked = 0;
    EXPECT_TRUE(try_sharpness(extents, filter, SampleScale::line, [&] { return ++asked < last; }).empty());
    EXPECT_EQ(asked, last);
  }
}

// R of the samples that 8 bits hold.
double error_of(const ConstructProblem& problem) {
  AloneConstruction run(problem);
  run.finish();
  const Extents& extents = problem.extents;
  const auto n = static_cast<double>(extents.cells_per_slice());
  std::vector<std::vector<float>> slices;
  for (const std::vector<std::uint32_t>& places : run.places()) {
    std::vector<float>& samples = slices.emplace_back();
    for (const std::uint32_t place : places) {
      samples.push_back(static_cast<float>((std::floor(256 * (place + 0.5) / n) + 0.5) / 256));
    }
  }
  const Footprint footprint(extents, problem.filter);
  const auto values = [&](SliceIndex slice) { return slices[static_cast<std::size_t>(slice)].data(); };
  std::vector<double> sums;
  for (const SliceIndex slice : extents.slices()) {
    sums.push_back(weighted_distance_sum(footprint, DistanceKind::absolute, 1, slice, values, PairEnds::one));
  }
  const MeanDistance mean(DistanceKind::absolute, 1, extents.cells_per_slice(), extents.num_slices());
  ThreadPool pool(1);
  const auto list = [&](SliceIndex slice) { return slices[static_cast<std::size_t>(slice)]; };
  return relative_error(footprint, mean.compute(list, pool), sums);
}

ConstructProblem usual(std::vector<std::int64_t> sizes, FilterSpec filter) {
  ConstructProblem problem = construct_problem("usual", std::move(sizes), std::move(filter));
  problem.spec.density = ConstructSpec{}.density;
  problem.spec.sharpness = best_sharpness(try_sharpness(problem.extents, problem.filter));
  return problem;
}

// Over twelve seeds R of the plane is 0.0890 with a standard deviation of 0.0003, and over six that of the volume is
// 0.0459 with 0.00004; with the overlap itself they are 0.094 and 0.0505. The limits leave room for a change of the
// algorithm, not for the seeds, which are fixed.
TEST(Sharpness, MakesConstructionsOfLowError) {
  const ConstructProblem plane = usual({64, 64}, product({group({0, 1}, gauss(1))}));
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const double error = error_of(plane.with_seed(seed));
    EXPECT_LE(error, 0.0905) << seed;
    EXPECT_GT(error_of(plane.with_seed(seed).with_sharpness(1)), 1.03 * error) << seed;
  }
  if (under_sanitizers) return;
  const ConstructProblem volume =
      usual({64, 64, 16}, product({group({0, 1}, gauss(1.3435)), group({2}, ema(0.1, 0.1))}));
  const double error = error_of(volume);
  EXPECT_LE(error, 0.0470);
  EXPECT_GT(error_of(volume.with_sharpness(1)), 1.05 * error);
}

}  // namespace
}  // namespace noiseloom
