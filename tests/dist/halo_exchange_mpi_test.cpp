#include "noiseloom/dist/halo_exchange.h"

#include <gtest/gtest.h>

#include <map>
#include <numeric>

namespace noiseloom {
namespace {

std::vector<Swap> swaps_of(SliceIndex slice, std::uint32_t step) {
  std::vector<Swap> swaps;
  for (std::uint32_t k = 0; k < static_cast<std::uint32_t>(slice.value() % 5) * step; ++k) {
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
    const Distribution distribution(11, world.size(), world.rank());
    const HaloPlan plan(extents, offsets, distribution);
    HaloExchange exchange(world, plan, distribution);
    for (std::uint32_t step = 1; step <= 3; ++step) {
      std::vector<SliceIndex> moved;
      for (std::uint32_t slice = step % 2; slice < 11; slice += 2) moved.emplace_back(slice);
      std::vector<SliceSwaps> own;
      for (const SliceIndex slice : moved) {
        if (distribution.owns(slice)) own.push_back({slice, swaps_of(slice, step)});
      }
      exchange.begin(moved, own);
      std::map<SliceIndex, std::vector<Swap>> heard;
      for (const SliceIndex slice : first_indices<SliceIndex>(11)) {
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

// A rank that gives an exchange up while its messages, too long to be buffered, are still on their way: they arrive as
// they were sent, and the memory that they are sent from is not used for anything else.
TEST(HaloExchange, MessagesOfAnUnwoundExchangeStayWhole) {
  const Communicator world = Communicator::world();
  const Extents extents({3, 3, 11});
  const std::vector<Extents::SliceCoord> offsets{{-1}, {1}};
  const Distribution distribution(11, world.size(), world.rank());
  const HaloPlan plan(extents, offsets, distribution);
  const SliceIndex moving(distribution.slices_of(Communicator::root).past_last().value() - 1);
  std::vector<Swap> swaps(std::size_t{1} << 20);
  for (std::uint32_t k = 0; k < swaps.size(); ++k) swaps[k] = {k, k * 7919};
  if (world.is_root()) {
    {
      HaloExchange given_up(world, plan, distribution);
      given_up.begin(std::vector<SliceIndex>{moving}, std::vector<SliceSwaps>{{moving, swaps}});
    }
    const std::vector<std::uint64_t> others(swaps.size() + 1, ~std::uint64_t{0});  // takes memory that was given back
    world.barrier();
    EXPECT_EQ(others.back(), ~std::uint64_t{0});
    return;
  }
  HaloExchange exchange(world, plan, distribution);
  exchange.begin(std::vector<SliceIndex>{moving}, {});
  const bool needed = exchange.pending(moving);
  bool heard = false;
  exchange.wait([&](SliceIndex slice, std::span<const Swap> found) {
    EXPECT_EQ(slice, moving);
    EXPECT_TRUE(std::equal(found.begin(), found.end(), swaps.begin(), swaps.end()));
    heard = true;
  });
  EXPECT_EQ(heard, needed);
  world.barrier();
}

}  // namespace
}  // namespace noiseloom
