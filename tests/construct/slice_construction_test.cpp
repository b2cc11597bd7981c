#include "noiseloom/construct/slice_construction.h"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <algorithm>
#include <functional>
#include <numeric>
#include <set>

#include "support/construct_problems.h"
#include "support/mpi_session.h"
#include "support/slice_construction_oracle.h"

namespace noiseloom {
namespace {

using namespace testing_support;
using Places = oracle::SliceConstructionOracle::Places;

bool is_permutation_of_places(std::vector<std::uint32_t> places) {
  std::sort(places.begin(), places.end());
  for (std::size_t k = 0; k < places.size(); ++k) {
    if (places[k] != k) return false;
  }
  return true;
}

// Round by round, so that a difference is seen where it begins.
void expect_equals_slow_twin(const ConstructProblem& problem) {
  SCOPED_TRACE(problem.name + ", " + problem.extents.to_string());
  AloneConstruction fast(problem);
  oracle::SliceConstructionOracle slow(problem.extents, problem.filter, problem.scale, problem.spec, problem.seed,
                                       fast->points_per_visit());
  for (; !slow.done(); slow.advance(), fast->advance()) {
    ASSERT_EQ(fast->progress(), slow.progress());
    ASSERT_EQ(fast.places(), slow.places())
        << "before round " << slow.progress().rounds << " of phase " << static_cast<int>(slow.progress().phase);
  }
  ASSERT_TRUE(fast->done());
  ASSERT_EQ(fast->progress(), slow.progress());
  ASSERT_EQ(fast.places(), slow.places());
  for (const auto& slice : fast.places()) EXPECT_TRUE(is_permutation_of_places(slice));
}

TEST(SliceConstruction, EqualsSlowTwinForEveryKindOfFilter) {
  for (const ConstructProblem& problem : problems_on_both_scales()) expect_equals_slow_twin(problem);
}

TEST(SliceConstruction, EqualsSlowTwinForEverySharpness) {
  for (const double sharpness : {0.5, 1.0, 2.0, 8.0}) {
    for (const ConstructProblem& problem : construct_problems()) {
      if (problem.extents.num_cells() >= 500) continue;
      expect_equals_slow_twin(problem.with_sharpness(sharpness));
      expect_equals_slow_twin(problem.on_circle().with_sharpness(sharpness));
    }
  }
}

FilterSpec spatial_and_temporal(const KernelSpec& plane, const KernelSpec& along, int num_axes) {
  return num_axes < 3 ? product({group({0, 1}, plane)}) : product({group({0, 1}, plane), group({2}, along)});
}

TEST(SliceConstruction, EqualsSlowTwinForThinAndTinySlices) {
  const std::vector<std::vector<std::int64_t>> all_sizes = {{1, 31},   {31, 1},   {2, 2},     {1, 1},     {3, 29},
                                                            {67, 2},   {1, 1, 7}, {2, 2, 3},  {1, 13, 2}, {17, 1, 3},
                                                            {3, 2, 5}, {2, 3, 1}, {130, 3, 2}};
  for (const auto& sizes : all_sizes) {
    const FilterSpec boxes = spatial_and_temporal(box(3), ema(0.1, 0.1), static_cast<int>(sizes.size()));
    expect_equals_slow_twin(construct_problem("thin", sizes, boxes).on_circle());
    for (const double density : {0.1, 0.5}) {
      const FilterSpec filter = spatial_and_temporal(gauss(1), ema(0.1, 0.1), static_cast<int>(sizes.size()));
      expect_equals_slow_twin(construct_problem("thin", sizes, filter).with_density(density));
      const FilterSpec signs = spatial_and_temporal(taps_with_negative_ones(), box(3), static_cast<int>(sizes.size()));
      expect_equals_slow_twin(construct_problem("thin with negative taps", sizes, signs).with_density(density));
    }
  }
}

TEST(SliceConstruction, EqualsSlowTwinWhereTheFootprintIsLargerThanAnAxis) {
  const FilterSpec wide = product({group({0, 1}, gauss(8)), group({2}, box(5))});
  expect_equals_slow_twin(construct_problem("wide", {5, 7, 3}, wide));
  expect_equals_slow_twin(construct_problem("wide", {18, 4, 2}, wide));
  expect_equals_slow_twin(construct_problem("wide", {11, 13, 4}, wide).with_sharpness(1));
  expect_equals_slow_twin(
      construct_problem("wide", {4, 3, 2}, product({group({0, 1, 2}, joint_taps()), group({0}, box(9))})));
}

// Several picks a visit, and more cells than one branch of bounds (4096).
TEST(SliceConstruction, EqualsSlowTwinInLargeSlices) {
  const ConstructProblem two_branches = construct_problem("large", {67, 67}, product({group({0, 1}, gauss(1))}));
  EXPECT_GT(AloneConstruction(two_branches)->points_per_visit(), 1);
  expect_equals_slow_twin(two_branches.with_density(0.03));
  expect_equals_slow_twin(two_branches.on_circle());
  expect_equals_slow_twin(
      construct_problem("large", {47, 49, 2}, product({group({0, 1}, box(3)), group({2}, ema(0.1, 0.1))}))
          .with_density(0.03));
  expect_equals_slow_twin(
      construct_problem("large", {47, 49, 2}, product({group({0, 1}, box(3)), group({2}, ema(0.1, 0.1))})).on_circle());
  expect_equals_slow_twin(
      construct_problem("large", {48, 48}, product({group({0, 1}, taps_with_negative_ones())})).with_density(0.05));
}

TEST(SliceConstruction, EqualsSlowTwinForAnyNumberOfStartPoints) {
  const ConstructProblem problem =
      construct_problem("start", {13, 11, 5}, product({group({0, 1}, gauss(1)), group({2}, ema(0.1, 0.1))}));
  for (const int points : {0, 1, 2, 3, 50, 71}) {
    const ConstructProblem with_points = problem.with_density((points + 0.5) / 143);
    ASSERT_EQ(AloneConstruction(with_points)->progress().num_start_points, points);
    expect_equals_slow_twin(with_points);
  }
  ASSERT_EQ(AloneConstruction(problem.with_density(0.5))->progress().num_start_points, 71);
  expect_equals_slow_twin(problem.with_density(0.5));
}

TEST(SliceConstruction, EqualsSlowTwinForTheHardestKernels) {
  for (const double sigma : {0.05, 0.2, 30.0}) {
    expect_equals_slow_twin(construct_problem("sigma", {13, 11}, product({group({0, 1}, gauss(sigma))})));
    expect_equals_slow_twin(construct_problem("sigma", {13, 11}, product({group({0, 1}, gauss_energy(sigma))})));
    expect_equals_slow_twin(
        construct_problem("sigma", {7, 5, 6}, product({group({0, 1}, gauss(sigma)), group({2}, gauss(sigma))})));
  }
  for (const double alpha : {1e-6, 1.0}) {
    for (const double rejection : {0.0, 1.0}) {
      expect_equals_slow_twin(
          construct_problem("ema", {7, 5, 6}, product({group({0, 1}, gauss(1)), group({2}, ema(alpha, rejection))})));
      expect_equals_slow_twin(construct_problem(
          "ema", {7, 5, 6}, sum({group({0, 1}, gauss(1), 0.5), group({2}, ema(alpha, rejection), 0.5)})));
    }
  }
}

TEST(SliceConstruction, EqualsSlowTwinWhereNoPixelOfASliceActsOnAnother) {
  expect_equals_slow_twin(construct_problem("time alone", {7, 5, 9}, product({group({2}, ema(0.1, 0.1))})));
  expect_equals_slow_twin(construct_problem("time alone", {13, 11, 3}, product({group({2}, box(2))})));
  expect_equals_slow_twin(construct_problem("no reach", {13, 11, 3}, product({group({0, 1}, box(1))})));
}

TEST(SliceConstruction, GoesByHashAloneWhereAllPixelsTie) {
  const ConstructProblem problem = construct_problem("ties", {71, 67, 3}, product({group({0, 1}, box(1))}));
  const Places places = places_of(problem);
  const VacTieHash hash(problem.seed);
  const std::uint64_t cells = 71 * 67;
  for (std::uint64_t slice = 0; slice < 3; ++slice) {
    std::vector<std::uint64_t> by_hash(cells);
    std::iota(by_hash.begin(), by_hash.end(), slice * cells);
    std::sort(by_hash.begin(), by_hash.end(), [&](std::uint64_t a, std::uint64_t b) { return hash(a) < hash(b); });
    for (std::size_t k = 0; k < cells; ++k) ASSERT_EQ(places[slice][by_hash[k] - slice * cells], k);
  }
}

TEST(SliceConstruction, EqualsSlowTwinOnACircleWhereNoPixelActsOnAnother) {
  expect_equals_slow_twin(construct_problem("ties", {9, 7, 3}, product({group({0, 1}, box(1))})).on_circle());
  expect_equals_slow_twin(construct_problem("time alone", {7, 5, 9}, product({group({2}, ema(0.1, 0.1))})).on_circle());
}

TEST(SliceConstruction, GivesEverySeedAnotherPattern) {
  const ConstructProblem problem = construct_problem("seeds", {16, 16, 2}, product({group({0, 1}, gauss(1))}));
  const Places one = places_of(problem);
  EXPECT_NE(one, places_of(problem.with_seed(2)));
  EXPECT_NE(one[0], one[1]);
}

// Phases, and how many rounds each may take: what a run is told beforehand.
TEST(SliceConstruction, EndsAfterAsManyRoundsAsItSays) {
  for (const ConstructProblem& problem : problems_on_both_scales()) {
    AloneConstruction run(problem);
    const std::int64_t cells = problem.extents.cells_per_slice();
    const std::int64_t points = run->points_per_visit();
    const std::int64_t start = run->progress().num_start_points;
    std::int64_t rounds[6] = {};
    double fraction = run->fraction();
    while (!run->done()) {
      ++rounds[static_cast<std::size_t>(run->progress().phase)];
      run->advance();
      EXPECT_GE(run->fraction(), fraction) << problem.name;
      fraction = run->fraction();
    }
    EXPECT_EQ(fraction, 1);
    const auto visits = [points](std::int64_t picks) { return (picks + points - 1) / points; };
    const bool circular = problem.scale == SampleScale::circle;
    EXPECT_EQ(rounds[0], circular ? visits(start) : 0) << problem.name;
    EXPECT_LE(rounds[1], (circular ? start / 4 : 4 * start) / points + 1) << problem.name;
    EXPECT_EQ(rounds[2], circular ? 0 : visits(start)) << problem.name;
    EXPECT_EQ(rounds[3], circular ? 0 : visits(cells - start)) << problem.name;
    EXPECT_EQ(rounds[4], circular ? visits(cells - start) : 0) << problem.name;
    run->advance();  // does nothing
    EXPECT_TRUE(run->done());
  }
}

TEST(SliceConstruction, RelaxesToLessEnergyThanARandomPattern) {
  for (const ConstructProblem& problem : construct_problems()) {
    const ConstructProblem relaxed = problem.with_density(0.2);
    AloneConstruction run(relaxed);
    const oracle::SliceConstructionOracle twin(relaxed.extents, relaxed.filter, relaxed.scale, relaxed.spec,
                                               relaxed.seed, run->points_per_visit());
    const std::int64_t random = twin.energy_of(run.places(), pixel_is_on);
    Places last = run.places();
    while (run->progress().phase == ConstructPhase::relax) {
      last = run.places();
      run->advance();
    }
    EXPECT_LT(twin.energy_of(last, pixel_is_on), random) << problem.name;
  }
}

// Slices of one class that are coupled move against the state before: none sees the other's swap in time.
TEST(SliceConstruction, EndsRelaxingWhereSlicesChaseEachOther) {
  const FilterSpec mostly_time = sum({group({0, 1}, box(2), 0.25), group({2}, ema(0.01, 0), 0.75)});
  const ConstructProblem problem = construct_problem("chase", {4, 4, 32}, mostly_time).with_density(0.3);
  AloneConstruction run(problem);
  const std::int64_t most_rounds = 4 * run->progress().num_start_points + 1;
  std::int64_t rounds = 0;
  for (; run->progress().phase == ConstructPhase::relax; ++rounds) run->advance();
  EXPECT_EQ(rounds, most_rounds) << "the slices of this problem no longer chase each other: choose another";
  run.finish();
  for (const auto& places : run.places()) EXPECT_TRUE(is_permutation_of_places(places));
  expect_equals_slow_twin(problem);
}

TEST(SliceConstruction, DoesNotDependOnThreads) {
  for (const ConstructProblem& problem : problems_on_both_scales()) {
    if (problem.extents.num_slices() == 1) continue;
    const Places one = places_of(problem);
    for (const int threads : {2, 5}) EXPECT_EQ(places_of(problem, threads), one) << problem.name;
  }
}

TEST(SliceConstruction, DoesNotDependOnTheWidthOfVectors) {
  const std::vector<ConstructProblem> problems = {
      construct_problem("narrow", {37, 23, 4}, product({group({0, 1}, gauss(1)), group({2}, ema(0.1, 0.1))})),
      construct_problem("wide", {41, 17}, product({group({0, 1}, gauss(3))})),
      construct_problem("signs", {13, 12}, product({group({0, 1}, taps_with_negative_ones())}))};
  for (const ConstructProblem& problem : problems) {
    const Places best = places_of(problem);
    for (std::int64_t rest = hwy::SupportedTargets() & HWY_TARGETS; rest != 0; rest &= rest - 1) {
      const std::int64_t target = rest & -rest;
      hwy::SetSupportedTargetsForTest(target);
      hwy::GetChosenTarget().DeInit();
      EXPECT_EQ(places_of(problem), best) << problem.name << ", " << hwy::TargetName(target);
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().DeInit();
  }
}

// Restoring computes all energies from nothing.
TEST(SliceConstruction, GoesOnFromTheStateBetweenAnyTwoRounds) {
  for (const ConstructProblem& problem : problems_on_both_scales()) {
    if (problem.extents.num_cells() > 300) continue;
    const Places whole = places_of(problem);
    std::set<ConstructPhase> phases;
    for (AloneConstruction straight(problem);; straight->advance()) {
      phases.insert(straight->progress().phase);
      AloneConstruction resumed(problem);
      resumed->restore(straight->progress(), [&](SliceIndex slice) { return straight->places(slice); });
      ASSERT_EQ(resumed->progress(), straight->progress());
      resumed.finish();
      ASSERT_EQ(resumed.places(), whole) << problem.name;
      if (straight->done()) break;
    }
    EXPECT_EQ(phases.size(), 4U) << problem.name;
  }
}

// Every state that a run comes through, in every slice.
void for_each_state(const std::function<void(const ConstructProgress&, const std::vector<std::uint32_t>&)>& body) {
  for (const std::int64_t slices : {1, 5}) {
    const FilterSpec filter = product({group({0, 1}, gauss(1)), group({2}, ema(0.1, 0.1))});
    const ConstructProblem problem = construct_problem("states", {7, 5, slices}, filter).with_density(0.2);
    for (const ConstructProblem& scaled : {problem, problem.on_circle()}) {
      AloneConstruction run(scaled);
      for (;; run->advance()) {
        for (const std::vector<std::uint32_t>& places : run.places()) body(run->progress(), places);
        if (run->done()) break;
      }
    }
  }
}

TEST(IsSound, AcceptsEveryStateOfARun) {
  std::set<ConstructPhase> phases;
  for_each_state([&](const ConstructProgress& progress, const std::vector<std::uint32_t>& places) {
    phases.insert(progress.phase);
    EXPECT_TRUE(is_sound(progress, places));
  });
  EXPECT_EQ(phases.size(), 6U);
  AloneConstruction none(construct_problem("none", {7, 5}, product({group({0, 1}, gauss(1))})).with_density(0));
  EXPECT_TRUE(is_sound(none->progress(), none->places(SliceIndex(0))));
}

// Every entry exchanged for every other kind of entry.
TEST(IsSound, RefusesPlacesThatAreNotThoseOfTheProgress) {
  for_each_state([&](const ConstructProgress& progress, const std::vector<std::uint32_t>& sound) {
    std::vector<std::uint32_t> others = {pixel_is_on, pixel_is_off, 35, 1000, pixel_is_on - 1};
    others.insert(others.end(), sound.begin(), sound.end());
    others.push_back(static_cast<std::uint32_t>(progress.num_placed));
    others.push_back(static_cast<std::uint32_t>(progress.num_start_points - progress.num_placed - 1));
    for (std::size_t cell = 0; cell < sound.size(); cell += 3) {
      std::vector<std::uint32_t> places = sound;
      for (const std::uint32_t other : others) {
        if (other == sound[cell]) continue;
        places[cell] = other;
        ASSERT_FALSE(is_sound(progress, places)) << other << " in place of " << sound[cell];
      }
    }
  });
}

TEST(IsSound, RefusesAProgressThatIsNotThatOfThePlaces) {
  for_each_state([&](const ConstructProgress& progress, const std::vector<std::uint32_t>& places) {
    const auto expect_refused = [&](auto change) {
      ConstructProgress other = progress;
      change(other);
      EXPECT_FALSE(is_sound(other, places)) << static_cast<int>(progress.phase) << ", " << progress.num_placed;
    };
    for (const std::int64_t change : {-1000, -36, -1, 1, 36, 1000}) {
      expect_refused([&](ConstructProgress& other) { other.num_placed += change; });
    }
    expect_refused([](ConstructProgress& other) { other.phase = static_cast<ConstructPhase>(6); });
    expect_refused([](ConstructProgress& other) { other.phase = static_cast<ConstructPhase>(-1); });
    expect_refused([](ConstructProgress& other) { other.rounds = -1; });
    expect_refused([](ConstructProgress& other) { other.num_start_points = -1; });
    expect_refused([](ConstructProgress& other) { other.num_start_points = 36; });
    if (progress.phase == ConstructPhase::fill) {
      expect_refused([](ConstructProgress& other) { other.num_start_points = other.num_placed + 1; });
    }
    if (progress.phase == ConstructPhase::relax || progress.phase == ConstructPhase::drain) {
      expect_refused([](ConstructProgress& other) { ++other.num_start_points; });
      expect_refused([](ConstructProgress& other) { other.phase = ConstructPhase::done; });
    }
  });
}

// Of a file that says that relaxing has gone on for longer than it may.
TEST(SliceConstruction, EndsRelaxingWhateverNumberOfRoundsItGoesOnFrom) {
  const ConstructProblem problem = construct_problem("rounds", {13, 11}, product({group({0, 1}, gauss(1))}));
  AloneConstruction from(problem);
  ConstructProgress progress = from->progress();
  progress.rounds = 1'000'000;
  AloneConstruction run(problem);
  run->restore(progress, [&](SliceIndex slice) { return from->places(slice); });
  run->advance();
  EXPECT_EQ(run->progress().phase, ConstructPhase::drain);
}

}  // namespace
}  // namespace noiseloom
