#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "noiseloom/core/partition.h"
#include "noiseloom/dist/halo_plan.h"

namespace noiseloom {
namespace {

TEST(Partition, CoversEverySliceOnceInOrder) {
  for (const SliceIndex slices : {1, 2, 7, 31, 64, 101}) {
    for (int ranks = 1; ranks <= 64; ++ranks) {
      const Partition partition(slices, ranks);
      EXPECT_EQ(partition.begin(0), 0);
      EXPECT_EQ(partition.end(ranks - 1), slices);
      for (int rank = 0; rank < ranks; ++rank) {
        EXPECT_LE(partition.count(rank), (slices + ranks - 1) / ranks);
        for (SliceIndex slice = partition.begin(rank); slice < partition.end(rank); ++slice) {
          EXPECT_EQ(partition.owner(slice), rank);
        }
      }
    }
  }
}

std::vector<Extents::SliceCoord> within(int reach_t, int reach_z) {
  std::vector<Extents::SliceCoord> offsets;
  for (int z = -reach_z; z <= reach_z; ++z) {
    for (int t = -reach_t; t <= reach_t; ++t) offsets.push_back({t, z});
  }
  return offsets;
}

class HaloPlans : public testing::TestWithParam<std::pair<int, int>> {};

TEST_P(HaloPlans, SendWhatPeersReceive) {
  const Extents extents({2, 2, 7, 5});
  const auto offsets = within(GetParam().first, GetParam().second);
  for (int ranks = 1; ranks <= 64; ++ranks) {
    const Partition partition(extents.num_slices(), ranks);
    std::vector<HaloPlan> plans;
    for (int rank = 0; rank < ranks; ++rank) plans.emplace_back(extents, offsets, partition, rank);
    for (int rank = 0; rank < ranks; ++rank) {
      // What a rank needs, found the slow way.
      std::set<SliceIndex> needed;
      for (SliceIndex slice = partition.begin(rank); slice < partition.end(rank); ++slice) {
        for (const auto& offset : offsets) {
          const SliceIndex other = extents.slice_at(slice, offset);
          if (partition.owner(other) != rank) needed.insert(other);
        }
      }
      const auto& plan = plans[static_cast<std::size_t>(rank)];
      EXPECT_TRUE(std::equal(needed.begin(), needed.end(), plan.needed().begin(), plan.needed().end()));
      for (int peer = 0; peer < ranks; ++peer) {
        for (SliceIndex slice = partition.begin(peer); slice < partition.end(peer); ++slice) {
          const auto& listeners = plans[static_cast<std::size_t>(peer)].listeners(slice);
          EXPECT_EQ(std::binary_search(listeners.begin(), listeners.end(), rank), needed.contains(slice));
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Reaches, HaloPlans,
                         testing::Values(std::pair{0, 0}, std::pair{1, 0}, std::pair{3, 1}, std::pair{9, 2}));

// Slices times offsets would be 3.5e9.
TEST(HaloPlan, OfALongRingTakesNoTimeForEveryOffset) {
  const SliceIndex slices = 1'000'000;
  const int reach = 3500;
  const Extents extents({1, 1, slices});
  const auto offsets = within(reach, 0);
  const Partition halves(slices, 2);
  const HaloPlan half(extents, offsets, halves, 0);
  EXPECT_EQ(std::ssize(half.needed()), 2 * reach);
  EXPECT_EQ(half.needed().front(), slices / 2);
  EXPECT_EQ(half.needed().back(), slices - 1);
  EXPECT_EQ(half.messages_per_sweep(), 2 * reach);
  EXPECT_EQ(half.listeners(reach - 1), std::vector<int>{1});
  EXPECT_TRUE(half.listeners(reach).empty());
  const Partition many(slices, 500);  // of 2000 slices: a reach of 3500 tells two ranks on either side
  const HaloPlan one(extents, offsets, many, 250);
  EXPECT_EQ(std::ssize(one.needed()), 2 * reach);
  EXPECT_EQ(one.listeners(many.begin(250)), (std::vector<int>{248, 249, 251}));
  EXPECT_EQ(one.listeners(many.begin(250) + 1999), (std::vector<int>{249, 251, 252}));
}

TEST(HaloPlan, NothingIsSentWithoutCoupling) {
  const Extents extents({3, 3, 11});
  const Partition partition(11, 4);
  const HaloPlan plan(extents, within(0, 0), partition, 1);
  EXPECT_TRUE(plan.needed().empty());
  EXPECT_EQ(plan.messages_per_sweep(), 0);
}

}  // namespace
}  // namespace noiseloom
