#include "noiseloom/optimize/void_and_cluster.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <set>
#include <string>

#include "optimize/vac_field.h"
#include "optimize/vac_kernel.h"
#include "support/void_and_cluster_oracle.h"

namespace noiseloom {
namespace {

constexpr std::int64_t everything = std::numeric_limits<std::int64_t>::max();

VacSpec make_spec(std::vector<std::int64_t> sizes, std::vector<std::vector<int>> groups, double sigma = 1.9,
                  std::uint64_t seed = 1) {
  VacSpec spec{.extents = Extents(std::move(sizes)), .groups = {}, .toroidal = {}};
  for (auto& axes : groups) spec.groups.push_back({std::move(axes), sigma});
  spec.seed = seed;
  return spec;
}

// MPI for the whole test program.
class MpiEnvironment : public testing::Environment {
 public:
  void SetUp() override {
    int argc = 0;
    char** argv = nullptr;
    session_ = std::make_unique<MpiSession>(argc, argv);
  }
  void TearDown() override { session_.reset(); }

 private:
  std::unique_ptr<MpiSession> session_;
};
[[maybe_unused]] const auto* const mpi = testing::AddGlobalTestEnvironment(new MpiEnvironment);

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
    for (SliceIndex slice = 0; slice < run_.partition().num_slices(); ++slice) {
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
  for (const std::uint64_t seed : {1, 2, 3}) expect_equals_oracle(make_spec({16, 16}, {{0, 1}}, 1.9, seed));
  expect_equals_oracle(make_spec({31, 23}, {{0, 1}}, 1.5));
  expect_equals_oracle(make_spec({67, 13}, {{0, 1}}, 1.5));  // rows longer than one word of bits, leaves across rows
  expect_equals_oracle(make_spec({13, 67}, {{1, 0}}, 1.1));
}

TEST(VoidAndCluster, EqualsSlowTwinIn3D) {
  expect_equals_oracle(make_spec({11, 7, 9}, {{0, 1, 2}}, 1.2));
  expect_equals_oracle(make_spec({8, 8, 8}, {{0, 1, 2}}, 1.9));
}

TEST(VoidAndCluster, EqualsSlowTwinIn2Dx1D) {
  expect_equals_oracle(make_spec({13, 11, 5}, {{0, 1}, {2}}));
  expect_equals_oracle(make_spec({8, 8, 16}, {{0, 1}, {2}}));
  expect_equals_oracle(make_spec({5, 3, 37}, {{0, 1}, {2}}, 1.3));
}

TEST(VoidAndCluster, EqualsSlowTwinIn2Dx2D) {
  expect_equals_oracle(make_spec({7, 5, 3, 11}, {{0, 1}, {2, 3}}));
  expect_equals_oracle(make_spec({6, 6, 6, 6}, {{0, 1}, {2, 3}}, 0.9));
}

TEST(VoidAndCluster, EqualsSlowTwinIn2Dx1Dx1D) {
  expect_equals_oracle(make_spec({7, 5, 11, 3}, {{0, 1}, {2}, {3}}));
  expect_equals_oracle(make_spec({8, 8, 4, 4}, {{0, 1}, {2}, {3}}));
}

TEST(VoidAndCluster, EqualsSlowTwinForUnusualGroups) {
  expect_equals_oracle(make_spec({7, 9, 13}, {{0, 2}, {1}}));             // x with a slice axis, y alone
  expect_equals_oracle(make_spec({7, 9, 13}, {{1, 2}}, 1.4));             // y with a slice axis, x uncoupled
  expect_equals_oracle(make_spec({7, 9, 5}, {{0, 1}, {0, 2}, {1, 2}}));   // groups that share axes
  expect_equals_oracle(make_spec({5, 4, 3, 7, 2}, {{0, 1, 3}, {2, 4}}));  // five axes
  expect_equals_oracle(make_spec({9, 10, 11}, {{2}}));                    // each pixel alone over time
}

TEST(VoidAndCluster, EqualsSlowTwinWithASigmaPerGroup) {
  VacSpec spec = make_spec({13, 11, 7}, {{0, 1}, {2}});
  spec.groups[0].sigma_px = 2.3;
  spec.groups[1].sigma_px = 0.7;
  expect_equals_oracle(spec);
}

TEST(VoidAndCluster, EqualsSlowTwinForSizesOneTwoThree) {
  for (const std::int64_t x : {1, 2, 3}) {
    for (const std::int64_t y : {1, 2, 3}) {
      for (const std::int64_t t : {1, 2, 3}) {
        for (const double density : {0.1, 0.5}) {
          VacSpec spec = make_spec({x, y, t}, {{0, 1}, {2}});
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
    VacSpec spec = make_spec({13, 11, 5}, {{0, 1}, {2}});
    spec.toroidal = {(open & 1) == 0, (open & 2) == 0, (open & 4) == 0};
    expect_equals_oracle(spec);
    spec.groups = {{{0, 1, 2}, 1.3}};
    expect_equals_oracle(spec);
  }
  VacSpec spec = make_spec({5, 4, 7, 6}, {{0, 1}, {2, 3}});
  spec.toroidal = {true, true, false, false};
  expect_equals_oracle(spec);
}

TEST(VoidAndCluster, EqualsSlowTwinWhereTheFootprintIsLargerThanAnAxis) {
  expect_equals_oracle(make_spec({3, 29}, {{0, 1}}));
  expect_equals_oracle(make_spec({17, 13}, {{0, 1}}, 8));
  expect_equals_oracle(make_spec({101, 3}, {{0, 1}}, 8));  // rows of taps longer than one run of bits
  expect_equals_oracle(make_spec({4, 5, 41, 2}, {{0, 1}, {2, 3}}, 8));
}

TEST(VoidAndCluster, EqualsSlowTwinForNarrowKernels) {
  for (const double sigma : {0.05, 0.12, 0.3, 0.5}) {
    expect_equals_oracle(make_spec({17, 19}, {{0, 1}}, sigma));
    expect_equals_oracle(make_spec({7, 5, 11}, {{0, 1}, {2}}, sigma));
  }
}

TEST(VoidAndCluster, EqualsSlowTwinForAnyNumberOfStartPoints) {
  VacSpec spec = make_spec({13, 11, 3}, {{0, 1}, {2}});
  for (const int points : {0, 1, 2, 3, 100, 214}) {
    spec.density = (points + 0.5) / static_cast<double>(spec.extents.num_cells());
    ASSERT_EQ(vac_start_pattern(spec).size(), static_cast<std::size_t>(points));
    expect_equals_oracle(spec);
  }
}

TEST(VoidAndCluster, RanksByHashAloneWhenAllPixelsTie) {
  const VacSpec spec = make_spec({127, 131}, {{0, 1}}, 0.05);
  ASSERT_EQ(VacKernel(spec).weight_sum(), 0U);
  const auto ranks = ranks_of(spec);
  const VacTieHash hash(spec.seed);
  std::vector<std::uint64_t> by_hash(ranks.size());
  std::iota(by_hash.begin(), by_hash.end(), 0U);
  std::sort(by_hash.begin(), by_hash.end(), [&](std::uint64_t a, std::uint64_t b) { return hash(a) < hash(b); });
  for (std::size_t i = 0; i < by_hash.size(); ++i) ASSERT_EQ(ranks[by_hash[i]], i);
}

TEST(VoidAndCluster, RanksEveryPixelOnce) {
  auto ranks = ranks_of((make_spec({61, 67, 7}, {{0, 1}, {2}})));
  std::sort(ranks.begin(), ranks.end());
  for (std::size_t i = 0; i < ranks.size(); ++i) ASSERT_EQ(ranks[i], i);
}

TEST(VoidAndCluster, DoesNotDependOnHowPicksAreDivided) {
  const VacSpec spec = make_spec({23, 19, 6}, {{0, 1}, {2}});
  const auto whole = ranks_of(spec);
  for (const std::int64_t batch : {1, 2, 7, 100}) {
    LocalRun run(spec);
    while (!run->done()) run->advance(batch);
    EXPECT_EQ(run.ranks(), whole) << batch;
  }
}

TEST(VoidAndCluster, DoesNotDependOnTheWidthOfVectors) {
  const VacSpec spec = make_spec({37, 23, 5, 3}, {{0, 1}, {2, 3}});
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
  const VacSpec spec = make_spec({11, 7, 5}, {{0, 1}, {2}});
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
  LocalRun run(make_spec({16, 16}, {{0, 1}}));
  while (!run->done()) {
    const auto before = run->progress();
    run->advance(5);
    const auto& after = run->progress();
    ASSERT_LE(after.num_swaps + after.num_ranked, before.num_swaps + before.num_ranked + 5);
  }
}

TEST(VacStartPattern, DrawsEachPixelAtMostOnce) {
  VacSpec spec = make_spec({97, 89}, {{0, 1}});
  spec.density = 0.5;
  const auto points = vac_start_pattern(spec);
  EXPECT_EQ(points.size(), 97U * 89U / 2U);
  EXPECT_TRUE(std::is_sorted(points.begin(), points.end()));
  EXPECT_EQ(std::adjacent_find(points.begin(), points.end()), points.end());
  EXPECT_LT(points.back(), 97U * 89U);
}

TEST(VacKernel, LeavesRoomForAllNeighboursAndAFlag) {
  for (const double sigma : {0.3, 1.0, 1.9, 8.0, 30.0}) {
    for (const auto& groups : std::vector<std::vector<std::vector<int>>>{
             {{0, 1}}, {{0, 1, 2}}, {{0, 1}, {2}}, {{0, 1}, {2, 3}}, {{0, 1}, {2}, {3}}}) {
      const VacKernel kernel(make_spec({32, 31, 16, 17}, groups, sigma));
      std::uint64_t sum = 0;
      for (const VacGroupKernel& group : kernel.groups()) {
        for (const std::uint32_t weight : group.weights) sum += weight;
      }
      EXPECT_EQ(sum, kernel.weight_sum());
      EXPECT_LT(sum, std::uint64_t{vac_flag}) << sigma;
      if (kernel.scale_log2() < 30) {  // and no more room than one bit
        EXPECT_GE(sum * 2 + 32 * 31 * 16 * 17, std::uint64_t{vac_flag}) << sigma;
      }
    }
  }
}

TEST(VacKernel, ScalesByTheLargestPowerOfTwoThatFits) {
  for (const double sigma : {0.6, 1.9, 8.0}) {
    for (const auto& groups : std::vector<std::vector<std::vector<int>>>{{{0, 1}}, {{0, 1}, {2}}, {{0, 1, 2}}}) {
      const VacSpec spec = make_spec({13, 11, 7}, groups, sigma);
      const int scale_log2 = VacKernel(spec).scale_log2();
      EXPECT_LT(oracle::VoidAndClusterOracle(spec, scale_log2).largest_energy(), std::int64_t{vac_flag});
      EXPECT_TRUE(scale_log2 == 30 ||
                  oracle::VoidAndClusterOracle(spec, scale_log2 + 1).largest_energy() >= std::int64_t{vac_flag});
    }
  }
}

TEST(VacField, EnergyOfTheLastPixelIsTheSumOfAllWeightsAtTheLimits) {
  for (const double sigma : {0.3, 1.9, 8.0}) {
    const VacSpec spec = make_spec({29, 23, 7, 5}, {{0, 1}, {2, 3}}, sigma);
    const VacKernel kernel(spec);
    VacField field(spec, kernel, 0, spec.extents.num_slices());
    std::vector<std::uint64_t> all(static_cast<std::size_t>(spec.extents.num_cells()));
    std::iota(all.begin(), all.end(), 0U);
    field.turn_on(all);
    for (const std::uint64_t p : all) ASSERT_EQ(field.word(p), vac_flag + kernel.weight_sum());
    field.turn_off(all);
    for (const std::uint64_t p : all) ASSERT_EQ(field.word(p), 0U);
  }
}

TEST(VacField, SlicesOfItsOwnGetTheSameEnergiesFromPicksAnywhere) {
  for (const auto& groups :
       std::vector<std::vector<std::vector<int>>>{{{0, 1}, {2, 3}}, {{0, 1}, {2}, {3}}, {{0, 1, 2, 3}}, {{1, 3}}}) {
    const VacSpec spec = make_spec({13, 11, 5, 3}, groups, 1.3);
    const VacKernel kernel(spec);
    VacField whole(spec, kernel, 0, 15);
    const auto points = vac_start_pattern(spec);
    whole.turn_on(points);
    for (const auto& [begin, end] : std::vector<std::pair<SliceIndex, SliceIndex>>{{0, 4}, {4, 5}, {5, 15}, {7, 7}}) {
      VacField part(spec, kernel, begin, end);
      part.turn_on(points);
      for (std::uint64_t p = 0; p < 13U * 11U * 15U; ++p) {
        if (!part.has(p)) continue;
        ASSERT_EQ(part.word(p), whole.word(p));
      }
    }
  }
}

TEST(VacLayout, IndexesBeyondFourBillionPixels) {
  const VacSpec spec = make_spec({65536, 32768, 4, 3}, {{0, 1}, {2, 3}});
  const VacLayout layout(spec, 0, 12);
  const std::uint64_t position = 65535 + 65536ULL * (32767 + 32768ULL * (3 + 4 * 2));
  EXPECT_THAT(layout.coord(position), testing::ElementsAre(65535, 32767, 3, 2, 0, 0, 0, 0));
  EXPECT_EQ(position, static_cast<std::uint64_t>(spec.extents.num_cells()) - 1);
  EXPECT_EQ(layout.leaves, 65536LL * 32768 / 64);
}

TEST(VacTieHash, HasNoEqualsAmongSmallPositionsAndDependsOnTheHighWord) {
  const VacTieHash hash(7);
  std::vector<std::uint32_t> values(1U << 20);
  for (std::uint64_t p = 0; p < values.size(); ++p) values[p] = hash(p);
  EXPECT_NE(hash(5), hash(5 + (1ULL << 32)));
  std::sort(values.begin(), values.end());
  EXPECT_EQ(std::adjacent_find(values.begin(), values.end()), values.end());
}

TEST(CheckVacSpec, NamesEveryFault) {
  VacSpec spec = make_spec({8, 8}, {{0, 1}, {}, {0, 0, 2}}, -1);
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
