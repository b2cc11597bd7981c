#include "noiseloom/construct/void_and_cluster.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <set>
#include <string>

#include "construct/fields/vac_kernel.h"
#include "support/mpi_session.h"
#include "support/vac_specs.h"
#include "support/void_and_cluster_oracle.h"

namespace noiseloom {
namespace {

using namespace testing_support;

constexpr std::int64_t everything = std::numeric_limits<std::int64_t>::max();

// A run on this process alone.
class LocalRun {
 public:
  explicit LocalRun(const VacSpec& spec, int num_threads = 1)
      : communicator_(Communicator::self()), pool_(num_threads), run_(spec, communicator_, pool_) {
    run_.start();
  }
  VoidAndCluster& operator*() { return run_; }
  VoidAndCluster* operator->() { return &run_; }
  std::vector<std::uint64_t> ranks() const {
    std::vector<std::uint64_t> ranks;
    for (const SliceIndex slice : first_indices<SliceIndex>(run_.partition().num_slices())) {
      const auto bytes = run_.order(slice);
      std::vector<std::uint32_t> part(bytes.size() / sizeof(std::uint32_t));
      std::memcpy(part.data(), bytes.data(), bytes.size());
      ranks.insert(ranks.end(), part.begin(), part.end());
    }
    return ranks;
  }

 private:
  Communicator communicator_;
  ThreadPool pool_;
  VoidAndCluster run_;
};

std::vector<std::uint64_t> ranks_of(const VacSpec& spec) {
  LocalRun run(spec);
  run->advance(everything);
  EXPECT_TRUE(run->done());
  return run.ranks();
}

void expect_equals_oracle(const VacSpec& spec) {
  oracle::VoidAndClusterOracle slow(spec, VacKernel(spec).scale_log2());
  LocalRun fast(spec);
  fast->advance(everything);
  ASSERT_TRUE(fast->done());
  EXPECT_EQ(fast.ranks(), slow.order()) << spec.extents.to_string();
  EXPECT_EQ(fast->progress().num_swaps, slow.num_swaps());
}

TEST(VoidAndCluster, EqualsSlowTwinIn2D) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) expect_equals_oracle(vac_spec({16, 16}, {{0, 1}}, 1.9, seed));
  expect_equals_oracle(vac_spec({31, 23}, {{0, 1}}, 1.5));
  expect_equals_oracle(vac_spec({67, 13}, {{0, 1}}, 1.5));  // rows longer than one word of bits, leaves across rows
  expect_equals_oracle(vac_spec({13, 67}, {{1, 0}}, 1.1));
}

TEST(VoidAndCluster, EqualsSlowTwinIn3D) {
  expect_equals_oracle(vac_spec({11, 7, 9}, {{0, 1, 2}}, 1.2));
  expect_equals_oracle(vac_spec({8, 8, 8}, {{0, 1, 2}}, 1.9));
}

TEST(VoidAndCluster, EqualsSlowTwinIn2Dx1D) {
  expect_equals_oracle(vac_spec({13, 11, 5}, {{0, 1}, {2}}));
  expect_equals_oracle(vac_spec({8, 8, 16}, {{0, 1}, {2}}));
  expect_equals_oracle(vac_spec({5, 3, 37}, {{0, 1}, {2}}, 1.3));
}

TEST(VoidAndCluster, EqualsSlowTwinIn2Dx2D) {
  expect_equals_oracle(vac_spec({7, 5, 3, 11}, {{0, 1}, {2, 3}}));
  expect_equals_oracle(vac_spec({6, 6, 6, 6}, {{0, 1}, {2, 3}}, 0.9));
}

TEST(VoidAndCluster, EqualsSlowTwinIn2Dx1Dx1D) {
  expect_equals_oracle(vac_spec({7, 5, 11, 3}, {{0, 1}, {2}, {3}}));
  expect_equals_oracle(vac_spec({8, 8, 4, 4}, {{0, 1}, {2}, {3}}));
}

TEST(VoidAndCluster, EqualsSlowTwinForUnusualGroups) {
  expect_equals_oracle(vac_spec({7, 9, 13}, {{0, 2}, {1}}));             // x with a slice axis, y alone
  expect_equals_oracle(vac_spec({7, 9, 13}, {{1, 2}}, 1.4));             // y with a slice axis, x uncoupled
  expect_equals_oracle(vac_spec({7, 9, 5}, {{0, 1}, {0, 2}, {1, 2}}));   // groups that share axes
  expect_equals_oracle(vac_spec({5, 4, 3, 7, 2}, {{0, 1, 3}, {2, 4}}));  // five axes
  expect_equals_oracle(vac_spec({9, 10, 11}, {{2}}));                    // each pixel alone over time
}

TEST(VoidAndCluster, EqualsSlowTwinWithWeights) {
  VacSpec spec = vac_spec({13, 11, 7}, {{0, 1}, {2}});
  spec.groups[1].weight = 0.3;
  expect_equals_oracle(spec);
  spec = vac_spec({19, 17}, {{0, 1}, {0, 1}}, 1.3);  // one kernel of two widths
  spec.groups[1].sigma_px = 2.6;
  spec.groups[1].weight = 0.06;
  expect_equals_oracle(spec);
}

TEST(VoidAndCluster, EqualsSlowTwinWithASigmaPerGroup) {
  VacSpec spec = vac_spec({13, 11, 7}, {{0, 1}, {2}});
  spec.groups[0].sigma_px = 2.3;
  spec.groups[1].sigma_px = 0.7;
  expect_equals_oracle(spec);
}

TEST(VoidAndCluster, EqualsSlowTwinForSizesOneTwoThree) {
  for (const std::int64_t x : {1, 2, 3}) {
    for (const std::int64_t y : {1, 2, 3}) {
      for (const std::int64_t t : {1, 2, 3}) {
        for (const double density : {0.1, 0.5}) {
          VacSpec spec = vac_spec({x, y, t}, {{0, 1}, {2}});
          spec.density = density;
          expect_equals_oracle(spec);
          spec.groups = {{{0, 1, 2}, 1.9}};
          expect_equals_oracle(spec);
        }
      }
    }
  }
}

TEST(VoidAndCluster, EqualsSlowTwinOnNonToroidalAxes) {
  for (int open = 0; open < 8; ++open) {
    VacSpec spec = vac_spec({13, 11, 5}, {{0, 1}, {2}});
    spec.toroidal = {(open & 1) == 0, (open & 2) == 0, (open & 4) == 0};
    expect_equals_oracle(spec);
    spec.groups = {{{0, 1, 2}, 1.3}};
    expect_equals_oracle(spec);
  }
  VacSpec spec = vac_spec({5, 4, 7, 6}, {{0, 1}, {2, 3}});
  spec.toroidal = {true, true, false, false};
  expect_equals_oracle(spec);
}

TEST(VoidAndCluster, EqualsSlowTwinWhereTheFootprintIsLargerThanAnAxis) {
  expect_equals_oracle(vac_spec({3, 29}, {{0, 1}}));
  expect_equals_oracle(vac_spec({17, 13}, {{0, 1}}, 8));
  expect_equals_oracle(vac_spec({101, 3}, {{0, 1}}, 8));  // rows of taps longer than one run of bits
  expect_equals_oracle(vac_spec({4, 5, 41, 2}, {{0, 1}, {2, 3}}, 8));
}

TEST(VoidAndCluster, EqualsSlowTwinForNarrowKernels) {
  for (const double sigma : {0.05, 0.12, 0.3, 0.5}) {
    expect_equals_oracle(vac_spec({17, 19}, {{0, 1}}, sigma));
    expect_equals_oracle(vac_spec({7, 5, 11}, {{0, 1}, {2}}, sigma));
  }
}

TEST(VoidAndCluster, EqualsSlowTwinForAnyNumberOfStartPoints) {
  VacSpec spec = vac_spec({13, 11, 3}, {{0, 1}, {2}});
  for (const int points : {0, 1, 2, 3, 100, 214}) {
    spec.density = (points + 0.5) / static_cast<double>(spec.extents.num_cells());
    ASSERT_EQ(vac_start_pattern(spec).size(), static_cast<std::size_t>(points));
    expect_equals_oracle(spec);
  }
}

TEST(VoidAndCluster, RanksByHashAloneWhenAllPixelsTie) {
  const VacSpec spec = vac_spec({127, 131}, {{0, 1}}, 0.05);
  ASSERT_EQ(VacKernel(spec).weight_sum(), 0U);
  const auto ranks = ranks_of(spec);
  const VacTieHash hash(spec.seed);
  std::vector<std::uint64_t> by_hash(ranks.size());
  std::iota(by_hash.begin(), by_hash.end(), 0U);
  std::sort(by_hash.begin(), by_hash.end(), [&](std::uint64_t a, std::uint64_t b) { return hash(a) < hash(b); });
  for (std::size_t i = 0; i < by_hash.size(); ++i) ASSERT_EQ(ranks[by_hash[i]], i);
}

TEST(VoidAndCluster, RanksEveryPixelOnce) {
  auto ranks = ranks_of((vac_spec({61, 67, 7}, {{0, 1}, {2}})));
  std::sort(ranks.begin(), ranks.end());
  for (std::size_t i = 0; i < ranks.size(); ++i) ASSERT_EQ(ranks[i], i);
}

TEST(VoidAndCluster, DoesNotDependOnHowPicksAreDivided) {
  const VacSpec spec = vac_spec({23, 19, 6}, {{0, 1}, {2}});
  const auto whole = ranks_of(spec);
  for (const std::int64_t batch : {1, 2, 7, 100}) {
    LocalRun run(spec);
    while (!run->done()) run->advance(batch);
    EXPECT_EQ(run.ranks(), whole) << batch;
  }
}

TEST(VoidAndCluster, DoesNotDependOnThreads) {
  VacSpec bounded = vac_spec({13, 12, 11, 3}, {{0, 1}, {2, 3}});
  bounded.toroidal = {true, true, false, true};
  for (const VacSpec& spec :
       {vac_spec({23, 19, 6}, {{0, 1}, {2}}), vac_spec({9, 10, 5, 3}, {{0, 1}, {2, 3}}), vac_spec({61, 67}, {{0, 1}}),
        vac_spec({11, 5, 7, 3}, {{0, 1, 2}, {3}}), vac_spec({9, 8, 7}, {{0, 1}, {1, 2}}), bounded}) {
    const auto one = ranks_of(spec);
    for (const int threads : {2, 3, 5, 16}) {
      LocalRun run(spec, threads);
      run->advance(everything);
      EXPECT_EQ(run.ranks(), one) << threads;
    }
  }
}

TEST(VoidAndCluster, DoesNotDependOnTheLimitOfBatches) {
  const VacSpec spec = vac_spec({23, 19, 6}, {{0, 1}, {2}});
  const auto whole = ranks_of(spec);
  for (const std::int64_t batch : {1, 2, 7, 100}) {
    LocalRun run(spec);
    run->limit_batches(batch);
    run->advance(everything);
    EXPECT_EQ(run.ranks(), whole) << batch;
  }
}

TEST(VoidAndCluster, RefusesAnOrderThatIsNotThatOfItsProgress) {
  const VacSpec spec = vac_spec({11, 7, 5}, {{0, 1}, {2}});
  LocalRun from(spec);
  const auto order = [&](SliceIndex slice) { return from->order(slice); };
  for (; !from->done(); from->advance(10)) {
    VacProgress other = from->progress();
    ++other.num_placed;
    EXPECT_THROW(LocalRun(spec)->restore(other, order), UserError);
    other = from->progress();
    ++other.num_start_points;
    EXPECT_THROW(LocalRun(spec)->restore(other, order), UserError);
  }
  EXPECT_THROW(LocalRun(spec)->restore(VacProgress{.num_start_points = 38}, order), UserError);
}

TEST(VoidAndCluster, DoesNotDependOnTheWidthOfVectors) {
  const VacSpec spec = vac_spec({37, 23, 5, 3}, {{0, 1}, {2, 3}});
  const auto best = ranks_of(spec);
  for (std::int64_t rest = hwy::SupportedTargets() & HWY_TARGETS; rest != 0; rest &= rest - 1) {
    const std::int64_t target = rest & -rest;
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().DeInit();
    EXPECT_EQ(ranks_of(spec), best) << hwy::TargetName(target);
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().DeInit();
}

TEST(VoidAndCluster, ContinuesFromTheStateBetweenAnyTwoPicks) {
  const VacSpec spec = vac_spec({11, 7, 5}, {{0, 1}, {2}});
  const auto whole = ranks_of(spec);
  std::set<VacPhase> phases;
  LocalRun straight(spec);
  for (; !straight->done(); straight->advance(1)) {
    phases.insert(straight->progress().phase);
    LocalRun resumed(spec);
    resumed->restore(straight->progress(), [&](SliceIndex slice) { return straight->order(slice); });
    resumed->advance(everything);
    ASSERT_EQ(resumed.ranks(), whole);
    ASSERT_TRUE(resumed->done());
  }
  EXPECT_EQ(phases.size(), 3U);
}

TEST(VoidAndCluster, DoesAtMostAsManyPicksAsAsked) {
  LocalRun run(vac_spec({16, 16}, {{0, 1}}));
  while (!run->done()) {
    const auto before = run->progress();
    run->advance(5);
    const auto& after = run->progress();
    ASSERT_LE(after.num_swaps + after.num_placed, before.num_swaps + before.num_placed + 5);
  }
}

TEST(CheckVacSpec, NamesEveryFault) {
  VacSpec spec = vac_spec({8, 8}, {{0, 1}, {}, {0, 0, 2}}, -1);
  spec.density = 0.7;
  spec.toroidal = {true};
  try {
    check_vac_spec(spec);
    FAIL() << "no fault found";
  } catch (const UserError& error) {
    EXPECT_EQ(error.faults().size(), 9U);
    EXPECT_THAT(error.what(),
                testing::AllOf(testing::HasSubstr("groups[1].axes is empty"), testing::HasSubstr("there is no axis 2"),
                               testing::HasSubstr("axis 0 occurs more than once"), testing::HasSubstr("sigma = -1"),
                               testing::HasSubstr("density = 0.7"), testing::HasSubstr("toroidal has 1 values")));
  }
  EXPECT_THROW(LocalRun{spec}, UserError);
}

}  // namespace
}  // namespace noiseloom
