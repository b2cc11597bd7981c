#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

#include "noiseloom/core/random.h"
#include "noiseloom/problem/score.h"
#include "problem/distances/mean_distance_division.h"
#include "support/oracle.h"

namespace noiseloom {
namespace {

using oracle::Texture;

double by_tasks(const Division& division, const SliceList& list) {
  double sum = 0;
  for (std::int64_t task = 0; task < division.num_tasks(); ++task) sum += run_division_task(division, task, list);
  return sum;
}

double computed(const Texture& texture, int threads) {
  ThreadPool pool(threads);
  const MeanDistance mean(texture.distance, texture.channels, texture.extents.cells_per_slice(),
                          texture.extents.num_slices());
  EXPECT_TRUE(mean.exact());
  return mean.compute([&](SliceIndex slice) { return texture.list(slice); }, pool);
}

TEST(MeanDistance, EqualsAllPairs) {
  for (const Extents& extents : {Extents({1, 1}), Extents({2, 1}), Extents({7, 5, 3}), Extents({31, 29, 2})}) {
    for (const DistanceKind kind : {DistanceKind::absolute, DistanceKind::circle}) {
      const Texture texture = oracle::random_texture(extents, kind, 1, 7);
      const double expected = oracle::mean_over_all_pairs(texture);
      EXPECT_NEAR(computed(texture, 1), expected, 1e-13 * expected);
    }
    for (const int channels : {2, 3, 8}) {
      const Texture texture = oracle::random_texture(extents, DistanceKind::euclidean, channels, 7);
      const double expected = oracle::mean_over_all_pairs(texture);
      EXPECT_NEAR(computed(texture, 2), expected, 1e-13 * expected);
    }
    for (const int channels : {2, 5}) {
      const Texture sums = oracle::random_texture(extents, DistanceKind::manhattan, channels, 7);
      const double of_sums = oracle::mean_over_all_pairs(sums);
      EXPECT_NEAR(computed(sums, 2), of_sums, 1e-13 * of_sums);
      const Texture largest = oracle::random_texture(extents, DistanceKind::chebyshev, channels, 7);
      const double of_largest = oracle::mean_over_all_pairs(largest);
      EXPECT_NEAR(computed(largest, 2), of_largest, 1e-13 * of_largest);
    }
    const Texture directions = oracle::random_texture(extents, DistanceKind::cosine, 3, 7);
    // Vectors of float are not quite of length 1: half the square of a chord is 1 - cos to 1e-7 of a length.
    EXPECT_NEAR(computed(directions, 2), oracle::mean_over_all_pairs(directions), 2e-7);
    const Texture texture = oracle::random_texture(extents, DistanceKind::angle, 3, 7);
    // The angle between a sample and itself is the root of a rounding error: up to 1e-4 off where there is little else.
    const double expected = oracle::mean_over_all_pairs(texture);
    EXPECT_NEAR(computed(texture, 2), expected, 1e-12 * expected + 1e-7 / static_cast<double>(extents.num_cells()));
  }
}

TEST(MeanDistance, OfCircleTakesTheShorterWayAcrossTheEnds) {
  Texture texture = oracle::random_texture(Extents({3, 2, 2}), DistanceKind::circle, 1, 1);
  texture.values = {0, 1, 0.5F, 0.25F, 0.75F, 0.5F, 0, 0.999F, 0.001F, 1, 0.125F, 0.5F};
  EXPECT_NEAR(computed(texture, 1), oracle::mean_over_all_pairs(texture), 1e-15);
}

TEST(MeanDistance, OfTwoValuesIsHalfTheirDistance) {
  for (const DistanceKind kind : {DistanceKind::absolute, DistanceKind::euclidean}) {
    Texture texture = oracle::random_texture(Extents({6, 5, 3}), kind, 1, 1);
    for (std::size_t i = 0; i < texture.values.size(); ++i) texture.values[i] = i % 2 == 0 ? -1e6F : 3e6F;
    EXPECT_DOUBLE_EQ(computed(texture, 1), 2e6);
  }
}

TEST(MeanDistance, KeepsPrecisionFarFromZero) {
  Texture texture = oracle::random_texture(Extents({7, 5, 3}), DistanceKind::absolute, 1, 1);
  for (float& value : texture.values) value = 1e6F + value;
  EXPECT_NEAR(computed(texture, 1) / oracle::mean_over_all_pairs(texture), 1, 1e-13);
}

TEST(MeanDistance, IsSharedOutAmongTasksThatCoverEveryPair) {
  for (const Extents& extents :
       {Extents({64, 64, 2}), Extents({131, 127}), Extents({8, 8, 131}), Extents({1, 1, 67})}) {
    const Texture texture = oracle::random_texture(extents, DistanceKind::euclidean, 2, 3);
    const MeanDistance mean(DistanceKind::euclidean, 2, extents.cells_per_slice(), extents.num_slices());
    EXPECT_GT(mean.num_tasks(), 1);
    EXPECT_LE(mean.num_tasks(), 66);
    // All samples at the origin but for one: the mean counts each pair with it, and nothing else.
    Texture single = texture;
    std::fill(single.values.begin(), single.values.end(), 0.0F);
    single.values.back() = 1;
    const auto n = static_cast<double>(extents.num_cells());
    EXPECT_NEAR(computed(single, 2), 2 * (n - 1) / (n * n), 1e-15);
  }
}

// A list of n uniform points on a line through a space of two channels, as the exact mean is then known by sorting.
// stratified: in order, one in each of n strata.
std::vector<float> line_list(std::uint64_t seed, SliceIndex slice, std::int64_t n, bool stratified) {
  std::vector<float> list;
  for (std::int64_t i = 0; i < n; ++i) {
    const RandomBlock bits =
        random_block(seed, Purpose::jitter, static_cast<std::uint32_t>(slice), 0, static_cast<std::uint64_t>(i));
    const double u = to_unit_double(bits[0], bits[1]);
    list.push_back(static_cast<float>(stratified ? (static_cast<double>(i) + u) / static_cast<double>(n) : u));
    list.push_back(0);
  }
  return list;
}

struct Errors {
  double mean = 0;
  double rms = 0;
  double pairs = 0;            // of a ring
  double pairs_of_slices = 0;  // as if slices were not divided
};

// Relative errors of the estimate from blocks, over many textures.
Errors block_errors(std::int64_t n, std::int32_t num_slices, bool stratified, int textures) {
  PairBudget budget;
  budget.max_paired_samples = 1;
  budget.largest_block = 256;
  budget.smallest_block = 16;
  budget.pairs_wanted = 256 * n * num_slices;
  const Division division = divide_pairs(DistanceKind::euclidean, 2, n, num_slices, budget);
  EXPECT_FALSE(division.exact);
  Errors errors;
  errors.pairs_of_slices = division.num_samples() * static_cast<double>(division.neighbours) * static_cast<double>(n);
  errors.pairs = errors.pairs_of_slices / static_cast<double>(division.parts);
  for (int seed = 1; seed <= textures; ++seed) {
    const auto list = [&](SliceIndex slice) {
      return line_list(static_cast<std::uint64_t>(seed), slice, n, stratified);
    };
    std::vector<double> points;
    for (const SliceIndex slice : first_indices<SliceIndex>(num_slices)) {
      const std::vector<float> samples = list(slice);
      for (std::size_t i = 0; i < samples.size(); i += 2) points.push_back(samples[i]);
    }
    const double exact = oracle::mean_distance_on_a_line(std::move(points));
    const double error = by_tasks(division, list) / exact - 1;
    errors.mean += error / textures;
    errors.rms += error * error / textures;
  }
  errors.rms = std::sqrt(errors.rms);
  return errors;
}

// c of mean_distance.cpp is sqrt(2/45) * 3 = 0.63 for a line. The rms of 36 errors is known to a factor 1 +- 0.12 (one
// standard deviation), so 1.5 is four of them, and their mean to a sixth of the rms.
TEST(MeanDistance, FromBlocksIsUnbiasedWithinTheStatedError) {
  for (const auto& [n, slices] : {std::pair<std::int64_t, std::int32_t>{1021, 7}, {256, 31}, {64, 128}}) {
    const Errors errors = block_errors(n, slices, false, 36);
    // Of what slices have to do with each other in the exact mean, the pairs that are looked at are a part.
    const double between = 1 - 1.0 / slices;
    const double looked_at = 2 * errors.pairs_of_slices / (between * std::pow(static_cast<double>(n * slices), 2));
    const double stated = 0.63 / std::sqrt(errors.pairs_of_slices) * between * std::sqrt(1 - looked_at);
    EXPECT_LT(errors.rms, 1.5 * stated);
    EXPECT_GT(errors.rms, stated / 1.5);
    EXPECT_LT(std::fabs(errors.mean), 4 * stated / 6);
  }
}

TEST(MeanDistance, FromBlocksOfStratifiedListsIsFarMoreExact) {
  for (const auto& [n, slices] : {std::pair<std::int64_t, std::int32_t>{1024, 8}, {256, 31}, {8192, 1}}) {
    const Errors errors = block_errors(n, slices, true, 16);
    EXPECT_LT(errors.rms, 0.01 * 0.63 / std::sqrt(errors.pairs));
  }
  // A single slice is divided as if it were stratified.
  const Errors errors = block_errors(8191, 1, false, 16);
  EXPECT_LT(errors.rms, 0.01 * 0.63 / std::sqrt(errors.pairs));
}

// Points of a jittered grid, in its order and in that of a texture: blocks are the same sets, far nearer to all pairs
// than blocks of as many points that are drawn would be.
TEST(MeanDistance, FromBlocksDoesNotDependOnTheOrderOfTheList) {
  constexpr std::int64_t side = 48;
  const auto points = [](SliceIndex slice, bool shuffled) {
    std::vector<std::array<float, 2>> list;
    for (std::int64_t i = 0; i < side * side; ++i) {
      const RandomBlock bits =
          random_block(3, Purpose::jitter, static_cast<std::uint32_t>(slice), 0, static_cast<std::uint64_t>(i));
      list.push_back({(static_cast<float>(i % side) + to_unit_float(bits[0])) / side,
                      (static_cast<float>(i / side) + to_unit_float(bits[1])) / side});
    }
    for (std::size_t i = list.size(); shuffled && i > 1; --i) {
      std::swap(list[i - 1], list[random_block(5, Purpose::jitter, static_cast<std::uint32_t>(slice), 0, i)[0] % i]);
    }
    std::vector<float> samples;
    for (const auto& [x, y] : list) samples.insert(samples.end(), {x, y});
    return samples;
  };
  for (const std::int32_t slices : {1, 2, 7}) {
    PairBudget budget;
    const Division all = divide_pairs(DistanceKind::euclidean, 2, side * side, slices, budget);
    ASSERT_TRUE(all.exact);
    budget.max_paired_samples = 1;
    budget.largest_block = budget.smallest_block = side * side / 8;
    const Division division = divide_pairs(DistanceKind::euclidean, 2, side * side, slices, budget);
    EXPECT_EQ(division.parts, 8);
    const double in_order = by_tasks(division, [&](SliceIndex slice) { return points(slice, false); });
    EXPECT_EQ(by_tasks(division, [&](SliceIndex slice) { return points(slice, true); }), in_order);
    const double exact = by_tasks(all, [&](SliceIndex slice) { return points(slice, false); });
    const double of_drawn = 0.42 / std::sqrt(static_cast<double>(slices * side * side * side * side / 8));
    EXPECT_NEAR(in_order / exact, 1, 0.05 * of_drawn) << slices;
  }
}

// Few values, most of them equal, in eight channels and blocks of two sizes: every pair counts as often as it should.
TEST(MeanDistance, FromBlocksOfEqualSamplesCountsEveryPair) {
  for (const auto& [cells, slices, block] :
       {std::tuple(30, 4, 15), std::tuple(31, 5, 16), std::tuple(31, 1, 8), std::tuple(29, 2, 10)}) {
    PairBudget budget;
    budget.max_paired_samples = 1;
    budget.largest_block = budget.smallest_block = block;
    const Division division = divide_pairs(DistanceKind::euclidean, 8, cells, slices, budget);
    EXPECT_FALSE(division.exact);
    EXPECT_EQ(division.parts, (cells + block - 1) / block);
    // Half of the samples are 0 or -0, the others are 1 in one channel, and no two slices differ.
    const auto list = [&, n = cells](SliceIndex) {
      std::vector<float> samples(static_cast<std::size_t>(8 * n));
      for (int i = 0; i < n; ++i)
        samples[static_cast<std::size_t>(8 * i + 3)] = i % 2 == 0 ? 1 : i % 4 == 1 ? 0.0F : -0.0F;
      return samples;
    };
    const double share = static_cast<double>((cells + 1) / 2) / cells;
    EXPECT_NEAR(by_tasks(division, list), 2 * share * (1 - share), 0.02) << cells << " " << slices;
  }
}

TEST(MeanDistance, FromSortedBlocksCoversTexturesTooLargeToSort) {
  PairBudget budget;
  budget.max_sorted_numbers = 1000;
  for (const DistanceKind kind : {DistanceKind::absolute, DistanceKind::circle, DistanceKind::manhattan}) {
    const int channels = kind == DistanceKind::manhattan ? 3 : 1;
    const Texture texture = oracle::random_texture(Extents({61, 1, 151}), kind, channels, 3);
    const Division division = divide_pairs(kind, channels, 61, 151, budget);
    EXPECT_FALSE(division.exact);
    EXPECT_EQ(division.neighbours, 4096 / 61);
    const auto list = [&](SliceIndex slice) { return texture.list(slice); };
    EXPECT_NEAR(by_tasks(division, list) / computed(texture, 1), 1, 4 * 0.63 / std::sqrt(61.0 * 151 * 4096));
  }
}

TEST(MeanDistance, KnowsWhereItIsExactWithoutAllocating) {
  const std::int64_t huge = std::int64_t{1} << 32;
  EXPECT_TRUE(MeanDistance(DistanceKind::absolute, 1, 1 << 20, 64).exact());
  EXPECT_FALSE(MeanDistance(DistanceKind::circle, 1, 1 << 20, 65).exact());
  EXPECT_TRUE(MeanDistance(DistanceKind::manhattan, 2, 1 << 19, 64).exact());
  EXPECT_FALSE(MeanDistance(DistanceKind::manhattan, 3, 1 << 19, 64).exact());
  EXPECT_TRUE(MeanDistance(DistanceKind::angle, 3, 1 << 14, 2).exact());
  EXPECT_FALSE(MeanDistance(DistanceKind::angle, 3, 1 << 14, 3).exact());
  const MeanDistance largest(DistanceKind::euclidean, 2, huge, 1024);
  EXPECT_FALSE(largest.exact());
  EXPECT_EQ(largest.num_tasks(), 1024);
}

}  // namespace
}  // namespace noiseloom
