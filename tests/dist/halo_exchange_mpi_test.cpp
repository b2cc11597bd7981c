#include "noiseloom/dist/halo_exchange.h"

#include <gtest/gtest.h>

#include <map>
#include <numeric>

namespace noiseloom {
namespace {

std::vector<Swap> swaps_of(SliceIndex slice, std::uint32_t step) {
  std::vector<Swap> swaps;
  for (std::uint32_t k = 0; k < static_cast<std::uint32_t>(slice % 5) * step; ++k) {
    swaps.push_back({1000 * step + k, static_cast<std::uint32_t>(slice)});
  }
  return swaps;
}

// Every rank hears exactly the swaps of the slices that it needs, in their order, also where the footprint is deeper
// than its own slices and where ranks are empty.
TEST(HaloExchange, DeliversNeededSlicesOnceWithTheirSwaps) {
  const Communicator world = Communicator::world();
  for (const int reach : {0, 1, 4, 50}) {
    const Extents extents({3, 3, 11});
    std::vector<Extents::SliceCoord> offsets;
    for (int t = -reach; t <= reach; ++t) offsets.push_back({t});
    const Partition partition(11, world.size());
    const HaloPlan plan(extents, offsets, partition, world.rank());
    HaloExchange exchange(world, plan, partition);
    for (std::uint32_t step = 1; step <= 3; ++step) {
      std::vector<SliceIndex> moved;
      for (SliceIndex slice = static_cast<SliceIndex>(step) % 2; slice < 11; slice += 2) moved.push_back(slice);
      std::vector<SliceSwaps> own;
      for (const SliceIndex slice : moved) {
        if (partition.owner(slice) == world.rank()) own.push_back({slice, swaps_of(slice, step)});
      }
      exchange.begin(moved, own);
      std::map<SliceIndex, std::vector<Swap>> heard;
      for (SliceIndex slice = 0; slice < 11; ++slice) {
        const bool needed = std::find(plan.needed().begin(), plan.needed().end(), slice) != plan.needed().end();
        const bool moves = std::find(moved.begin(), moved.end(), slice) != moved.end();
        EXPECT_EQ(exchange.pending(slice), needed && moves);
      }
      exchange.wait([&](SliceIndex slice, std::span<const Swap> swaps) {
        EXPECT_FALSE(heard.contains(slice));
        heard[slice].assign(swaps.begin(), swaps.end());
      });
      for (const SliceIndex slice : plan.needed()) {
        const bool moves = std::find(moved.begin(), moved.end(), slice) != moved.end();
        EXPECT_EQ(heard.contains(slice), moves);
        if (moves) {
          EXPECT_EQ(heard[slice], swaps_of(slice, step));
        }
      }
      EXPECT_LE(heard.size(), plan.needed().size());
    }
    if (reach == 0) {
      EXPECT_EQ(exchange.messages_sent(), 0);
    }
  }
}

}  // namespace
}  // namespace noiseloom
