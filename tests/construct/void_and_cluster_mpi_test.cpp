// Void and cluster gives the order of its slow twin on any number of ranks and threads, in batches of any size, and
// after any interruption.
#include "noiseloom/construct/void_and_cluster.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "support/sanitizers.h"
#include "support/vac_specs.h"
#include "support/void_and_cluster_oracle.h"

namespace noiseloom {
namespace {

using namespace testing_support;

constexpr std::int64_t everything = std::numeric_limits<std::int64_t>::max();

std::vector<VacSpec> specs() {
  std::vector<VacSpec> all{vac_spec({17, 13}, {{0, 1}}, 1.5),               // one slice: all ranks but one are empty
                           vac_spec({11, 7, 9}, {{0, 1, 2}}, 1.2),          // blocks that cut a group with x
                           vac_spec({13, 11, 5}, {{0, 1}, {2}}),            //
                           vac_spec({7, 5, 3, 11}, {{0, 1}, {2, 3}}),       // blocks that cut the rows of the far plane
                           vac_spec({7, 5, 11, 3}, {{0, 1}, {2}, {3}}),     //
                           vac_spec({5, 3, 37}, {{2}}, 1.3),                // pixels on their own over time
                           vac_spec({7, 9, 13}, {{1, 2}}, 1.4),             //
                           vac_spec({5, 4, 3, 5, 2}, {{0, 1, 3}, {2, 4}}),  //
                           vac_spec({3, 29, 2}, {{0, 1}, {2}}, 8),          // footprints larger than an axis
                           vac_spec({13, 11, 3}, {{0, 1}, {2}}, 0.05, 4),   // no weights: all pixels tie
                           vac_spec({3, 2, 2}, {{0, 1}, {2}}),              // one point at the start
                           vac_spec({2, 1, 3}, {{0, 1, 2}}),                // none
                           vac_spec({13, 7, 5, 3}, {{0, 1}, {2, 3}, {1, 2}}, 0.7)};  // groups that share axes
  VacSpec stack = vac_spec({7, 6, 9}, {{0, 1}, {0, 1, 2}}, 1.1);                     // slices that act as one
  stack.groups[1].box_axes = {2};
  stack.groups[1].box_size = 3;
  all.push_back(stack);
  stack.groups[1].box_size = 100;  // all of them
  all.push_back(stack);
  VacSpec tiles = vac_spec({11, 9, 4}, {{0, 1, 2}}, 1.2);
  tiles.groups[0].tile_axes = {2};
  all.push_back(tiles);
  tiles = vac_spec({9, 11, 3, 4}, {{0, 1, 2, 3}, {2}}, 0.9);  // of each of three frames
  tiles.groups[0].tile_axes = {3};
  tiles.toroidal = {true, false, true, true};
  tiles.density = 0.2;
  all.push_back(tiles);
  VacSpec tail = vac_spec({12, 9, 3}, {{0, 1}, {2}}, 0.8);
  tail.groups[0].tail = 0.01;
  all.push_back(tail);
  tail.groups[0].tail_power = 0.7;
  tail.groups[1].tail = 1;
  tail.toroidal = {true, false, false};
  all.push_back(tail);
  VacSpec open = vac_spec({5, 4, 7, 6}, {{0, 1}, {2, 3}});
  open.toroidal = {true, false, false, true};
  all.push_back(open);
  VacSpec half = vac_spec({7, 6, 5}, {{0, 1}, {2}}, 0.3);
  half.density = 0.5;
  all.push_back(half);
  return all;
}

// The ranks of all slices, on every rank. *Collective*
std::vector<std::uint64_t> ranks_of(const VoidAndCluster& run, const Communicator& communicator) {
  std::vector<std::byte> own;
  for (const SliceIndex slice : Distribution(run.partition(), communicator.rank()).own_slices()) {
    const auto bytes = run.order(slice);
    own.insert(own.end(), bytes.begin(), bytes.end());
  }
  const auto bytes = communicator.gather_all(std::span<const std::byte>(own));
  std::vector<std::uint32_t> ranks(bytes.size() / sizeof(std::uint32_t));
  std::memcpy(ranks.data(), bytes.data(), bytes.size());
  return {ranks.begin(), ranks.end()};
}

TEST(VoidAndClusterRanks, EqualSlowTwin) {
  const Communicator world = Communicator::world();
  ThreadPool pool(1);
  const std::vector<VacSpec> all = specs();
  for (std::size_t i = 0; i < all.size(); i += under_sanitizers ? 2 : 1) {
    const VacSpec& spec = all[i];
    VoidAndCluster run(spec, world, pool);
    run.start();
    run.advance(everything);
    EXPECT_TRUE(run.done());
    const std::vector<std::uint64_t> ranks = ranks_of(run, world);
    // The twin takes longest of all: ranks share it.
    if (static_cast<int>(i) % world.size() != static_cast<int>(world.rank().value())) continue;
    oracle::VoidAndClusterOracle slow(spec, vac_scale_log2(spec));
    EXPECT_EQ(ranks, slow.order()) << spec.extents.to_string();
    EXPECT_EQ(run.progress().num_swaps, slow.num_swaps());
  }
}

TEST(VoidAndClusterRanks, GiveTheSameInBatchesOfAnySizeAndOnAnyNumberOfThreads) {
  const Communicator world = Communicator::world();
  const Communicator self = Communicator::self();
  for (const VacSpec& spec : {vac_spec({13, 11, 5}, {{0, 1}, {2}}), vac_spec({7, 5, 3, 11}, {{0, 1}, {2, 3}})}) {
    ThreadPool one(1);
    VoidAndCluster alone(spec, self, one);
    alone.start();
    alone.advance(everything);
    const auto expected = ranks_of(alone, self);
    for (const int threads : {1, 2, 3}) {
      for (const std::int64_t batch : {std::int64_t{1}, std::int64_t{7}, everything}) {
        ThreadPool pool(threads);
        VoidAndCluster run(spec, world, pool);
        run.limit_batches(batch);
        run.start();
        run.advance(everything);
        EXPECT_EQ(ranks_of(run, world), expected) << threads << " threads, batches of " << batch;
      }
    }
  }
}

// Large enough for batches of hundreds, which are divided.
TEST(VoidAndClusterRanks, GiveTheSameWhereThreadsAndRanksPickApart) {
  const Communicator world = Communicator::world();
  const Communicator self = Communicator::self();
  std::vector<VacSpec> specs{vac_spec({128, 64, 32}, {{0, 1}, {2}}), vac_spec({512, 257}, {{0, 1}})};  // windows
  specs.back().density = 0.01;
  specs.push_back(specs.back());
  specs.back().density = 0.1;
  specs.back().toroidal = {true, false};
  if (!under_sanitizers) specs.push_back(vac_spec({48, 32, 12, 12}, {{0, 1}, {2, 3}}));
  for (const VacSpec& spec : specs) {
    ThreadPool one(1);
    VoidAndCluster alone(spec, self, one);
    alone.start();
    alone.advance(everything);
    ThreadPool pool(2 + world.rank().value() % 2);
    VoidAndCluster run(spec, world, pool);
    run.start();
    const auto expected = ranks_of(alone, self);
    const auto expect_to_go_on = [&] {
      VoidAndCluster resumed(spec, world, pool);
      resumed.restore(run.progress(), [&](SliceIndex slice) { return run.order(slice); });
      resumed.advance(everything);
      EXPECT_EQ(ranks_of(resumed, world), expected) << spec.extents.to_string();
    };
    while (run.progress().phase == VacPhase::swap) run.advance(1);
    run.advance(run.progress().num_start_points / 2);
    EXPECT_TRUE(spec.density == 0 || run.progress().phase == VacPhase::drain);
    expect_to_go_on();
    const std::int64_t half = spec.extents.num_cells() / 2;
    while (run.progress().phase != VacPhase::fill || run.progress().num_placed < half) run.advance(10'007);
    expect_to_go_on();
    while (!run.done()) run.advance(10'007);
    EXPECT_EQ(ranks_of(run, world), expected) << spec.extents.to_string();
  }
}

// What one process had at any point goes on on all ranks, and the other way round.
TEST(VoidAndClusterRanks, GoOnFromTheOrderOfAnotherNumberOfRanks) {
  const Communicator world = Communicator::world();
  const Communicator self = Communicator::self();
  const VacSpec spec = vac_spec({7, 5, 3, 4}, {{0, 1}, {2, 3}});
  ThreadPool pool(1);
  VoidAndCluster straight(spec, self, pool);
  straight.start();
  straight.advance(everything);
  const auto expected = ranks_of(straight, self);
  std::int64_t phases[4] = {};
  VoidAndCluster alone(spec, self, pool);
  VoidAndCluster together(spec, world, pool);
  alone.start();
  together.start();
  while (!alone.done()) {
    ++phases[static_cast<std::size_t>(alone.progress().phase)];
    VoidAndCluster resumed(spec, world, pool);
    resumed.restore(alone.progress(), [&](SliceIndex slice) { return alone.order(slice); });
    resumed.advance(everything);
    EXPECT_EQ(ranks_of(resumed, world), expected);

    const auto ranks = ranks_of(together, world);
    const auto cells = static_cast<std::size_t>(spec.extents.cells_per_slice());
    VoidAndCluster back(spec, self, pool);
    back.restore(together.progress(), [&](SliceIndex slice) {
      std::vector<std::byte> bytes(cells * sizeof(std::uint32_t));
      std::vector<std::uint32_t> part;
      for (std::size_t i = 0; i < cells; ++i) {
        part.push_back(static_cast<std::uint32_t>(ranks[static_cast<std::size_t>(slice) * cells + i]));
      }
      std::memcpy(bytes.data(), part.data(), bytes.size());
      return bytes;
    });
    back.advance(everything);
    EXPECT_EQ(ranks_of(back, self), expected);

    alone.advance(13);
    together.advance(13);
    EXPECT_EQ(together.progress(), alone.progress());
  }
  EXPECT_GT(phases[0], 1);
  EXPECT_GT(phases[1], 1);
  EXPECT_GT(phases[2], 1);
}

// A slice that one rank cannot read, and an order of another time: all ranks are told, none is left behind.
TEST(VoidAndClusterRanks, AllThrowWhereOneCannotGoOn) {
  const Communicator world = Communicator::world();
  const VacSpec spec = vac_spec({7, 5, 3, 4}, {{0, 1}, {2, 3}});
  ThreadPool pool(1);
  VoidAndCluster run(spec, world, pool);
  run.start();
  run.advance(40);
  VoidAndCluster resumed(spec, world, pool);
  const SliceIndex last(run.partition().num_slices() - 1);
  EXPECT_THROW(resumed.restore(run.progress(),
                               [&](SliceIndex slice) {
                                 if (slice == last) throw EnvironmentError("cannot read");
                                 return run.order(slice);
                               }),
               SharedEnvironmentError);
  const VacProgress earlier = run.progress();
  run.advance(40);
  EXPECT_THROW(resumed.restore(earlier, [&](SliceIndex slice) { return run.order(slice); }), SharedUserError);
  resumed.restore(run.progress(), [&](SliceIndex slice) { return run.order(slice); });
  resumed.advance(1);  // some of a batch, the rest of which must not be gone on with after this
  resumed.restore(run.progress(), [&](SliceIndex slice) { return run.order(slice); });
  run.advance(everything);
  resumed.advance(everything);
  EXPECT_EQ(ranks_of(resumed, world), ranks_of(run, world));
}

TEST(VoidAndClusterRanks, CountWhatTravels) {
  if (under_sanitizers) GTEST_SKIP() << "counts messages, of which the tests above send all kinds";
  const Communicator world = Communicator::world();
  const VacSpec spec = vac_spec({64, 64, 32}, {{0, 1}, {2}});
  ThreadPool pool(1);
  VoidAndCluster run(spec, world, pool);
  run.start();
  while (run.progress().phase != VacPhase::fill) run.advance(1);
  const std::int64_t collectives = run.collectives();
  const std::int64_t bytes = run.bytes_sent();
  run.advance(everything);
  if (world.size() == 1) {
    EXPECT_EQ(run.collectives(), 0);
    EXPECT_EQ(run.bytes_sent(), 0);
    return;
  }
  const auto picks = static_cast<double>(spec.extents.num_cells()) * 0.9;
  EXPECT_LT(static_cast<double>(run.collectives() - collectives) / picks, 0.1);
  std::int64_t all = run.bytes_sent() - bytes;
  world.sum(std::span(&all, 1));
  EXPECT_LT(static_cast<double>(all) / picks, 20);
  EXPECT_GT(all, 0);
}

}  // namespace
}  // namespace noiseloom
