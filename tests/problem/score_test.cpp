#include "noiseloom/problem/score.h"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>

#include "problem/distances/score_distance.h"
#include "problem/score_row_simd.h"
#include "support/filter_specs.h"
#include "support/oracle.h"

namespace noiseloom {
namespace {

using namespace testing_support;
using oracle::Texture;

struct Space {
  DistanceKind distance;
  int channels;
};
const std::vector<Space> spaces = {
    {DistanceKind::absolute, 1},  {DistanceKind::circle, 1},    {DistanceKind::euclidean, 2},
    {DistanceKind::euclidean, 3}, {DistanceKind::euclidean, 5}, {DistanceKind::angle, 3},
    {DistanceKind::axis, 3},      {DistanceKind::axis, 4},      {DistanceKind::manhattan, 2},
    {DistanceKind::manhattan, 5}, {DistanceKind::chebyshev, 3}};

std::vector<double> slice_sums(const Footprint& footprint, const Texture& texture, PairEnds ends = PairEnds::both) {
  std::vector<double> sums;
  for (const SliceIndex slice : texture.extents.slices()) {
    sums.push_back(weighted_distance_sum(
        footprint, texture.distance, texture.channels, slice, [&](SliceIndex s) { return texture.slice(s); }, ends));
  }
  return sums;
}

double mean_distance(const Texture& texture) {
  ThreadPool pool(2);
  return MeanDistance(texture.distance, texture.channels, texture.extents.cells_per_slice(),
                      texture.extents.num_slices())
      .compute([&](SliceIndex slice) { return texture.list(slice); }, pool);
}

double score(const Footprint& footprint, const Texture& texture) {
  return relative_error(footprint, mean_distance(texture), slice_sums(footprint, texture));
}

// A product and a sum for every number of slice axes.
std::vector<FilterSpec> filters_of(const Extents& extents) {
  std::vector<int> slice_axes(static_cast<std::size_t>(extents.num_slice_axes()));
  std::iota(slice_axes.begin(), slice_axes.end(), 2);
  if (slice_axes.empty())
    return {product({group({0, 1}, gauss(1))}), sum({group({0, 1}, box(3), 0.6), group({0}, box(2), 0.4)})};
  return {product({group({0, 1}, box(3)), group(slice_axes, ema(0.4, 0.3))}),
          product({group({0, 1}, binomial(2)), group({0, 2}, gauss_energy(0.6))}),
          sum({group({0, 1}, gauss(0.8), 0.7), group(slice_axes, box(2), 0.3)})};
}

TEST(Score, EqualsRelativeErrorByAllPairs) {
  for (const Extents& extents : {Extents({13, 7}), Extents({7, 5, 3}), Extents({5, 3, 2, 3}), Extents({3, 5, 3, 2, 2}),
                                 Extents({2, 1, 7}), Extents({17, 1, 2})}) {
    for (const FilterSpec& filter : filters_of(extents)) {
      const oracle::Overlaps f = oracle::overlaps(extents, filter);
      for (const Space& space : spaces) {
        const Texture texture = oracle::random_texture(extents, space.distance, space.channels, 3);
        const double expected = oracle::relative_error(f, texture);
        EXPECT_NEAR(score(Footprint(extents, filter), texture), expected, 1e-9 * std::fabs(expected))
            << extents.to_string() << ", distance " << static_cast<int>(space.distance);
      }
    }
  }
}

TEST(Score, OfAsymmetricSlicesCountsPairsFromBothEnds) {
  const Extents extents({7, 5, 4});
  for (const Space& space : spaces) {
    const Texture texture = oracle::random_texture(extents, space.distance, space.channels, 5);
    for (const FilterSpec& filter : filters_of(extents)) {
      const Footprint footprint(extents, filter);
      const std::vector<double> sums = slice_sums(footprint, texture);
      const std::vector<double> expected = oracle::distance_sums(oracle::overlaps(footprint), texture);
      for (std::size_t slice = 0; slice < sums.size(); ++slice) {
        EXPECT_NEAR(sums[slice], expected[slice], 1e-12 * expected[slice]);
      }
      const std::vector<double> one_end = slice_sums(footprint, texture, PairEnds::one);
      const double both = std::accumulate(sums.begin(), sums.end(), 0.0);
      EXPECT_NEAR(std::accumulate(one_end.begin(), one_end.end(), 0.0), both, 1e-13 * both);
    }
  }
}

TEST(Score, IsMinusTheEnergyOfTheDistanceKernel) {
  const Extents extents({5, 7, 3});
  const Texture texture = oracle::random_texture(extents, DistanceKind::angle, 3, 8);
  const FilterSpec filter = filters_of(extents)[0];
  const std::vector<double> sums = slice_sums(Footprint(extents, filter), texture);
  const double energy = oracle::energy(oracle::overlaps(extents, filter), texture, {});
  EXPECT_NEAR(std::accumulate(sums.begin(), sums.end(), 0.0), -energy, 1e-12 * -energy);
}

TEST(Oracle, SwapDeltaIsDifferenceOfEnergies) {
  const Extents extents({5, 3, 2});
  const oracle::Overlaps f = oracle::overlaps(extents, filters_of(extents)[0]);
  for (const ValueKernelKind kind : {ValueKernelKind::distance, ValueKernelKind::stbn}) {
    const ValueKernelSpec kernel{kind, 0.7};
    for (const Space& space : spaces) {
      Texture texture = oracle::random_texture(extents, space.distance, space.channels, 9);
      const double before = oracle::energy(f, texture, kernel);
      const double delta = oracle::swap_delta(f, texture, kernel, 4, 11);
      texture.swap(4, 11);
      EXPECT_NEAR(oracle::energy(f, texture, kernel) - before, delta, 1e-12 * std::fabs(before));
      EXPECT_NE(delta, 0);
    }
  }
}

TEST(Score, DoesNotChangeWhenTextureIsShiftedOnTorus) {
  const Extents extents({7, 5, 3});
  for (const Space& space : spaces) {
    const Texture texture = oracle::random_texture(extents, space.distance, space.channels, 4);
    Texture shifted = texture;
    for (std::int64_t cell = 0; cell < extents.num_cells(); ++cell) {
      oracle::Coord to = oracle::coord_of(extents, cell);
      to[0] += 4;
      to[1] += 3;
      to[2] += 2;
      const std::size_t target = oracle::flat_of(extents, to);
      for (std::size_t c = 0; c < static_cast<std::size_t>(space.channels); ++c) {
        shifted.values[target / 35 * texture.slice_size() + c * 35 + target % 35] =
            static_cast<float>(texture.sample(static_cast<std::size_t>(cell))[c]);
      }
    }
    for (const FilterSpec& filter : filters_of(extents)) {
      const Footprint footprint(extents, filter);
      EXPECT_NEAR(score(footprint, shifted), score(footprint, texture), 1e-12);
    }
  }
}

TEST(Score, AsksOnlyForCoupledSlices) {
  const Extents extents({5, 3, 7});
  const Texture texture = oracle::random_texture(extents, DistanceKind::absolute, 1, 4);
  const auto asked = [&](const FilterSpec& filter) {
    std::set<std::int32_t> slices;
    weighted_distance_sum(Footprint(extents, filter), DistanceKind::absolute, 1, SliceIndex(6), [&](SliceIndex s) {
      slices.insert(s.value());
      return texture.slice(s);
    });
    return slices;
  };
  EXPECT_EQ(asked(product({group({0, 1}, box(3))})), std::set<std::int32_t>({6}));
  EXPECT_EQ(asked(product({group({0, 1, 2}, box(3))})), std::set<std::int32_t>({4, 5, 6, 0, 1}));
}

// For a random permutation of n samples E[m_d] = m n / (n - 1), and the m_d of offsets other than +-d are nearly
// uncorrelated; with v the variance of the centred distance, Var R = 2 v sum_{d != 0} F(d)^2 / (n m^2 F(0)^2).
TEST(Score, OfRandomStartIsOneWithinFourStandardErrors) {
  const Extents extents({67, 61});
  const auto n = static_cast<double>(extents.num_cells());
  const Footprint footprint(extents, product({group({0, 1}, box(5))}));
  double squares = 0;
  for (const PlaneTap& tap : footprint.slices()[0].taps) squares += tap.weight * tap.weight;
  // |x - y| of uniform scalars: m = 1/3, v = sum_k (2 / (k pi)^2)^2 = 2/45.
  const double error = std::sqrt(2 * (2.0 / 45) * 9 * squares / n) / footprint.weight_zero();
  const double expected = 1 - (footprint.weight_sum() / footprint.weight_zero() - 1) / (n - 1);
  constexpr int starts = 100;
  double sum = 0;
  double sum_of_squares = 0;
  for (std::uint64_t seed = 1; seed <= starts; ++seed) {
    const Texture texture = oracle::random_texture(extents, DistanceKind::absolute, 1, seed);
    const double r = score(footprint, texture);
    EXPECT_NEAR(r, 1, 4 * error + (1 - expected));  // one seed in 16,000 would fail
    sum += r;
    sum_of_squares += (r - expected) * (r - expected);
  }
  EXPECT_NEAR(sum / starts, expected, 4 * error / std::sqrt(starts));
  // The standard error is the one above: its square from 100 starts is known to sqrt(2 / 100).
  EXPECT_NEAR(sum_of_squares / starts / (error * error), 1, 4 * std::sqrt(2.0 / starts));
}

TEST(Score, OfEqualSamplesIsOne) {
  Texture texture = oracle::random_texture(Extents({5, 7, 3}), DistanceKind::euclidean, 2, 1);
  std::fill(texture.values.begin(), texture.values.end(), 0.3F);
  EXPECT_EQ(mean_distance(texture), 0);
  EXPECT_EQ(score(Footprint(texture.extents, product({group({0, 1}, box(3))})), texture), 1);
}

TEST(Score, OfTwoValuesInCheckerboardVanishesUnderTwoTapBox) {
  Texture texture = oracle::random_texture(Extents({8, 6}), DistanceKind::absolute, 1, 1);
  for (std::size_t cell = 0; cell < 48; ++cell) texture.values[cell] = (cell % 8 + cell / 8) % 2 == 0 ? 0.25F : 0.75F;
  EXPECT_NEAR(score(Footprint(texture.extents, product({group({0, 1}, box(2))})), texture), 0, 1e-14);
  EXPECT_NEAR(score(Footprint(texture.extents, product({group({0}, box(2))})), texture), 0, 1e-14);
}

TEST(Score, HasTheSameBitsForAnyVectorWidth) {
  const Texture texture = oracle::random_texture(Extents({509, 3}), DistanceKind::angle, 3, 2);
  std::vector<double> values(texture.values.begin(), texture.values.end());
  // Directions along axes, whose products are zeros of either sign.
  for (const auto& [at, x, y, z] :
       {std::tuple(0, -1.0, 0.0, 0.0), std::tuple(509, 0.0, -0.6, -0.8), std::tuple(511, 0.0, 1.0, -0.0)}) {
    for (const auto& [channel, value] : {std::pair(0, x), std::pair(1, y), std::pair(2, z)})
      values[static_cast<std::size_t>(channel * 1527 + at)] = value;
  }
  const auto bits = [](double sum) { return std::bit_cast<std::uint64_t>(sum); };
  for (const DistanceKind kind :
       {DistanceKind::absolute, DistanceKind::circle, DistanceKind::euclidean, DistanceKind::angle, DistanceKind::axis,
        DistanceKind::manhattan, DistanceKind::chebyshev, DistanceKind::cosine}) {
    const SampleRun a{values.data(), 1527};
    for (const std::size_t count : {0U, 1U, 7U, 8U, 127U, 128U, 129U, 1018U}) {
      for (const std::size_t channels : {std::size_t{2}, std::size_t{3}}) {
        const double of_pairs = sum_of_pairs(kind, Widest::portable)(a, a.from(509), count, channels);
        const double to_first = sum_to_first(kind, Widest::portable)(a, a.from(509), count, channels);
        for (const Widest widest : {Widest::avx2, Widest::avx512}) {
          EXPECT_EQ(bits(sum_of_pairs(kind, widest)(a, a.from(509), count, channels)), bits(of_pairs));
          EXPECT_EQ(bits(sum_to_first(kind, widest)(a, a.from(509), count, channels)), bits(to_first));
        }
      }
    }
  }
}

TEST(Score, OfRowsIsTheSumOverTapsWithTheSameBitsOnAllInstructionSets) {
  const Texture texture = oracle::random_texture(Extents({509, 3}), DistanceKind::absolute, 1, 2);
  const std::vector<double> values(texture.values.begin(), texture.values.end());
  const std::vector<std::int32_t> offsets = {0, -3, 2, 5, -1};  // one more than are taken at once
  const std::vector<double> weights = {0.5, -1, 0.25, 0.125, 2};
  const double* a = values.data();
  const double* b = a + 500;
  for (const bool circle : {false, true}) {
    const auto sum = circle ? circle_row_sum : scalar_row_sum;
    for (const std::size_t count : {0U, 1U, 7U, 8U, 127U, 128U, 129U, 1018U}) {
      double expected = 0;
      for (std::size_t k = 0; k < offsets.size(); ++k) {
        for (std::size_t i = 0; i < count; ++i) {
          const double d = std::abs(a[i] - b[static_cast<std::ptrdiff_t>(i) + offsets[k]]);
          expected += weights[k] * (circle ? std::min(d, 1 - d) : d);
        }
      }
      hwy::SetSupportedTargetsForTest(HWY_STATIC_TARGET);
      const double reference = sum({offsets, weights}, a, b, count);
      hwy::SetSupportedTargetsForTest(0);
      EXPECT_NEAR(reference, expected, 1e-10);
      for (std::int64_t targets = hwy::SupportedTargets(); targets != 0; targets &= targets - 1) {
        hwy::SetSupportedTargetsForTest(targets & -targets);
        EXPECT_EQ(sum({offsets, weights}, a, b, count), reference) << count << " " << targets;
        hwy::SetSupportedTargetsForTest(0);
      }
    }
  }
}

}  // namespace
}  // namespace noiseloom
