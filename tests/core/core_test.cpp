#include <gtest/gtest.h>

#include <atomic>

#include "noiseloom/core/extents.h"
#include "noiseloom/core/parallel.h"
#include "noiseloom/core/random.h"

namespace noiseloom {
namespace {

TEST(Extents, SliceIndexAndCoordAreInverse) {
  const Extents extents({7, 5, 3, 11, 2});
  ASSERT_EQ(extents.num_slices(), 66);
  for (const SliceIndex slice : extents.slices()) {
    EXPECT_EQ(extents.slice_index(extents.slice_coord(slice)), slice);
  }
  EXPECT_EQ(extents.slice_index({1, 2, 1}).value(), 1 + 3 * (2 + 11 * 1));
}

TEST(Extents, SliceAtWrapsAnyOffset) {
  const Extents extents({7, 5, 3, 11});
  EXPECT_EQ(extents.slice_at(SliceIndex(0), {-1, 0}).value(), 2);
  EXPECT_EQ(extents.slice_at(SliceIndex(0), {-7, 0}).value(), 2);
  EXPECT_EQ(extents.slice_at(SliceIndex(2), {1, 23}).value(), 3 * 1);
}

TEST(Extents, CountsPastTwoToTheThirtyOneCells) {
  const Extents extents({1 << 16, 1 << 16, 1024});
  EXPECT_EQ(extents.cells_per_slice(), std::int64_t{1} << 32);
  EXPECT_EQ(extents.num_cells(), std::int64_t{1} << 42);
  EXPECT_EQ(extents.file_dimensions(), (std::vector<std::int64_t>{1024, 1 << 16, 1 << 16}));
}

TEST(Random, MatchesPhiloxKnownAnswers) {
  // Counter and key all zero, then counter words packed as random_block packs them (kat_vectors of Salmon et al. for
  // zero).
  const RandomBlock zero = random_block(0, static_cast<Purpose>(0), 0, 0, 0);
  EXPECT_EQ(zero, (RandomBlock{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
}

TEST(Random, EachCoordinateChangesTheDraw) {
  const RandomBlock base = random_block(1, Purpose::jitter, 2, 3, 4);
  EXPECT_NE(base, random_block(2, Purpose::jitter, 2, 3, 4));
  EXPECT_NE(base, random_block(1, Purpose::shuffle, 2, 3, 4));
  EXPECT_NE(base, random_block(1, Purpose::jitter, 3, 3, 4));
  EXPECT_NE(base, random_block(1, Purpose::jitter, 2, 4, 4));
  EXPECT_NE(base, random_block(1, Purpose::jitter, 2, 3, std::uint64_t{4} + (std::uint64_t{1} << 32)));
}

TEST(ThreadPool, VisitsEveryIndexOnceAndRethrows) {
  ThreadPool pool(3);
  std::vector<std::atomic<int>> visits(1000);
  pool.for_each(1000, [&](std::int64_t index, int worker) {
    EXPECT_LT(worker, 3);
    ++visits[static_cast<std::size_t>(index)];
  });
  for (const auto& count : visits) EXPECT_EQ(count, 1);
  EXPECT_THROW(pool.for_each(10, [](std::int64_t, int) { throw EnvironmentError("disk"); }), EnvironmentError);
}

TEST(Error, NearestWordFindsMisspellingsOnly) {
  const std::vector<std::string> accepted = {"box", "gauss", "binomial", "ema", "table"};
  EXPECT_EQ(nearest_word("guass", accepted), "gauss");
  EXPECT_EQ(nearest_word("bx", accepted), "box");
  EXPECT_EQ(nearest_word("zebra", accepted), "");
  EXPECT_EQ(nearest_word("sede", {"size", "seed"}), "seed");
  EXPECT_EQ(nearest_word("size_of_it", {"size_of_it_all"}), "size_of_it_all");
  EXPECT_EQ(nearest_word(std::string(std::size_t{1} << 26, 'x'), accepted), "");  // no table of 10 GB
}

}  // namespace
}  // namespace noiseloom
