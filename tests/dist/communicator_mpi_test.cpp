#include "noiseloom/dist/communicator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "noiseloom/core/error.h"
#include "noiseloom/dist/activity.h"

namespace noiseloom {
namespace {

std::vector<std::byte> block_of(SliceIndex slice) {
  // Sizes differ from slice to slice; contents are a function of the slice.
  return std::vector<std::byte>(static_cast<std::size_t>(slice.value() % 7 * 11),
                                static_cast<std::byte>(slice.value() + 1));
}

TEST(Communicator, StreamsBlocksToRootInSliceOrder) {
  const Communicator world = Communicator::world();
  const Distribution distribution(13, world.size(), world.rank());
  std::int32_t next = 0;
  world.stream_to_root(
      distribution,
      [&](SliceIndex slice, std::vector<std::byte>& block) {
        EXPECT_TRUE(distribution.owns(slice));
        block = block_of(slice);
      },
      [&](SliceIndex slice, std::span<const std::byte> block) {
        EXPECT_EQ(slice.value(), next++);
        const auto expected = block_of(slice);
        ASSERT_EQ(block.size(), expected.size());
        EXPECT_TRUE(std::equal(block.begin(), block.end(), expected.begin()));
      });
  EXPECT_EQ(next, world.is_root() ? 13 : 0);
}

// Wanted by rank r of 9 slices: those that r + 2 divides. Some slices nobody wants, some several ranks.
std::vector<SliceIndex> wanted_by(Rank rank) {
  std::vector<SliceIndex> wanted;
  for (const SliceIndex slice : first_indices<SliceIndex>(9)) {
    if (slice.value() % (rank.value() + 2) == 0) wanted.push_back(slice);
  }
  return wanted;
}

TEST(Communicator, StreamsBlocksFromRootToTheRanksThatWantThem) {
  const Communicator world = Communicator::world();
  const std::vector<SliceIndex> wanted = wanted_by(world.rank());
  std::vector<SliceIndex> produced;
  std::vector<SliceIndex> consumed;
  world.stream_from_root(
      wanted,
      [&](SliceIndex slice, std::vector<std::byte>& block) {
        EXPECT_TRUE(world.is_root());
        produced.push_back(slice);
        block = block_of(slice);
      },
      [&](SliceIndex slice, std::span<const std::byte> block) {
        consumed.push_back(slice);
        const auto expected = block_of(slice);
        ASSERT_EQ(block.size(), expected.size());
        EXPECT_TRUE(std::equal(block.begin(), block.end(), expected.begin()));
      });
  EXPECT_EQ(consumed, wanted);
  std::vector<SliceIndex> expected;  // on rank 0 each that anybody wants, once
  for (const SliceIndex slice : first_indices<SliceIndex>(world.is_root() ? 9 : 0)) {
    for (const Rank rank : world.ranks()) {
      if (slice.value() % (rank.value() + 2) != 0) continue;
      expected.push_back(slice);
      break;
    }
  }
  EXPECT_EQ(produced, expected);
}

TEST(Communicator, FailuresInAStreamFromRootReachEveryRank) {
  const Communicator world = Communicator::world();
  const Rank last(world.size() - 1);
  for (const bool producer : {true, false}) {
    SCOPED_TRACE(producer ? "producer" : "consumer");
    std::vector<SliceIndex> consumed;
    try {
      world.stream_from_root(
          wanted_by(Communicator::root),
          [&](SliceIndex slice, std::vector<std::byte>& block) {
            if (producer && slice == SliceIndex(4)) throw UserError("run.h5", "no such slice");
            block = block_of(slice);
          },
          [&](SliceIndex slice, std::span<const std::byte>) {
            if (!producer && world.rank() == last && slice == SliceIndex(4)) throw UserError("run.h5", "no such slice");
            consumed.push_back(slice);
          });
      ADD_FAILURE() << "nothing was thrown on rank " << world.rank();
    } catch (const SharedUserError& error) {
      EXPECT_STREQ(error.what(), "run.h5: no such slice");
    }
    // Nothing follows what could not be produced; the other ranks are not cut short by a consumer.
    if (producer || world.rank() == last) {
      EXPECT_EQ(consumed, (std::vector<SliceIndex>{SliceIndex(0), SliceIndex(2)}));
    } else {
      EXPECT_EQ(consumed, wanted_by(Communicator::root));
    }
    world.barrier();
  }
}

TEST(Communicator, FailureOfOneRankIsThrownOnAll) {
  const Communicator world = Communicator::world();
  const Rank failing(world.size() - 1);
  try {
    world.together([&] {
      if (world.rank() == failing) throw UserError("run.toml:3", "no such thing");
    });
    FAIL() << "nothing was thrown on rank " << world.rank();
  } catch (const UserError& error) {
    EXPECT_STREQ(error.what(), "run.toml:3: no such thing");
  }
  EXPECT_THROW(world.on_root([] { throw EnvironmentError("disk full"); }), EnvironmentError);
  world.barrier();  // nobody is left behind
}

TEST(Communicator, FailureOfTheConsumerDrainsTheStream) {
  const Communicator world = Communicator::world();
  const Distribution distribution(11, world.size(), world.rank());
  const auto stream = [&] {
    world.stream_to_root(
        distribution, [](SliceIndex slice, std::vector<std::byte>& block) { block = block_of(slice); },
        [](SliceIndex slice, std::span<const std::byte>) {
          if (slice == SliceIndex(3)) throw EnvironmentError("no space left");
        });
  };
  EXPECT_THROW(stream(), EnvironmentError);
  world.barrier();
}

TEST(Communicator, FailureOfAProducerReachesTheConsumerAndEveryRank) {
  const Communicator world = Communicator::world();
  const Distribution distribution(11, world.size(), world.rank());
  for (const std::int32_t bad : {0, 5, 10}) {
    SCOPED_TRACE("slice " + std::to_string(bad));
    std::int32_t consumed = 0;
    try {
      world.stream_to_root(
          distribution,
          [&](SliceIndex slice, std::vector<std::byte>& block) {
            if (slice == SliceIndex(bad)) throw EnvironmentError("no memory for slice " + std::to_string(bad));
            block = block_of(slice);
          },
          [&](SliceIndex slice, std::span<const std::byte> block) {
            EXPECT_EQ(slice.value(), consumed++);
            EXPECT_EQ(block.size(), block_of(slice).size());
          });
      ADD_FAILURE() << "nothing was thrown on rank " << world.rank();
    } catch (const SharedEnvironmentError& error) {
      EXPECT_EQ(error.what(), "no memory for slice " + std::to_string(bad));
    }
    EXPECT_EQ(consumed, world.is_root() ? bad : 0);  // never a block that was not produced
    world.barrier();
  }
}

TEST(Communicator, GathersInSliceOrderWithEmptyRanks) {
  const Communicator world = Communicator::world();
  for (const std::int32_t slices : {1, 2, 17}) {
    const Partition partition(slices, world.size());
    std::vector<double> own;
    for (const SliceIndex s : Distribution(partition, world.rank()).own_slices()) own.push_back(3.0 * s.value());
    const std::vector<double> all = world.gather_all(partition, own);
    ASSERT_EQ(std::ssize(all), slices);
    for (const SliceIndex s : first_indices<SliceIndex>(slices))
      EXPECT_EQ(all[static_cast<std::size_t>(s)], 3.0 * s.value());
  }
}

TEST(Communicator, GathersWordsAndBytesInTheOrderOfRanks) {
  const Communicator world = Communicator::world();
  const auto rank = static_cast<std::uint64_t>(world.rank().value());
  const std::vector<std::uint64_t> words{rank, rank * rank + (std::uint64_t{1} << 40)};
  const auto all_words = world.gather_all(std::span<const std::uint64_t>(words));
  const std::vector<std::byte> bytes(rank % 3, static_cast<std::byte>(rank));  // some ranks give none
  const auto all_bytes = world.gather_all(std::span<const std::byte>(bytes));
  std::vector<std::uint64_t> expected_words;
  std::vector<std::byte> expected_bytes;
  for (std::uint64_t r = 0; r < static_cast<std::uint64_t>(world.size()); ++r) {
    expected_words.insert(expected_words.end(), {r, r * r + (std::uint64_t{1} << 40)});
    expected_bytes.insert(expected_bytes.end(), r % 3, static_cast<std::byte>(r));
  }
  std::vector<int> counts;
  for (int r = 0; r < world.size(); ++r) counts.push_back(r % 3);
  EXPECT_EQ(world.gather_all(std::span<const std::byte>(bytes), counts), expected_bytes);
  EXPECT_EQ(all_words, expected_words);
  EXPECT_EQ(all_bytes, expected_bytes);
}

TEST(Communicator, FindsTheLeastPair) {
  const Communicator world = Communicator::world();
  const auto rank = static_cast<std::uint64_t>(world.rank().value());
  const auto last = static_cast<std::uint64_t>(world.size() - 1);
  using Pair = std::array<std::uint64_t, 2>;
  EXPECT_EQ(world.least({7 + rank, 5}), (Pair{7, 5}));
  EXPECT_EQ(world.least({~rank, rank}), (Pair{~last, last}));
  EXPECT_EQ(world.least({9, 100 - rank}), (Pair{9, 100 - last}));  // the second word breaks ties
}

TEST(Communicator, GroupsAreRanksThatFollowEachOther) {
  const Communicator world = Communicator::world();
  for (const int size : {1, 2, 7}) {
    const Communicator group = world.group_of(size);
    const int before = world.rank().value() / size * size;
    EXPECT_EQ(group.rank(), Rank(world.rank().value() - before));
    EXPECT_EQ(group.size(), std::min(size, world.size() - before));
    EXPECT_EQ(group.any_bits(1U << group.rank().value()), (1U << group.size()) - 1);
  }
}

// An activity ends with its scope, and gives way to the one before it.
TEST(Communicator, ActivitiesLieWithinEachOther) {
  const Communicator world = Communicator::world();
  const Activity computing(Activity::Kind::computing, "computes a step");
  world.barrier();
  EXPECT_STREQ(Activity::now().words, "computes a step");
  {
    const Activity waiting(Activity::Kind::waiting, "waits for the swaps of", Rank(0));
    EXPECT_EQ(Activity::now().kind, Activity::Kind::waiting);
    EXPECT_EQ(Activity::now().other, Rank(0));
  }
  EXPECT_EQ(Activity::now().kind, Activity::Kind::computing);
  const auto before = num_steps_noted();
  note_step();
  EXPECT_EQ(num_steps_noted(), before + 1);
}

}  // namespace
}  // namespace noiseloom
