#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <set>

#include "noiseloom/core/distribution.h"
#include "noiseloom/dist/halo_plan.h"

namespace noiseloom {
namespace {

TEST(Partition, CoversEverySliceOnceInOrder) {
  for (const std::int32_t slices : {1, 2, 7, 31, 64, 101}) {
    for (int ranks = 1; ranks <= 64; ++ranks) {
      const Partition partition(slices, ranks);
      EXPECT_EQ(partition.begin(0), 0);
      EXPECT_EQ(partition.end(ranks - 1), slices);
      for (int rank = 0; rank < ranks; ++rank) {
        EXPECT_LE(partition.count(rank), (slices + ranks - 1) / ranks);
        for (std::int32_t slice = partition.begin(rank); slice < partition.end(rank); ++slice) {
          EXPECT_EQ(partition.part_of(slice), rank);
        }
      }
    }
  }
}

TEST(Distribution, SeesTheSamePartsFromEveryRank) {
  for (const std::int32_t slices : {1, 31, 101}) {
    for (int num_ranks = 1; num_ranks <= 64; ++num_ranks) {
      const Partition partition(slices, num_ranks);
      for (const Rank rank : first_indices<Rank>(num_ranks)) {
        const Distribution distribution(partition, rank);
        EXPECT_EQ(distribution.num_own(), partition.count(rank.value()));
        for (const SliceIndex slice : first_indices<SliceIndex>(slices)) {
          EXPECT_EQ(distribution.owner(slice), Rank(partition.part_of(slice.value())));
          EXPECT_EQ(distribution.owns(slice), distribution.owner(slice) == rank);
        }
        LocalSlice local;
        for (const SliceIndex slice : distribution.own_slices()) {
          EXPECT_EQ(distribution.local_slice_from_global(slice), local);
          EXPECT_EQ(distribution.global_slice_from_local(local), slice);
          ++local;
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
  for (int num_ranks = 1; num_ranks <= 64; ++num_ranks) {
    const Partition partition(extents.num_slices(), num_ranks);
    const IndexRange<Rank> ranks = first_indices<Rank>(num_ranks);
    IndexedVector<Rank, std::optional<HaloPlan>> plans(static_cast<std::size_t>(num_ranks));
    for (const Rank rank : ranks) plans[rank].emplace(extents, offsets, Distribution(partition, rank));
    for (const Rank rank : ranks) {
      // What a rank needs, found the slow way.
      const Distribution distribution(partition, rank);
      std::set<SliceIndex> needed;
      for (const SliceIndex slice : distribution.own_slices()) {
        for (const auto& offset : offsets) {
          const SliceIndex other = extents.slice_at(slice, offset);
          if (distribution.owner(other) != rank) needed.insert(other);
        }
      }
      const HaloPlan& plan = *plans[rank];
      EXPECT_TRUE(std::equal(needed.begin(), needed.end(), plan.needed().begin(), plan.needed().end()));
      for (const Rank peer : ranks) {
        for (const SliceIndex slice : distribution.slices_of(peer)) {
          const auto& listeners = plans[peer]->listeners(slice);
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
  const std::int32_t slices = 1'000'000;
  const int reach = 3500;
  const Extents extents({1, 1, slices});
  const auto offsets = within(reach, 0);
  const HaloPlan half(extents, offsets, {slices, 2, Rank(0)});
  EXPECT_EQ(std::ssize(half.needed()), 2 * reach);
  EXPECT_EQ(half.needed().front(), SliceIndex(slices / 2));
  EXPECT_EQ(half.needed().back(), SliceIndex(slices - 1));
  EXPECT_EQ(half.messages_per_sweep(), 2 * reach);
  EXPECT_EQ(half.listeners(SliceIndex(reach - 1)), std::vector<Rank>{Rank(1)});
  EXPECT_TRUE(half.listeners(SliceIndex(reach)).empty());
  const Distribution many(slices, 500, Rank(250));  // of 2000 slices: a reach of 3500 tells two ranks on either side
  const HaloPlan one(extents, offsets, many);
  const SliceIndex first = many.own_slices().first();
  EXPECT_EQ(std::ssize(one.needed()), 2 * reach);
  EXPECT_EQ(one.listeners(first), (std::vector<Rank>{Rank(248), Rank(249), Rank(251)}));
  EXPECT_EQ(one.listeners(SliceIndex(first.value() + 1999)), (std::vector<Rank>{Rank(249), Rank(251), Rank(252)}));
}

TEST(HaloPlan, NothingIsSentWithoutCoupling) {
  const Extents extents({3, 3, 11});
  const HaloPlan plan(extents, within(0, 0), {11, 4, Rank(1)});
  EXPECT_TRUE(plan.needed().empty());
  EXPECT_EQ(plan.messages_per_sweep(), 0);
}

}  // namespace
}  // namespace noiseloom
