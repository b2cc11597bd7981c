#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "noiseloom/core/math.h"
#include "noiseloom/problem/value_kernel.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {
namespace {

TEST(Distance, EqualsItsFormulaInEverySpace) {
  const std::array<float, 3> a = {0.125F, 0.5F, 0.75F};
  const std::array<float, 3> b = {0.875F, 0.25F, 0.25F};
  EXPECT_EQ(distance(DistanceKind::absolute, 1, a.data(), b.data()), 0.75);
  EXPECT_EQ(distance(DistanceKind::circle, 1, a.data(), b.data()), 0.25);
  EXPECT_EQ(distance(DistanceKind::euclidean, 3, a.data(), b.data()), std::sqrt(0.75 * 0.75 + 0.25 * 0.25 + 0.5 * 0.5));
  const std::array<float, 3> x = {1, 0, 0};
  const std::array<float, 3> diagonal = {0.6F, 0.8F, 0};
  EXPECT_NEAR(distance(DistanceKind::angle, 3, x.data(), diagonal.data()), std::acos(0.6), 1e-7);
  EXPECT_EQ(distance(DistanceKind::absolute, 1, b.data(), a.data()), 0.75);
  EXPECT_EQ(distance(DistanceKind::manhattan, 3, a.data(), b.data()), 1.5);
  EXPECT_EQ(distance(DistanceKind::chebyshev, 3, a.data(), b.data()), 0.75);
  EXPECT_NEAR(distance(DistanceKind::cosine, 3, x.data(), diagonal.data()), 1 - 0.6, 1e-7);
  EXPECT_EQ(distance(DistanceKind::cosine, 3, diagonal.data(), diagonal.data()), 0);
}

TEST(Distance, OfASpaceIsItsOwnUnlessTheSpecNamesAnother) {
  SampleSpec spec;
  spec.space = "sphere";
  EXPECT_EQ(distance_kind(spec, 3), DistanceKind::angle);
  for (const auto& [word, kind] : {std::pair{ComparedBy::euclidean, DistanceKind::euclidean},
                                   {ComparedBy::manhattan, DistanceKind::manhattan},
                                   {ComparedBy::chebyshev, DistanceKind::chebyshev},
                                   {ComparedBy::cosine, DistanceKind::cosine}}) {
    spec.compared_by = word;
    EXPECT_EQ(distance_kind(spec, 3), kind);
    EXPECT_TRUE(are_unit_vectors(spec));  // and so they are decoded from images as such
  }
  SampleSpec file;
  file.space = "file";
  file.distance = DistanceKind::chebyshev;
  EXPECT_EQ(distance_kind(file, 1), DistanceKind::absolute);
  EXPECT_EQ(distance_kind(file, 2), DistanceKind::chebyshev);
  EXPECT_FALSE(are_unit_vectors(file));
}

TEST(Distance, EqualAndAntipodalSamplesOnTheSphereAreFiniteAndExact) {
  SampleSpec sphere;
  sphere.space = "sphere";
  const std::vector<float> list = SampleSource(sphere, 10'007, 1, 1).list(SliceIndex(0));
  for (std::size_t i = 0; i < list.size(); i += 3) {
    const std::array<float, 3> opposite = {-list[i], -list[i + 1], -list[i + 2]};
    // A length off by 1e-7 turns into an angle of sqrt(2e-7).
    EXPECT_NEAR(distance(DistanceKind::angle, 3, &list[i], &list[i]), 0, 5e-4);
    EXPECT_NEAR(distance(DistanceKind::angle, 3, &list[i], opposite.data()), math::pi, 5e-4);
  }
  const std::array<float, 3> pole = {0, 0, 1};
  const std::array<float, 3> south = {0, 0, -1};
  EXPECT_EQ(distance(DistanceKind::angle, 3, pole.data(), pole.data()), 0);
  EXPECT_EQ(distance(DistanceKind::angle, 3, pole.data(), south.data()), math::pi);
}

TEST(Distance, StaysFiniteForTheLargestAndSmallestFloats) {
  const std::array<float, 2> huge = {3.4e38F, -3.4e38F};
  const std::array<float, 2> small = {1e-45F, -1e-45F};
  EXPECT_TRUE(std::isfinite(distance(DistanceKind::euclidean, 2, huge.data(), small.data())));
  EXPECT_EQ(distance(DistanceKind::euclidean, 2, small.data(), small.data()), 0);
  EXPECT_GT(distance(DistanceKind::absolute, 1, &small[0], &small[1]), 0);
}

TEST(ValueKernel, DistanceKernelIsTheNegativeDistance) {
  ProblemSpec problem;
  problem.extents = Extents({5, 7, 3});
  const ValueKernel kernel = make_value_kernel(problem, 2, DistanceKind::euclidean);
  const std::array<float, 2> a = {0.25F, 0.5F};
  const std::array<float, 2> b = {0.75F, 0.125F};
  EXPECT_EQ(kernel(a.data(), b.data()), -distance(DistanceKind::euclidean, 2, a.data(), b.data()));
  EXPECT_EQ(kernel(a.data(), a.data()), 0);
}

TEST(ValueKernel, StbnKernelEqualsItsFormulaForEveryNumberOfChannelsAndAxes) {
  const std::array<float, 8> a = {0.25F, 0.5F, 0.75F, 0.125F, 0, 0.5F, 0.25F, 1};
  const std::array<float, 8> b = {0.75F, 0.125F, 0.5F, 0.5F, 1, 0.25F, 0, 0.5F};
  for (const double sigma_s : {0.05, 1.0, 7.0}) {
    for (int channels = 1; channels <= 8; ++channels) {
      for (const std::vector<std::int64_t>& sizes :
           {std::vector<std::int64_t>{5, 7}, {5, 7, 3}, {5, 7, 3, 2}, {5, 7, 3, 2, 11}}) {
        ProblemSpec problem;
        problem.extents = Extents(sizes);
        problem.value_kernel.kind = ValueKernelKind::stbn;
        problem.value_kernel.sigma_s = sigma_s;
        const DistanceKind kind = channels == 1 ? DistanceKind::absolute : DistanceKind::euclidean;
        const ValueKernel kernel = make_value_kernel(problem, channels, kind);
        const double d = distance(kind, channels, a.data(), b.data());
        const double power = std::pow(d, static_cast<double>(channels) / static_cast<double>(sizes.size()));
        EXPECT_NEAR(kernel(a.data(), b.data()), std::exp(-power / (sigma_s * sigma_s)), 1e-13);
        EXPECT_EQ(kernel(a.data(), a.data()), 1);
      }
    }
  }
}

TEST(StartPermutation, HoldsEveryIdOnce) {
  for (const std::int64_t cells : {1, 2, 3, 101, 128 * 127}) {
    Permutation order = start_permutation(3, SliceIndex(2), cells);
    std::sort(order.begin(), order.end());
    EXPECT_EQ(order, identity_permutation(cells));
  }
}

TEST(StartPermutation, IsAFunctionOfSeedAndSliceOnly) {
  EXPECT_EQ(start_permutation(3, SliceIndex(2), 101), start_permutation(3, SliceIndex(2), 101));
  EXPECT_NE(start_permutation(3, SliceIndex(2), 101), start_permutation(3, SliceIndex(1), 101));
  EXPECT_NE(start_permutation(3, SliceIndex(2), 101), start_permutation(4, SliceIndex(2), 101));
}

TEST(StartPermutation, AllOrdersAreEquallyLikely) {
  std::map<Permutation, int> count;
  constexpr int trials = 24'000;
  for (const SliceIndex slice : first_indices<SliceIndex>(trials)) ++count[start_permutation(1, slice, 4)];
  ASSERT_EQ(count.size(), 24U);
  double chi_square = 0;
  for (const auto& [order, times] : count) chi_square += (times - 1000.0) * (times - 1000.0) / 1000.0;
  EXPECT_LT(chi_square, 56);  // 23 degrees of freedom: once in 7,000 trials; fixed seed
}

TEST(StartPermutation, HighIdsReachEveryQuarter) {
  // Draws must use all their bits: of 2^16 + 1 cells each quarter of the ids lands in each quarter of the cells
  // equally.
  constexpr std::int64_t cells = (1 << 16) + 1;
  const Permutation order = start_permutation(1, SliceIndex(0), cells);
  std::array<int, 16> count{};
  for (std::size_t cell = 0; cell < cells - 1; ++cell) {
    const std::uint32_t id = order[cell].value();
    if (id < cells - 1) ++count[(cell >> 14) * 4 + (id >> 14)];
  }
  for (const int c : count) EXPECT_NEAR(c, 4096, 4 * std::sqrt(4096 * 0.75 * 0.75));
}

}  // namespace
}  // namespace noiseloom
