#include "anneal/deltas/background.h"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

#include "anneal/feature_fixture.h"
#include "noiseloom/core/math.h"
#include "noiseloom/core/random.h"
#include "noiseloom/samples/sample_space.h"
#include "support/sanitizers.h"

namespace noiseloom {
namespace {

using namespace testing_support;
using test::kernel_by_features;
using test::samples_of;
using test::share_wrong;
using test::Space;
using test::Texture;

struct BackgroundCase {
  std::string name;
  Extents extents;
  FilterSpec filter;
};

std::vector<BackgroundCase> cases() {
  return {{"gauss x ema", Extents({19, 17, 5}), product({group({0, 1}, gauss(0.8)), group({2}, ema(0.1, 0.1))})},
          {"box x box over two slice axes, folded", Extents({5, 7, 3, 2}),
           product({group({0, 1}, box(5)), group({2, 3}, box(2))})},
          {"a disc, which is not separable", Extents({13, 11, 3}),
           product({group({0, 1}, gauss_energy(0.9)), group({2}, box(2))})}};
}

// dE of the other slices alone.
double others_change(const Footprint& footprint, const Texture& texture, SliceIndex slice, CellPair pair,
                     const test::PairKernel& kernel) {
  return test::change_by(footprint.slices().subspan(1), footprint.extents(), texture, slice, pair, kernel);
}

std::vector<Space> spaces() { return test::all_spaces(); }

TEST(Background, IsTheLowRankKernelSummedOverTheOtherSlices) {
  for (const BackgroundCase& one : cases()) {
    for (const Space& space : spaces()) {
      const Footprint footprint(one.extents, one.filter);
      const ValueKernel kernel = test::kernel_of(space, ValueKernelKind::distance, one.extents.num_axes());
      const Texture texture(footprint, kernel, 5);
      const FeatureMap map(kernel, 19, samples_of(texture, 1));
      const auto with = make_swap_delta(footprint, kernel, Precision::float32, &map);
      const auto exact = make_swap_delta(footprint, kernel, Precision::float64);
      with->bind(SliceIndex(1), texture.field(SliceIndex(1)), texture.field_of());
      exact->bind(SliceIndex(1), texture.field(SliceIndex(1)), texture.field_of());
      const test::PairKernel by_features = kernel_by_features(map, kernel.channels);
      const test::PairKernel full = test::full_kernel(kernel);
      const Cell last = one.extents.cells_per_slice() - 1;
      for (const CellPair pair : {test::pair(0, last), test::pair(last / 2, 3), test::pair(last / 3, last - 1)}) {
        const double own = exact->delta(pair) - others_change(footprint, texture, SliceIndex(1), pair, full);
        const double expected = own + others_change(footprint, texture, SliceIndex(1), pair, by_features);
        EXPECT_NEAR(with->delta(pair), expected, 2e-4 * footprint.weight_zero() + 1e-4 * std::abs(expected))
            << one.name << " " << space.name;
      }
    }
  }
}

// Root mean square of dE's error over that of dE itself, the other slices alone.
double relative_error(const Space& space, ValueKernelKind kind, int most_features) {
  const BackgroundCase one = cases()[0];
  const Footprint footprint(one.extents, one.filter);
  const ValueKernel kernel = test::kernel_of(space, kind, one.extents.num_axes());
  const Texture texture(footprint, kernel, 5);
  const FeatureMap map(kernel, most_features, samples_of(texture, 2));
  const test::PairKernel by_features = kernel_by_features(map, kernel.channels);
  const test::PairKernel full = test::full_kernel(kernel);
  double error = 0;
  double size = 0;
  for (std::uint32_t k = 0; k < 30; ++k) {
    const CellPair pair{k, 300 - 7 * k};
    const double exact = others_change(footprint, texture, SliceIndex(1), pair, full);
    const double difference = others_change(footprint, texture, SliceIndex(1), pair, by_features) - exact;
    error += difference * difference;
    size += exact * exact;
  }
  return std::sqrt(error / size);
}

TEST(Background, NearsTheExactChangeWithMoreFeatures) {
  if (testing_support::under_sanitizers) GTEST_SKIP() << "asks how well, not where";
  for (const Space& space : spaces()) {
    const double low = relative_error(space, ValueKernelKind::distance, space.channels);
    const double high = relative_error(space, ValueKernelKind::distance, 32);
    EXPECT_LT(high, space.channels <= 4 ? 0.25 : 0.45) << space.name;
    if (space.channels <= 4) {
      // Of 1 - a b the vector itself is all that there is to know.
      const bool is_exact = space.distance == DistanceKind::cosine;
      EXPECT_LT(high, is_exact ? 1e-6 : 0.9 * low) << space.name;
    }
  }
}

// -|a - b| of uniform scalars: what is left of the sum of 6 / (pi n)^2.
TEST(FeatureMap, SaysWhatItMisses) {
  std::vector<float> list;
  for (int k = 0; k < 1024; ++k) list.push_back((static_cast<float>(k) + 0.5F) / 1024);
  ValueKernel kernel;
  kernel.distance = DistanceKind::absolute;
  for (const int count : {1, 8, 64}) {
    double tail = 1;
    for (int n = 1; n <= count; ++n) tail -= 6 / (M_PI * M_PI * n * n);
    EXPECT_NEAR(FeatureMap(kernel, count, list).missed(), tail, 1e-3) << count;
  }
  EXPECT_EQ(FeatureMap(kernel, 8, std::vector<float>(100, 0.5F)).missed(), 0);  // nothing to miss
}

TEST(FeatureMap, HoldsForSamplesThatItWasNotFittedTo) {
  constexpr std::size_t n = 2048;
  constexpr std::size_t far = 40;  // one in fifty
  const auto uniform = [](std::size_t k, std::size_t c) {
    return to_unit_float(random_block(7, Purpose::jitter, 0, 0, k)[c]);
  };
  std::vector<float> sun;
  std::vector<float> peak;
  std::vector<float> tails;
  for (std::size_t k = 0; k < n; ++k) {
    const bool is_far = k % (n / far) == 0;
    const float z = is_far ? 2 * uniform(k, 0) - 1 : 1 - 1e-4F * uniform(k, 0);
    const float r = std::sqrt(std::max(0.0F, 1 - z * z));
    const double turn = uniform(k, 1);
    sun.insert(sun.end(),
               {r * static_cast<float>(math::cos_2pi(turn)), r * static_cast<float>(math::sin_2pi(turn)), z});
    const float width = is_far ? 10 : 1e-3F;
    peak.insert(peak.end(), {width * uniform(k, 0), width * uniform(k, 1)});
    tails.push_back(is_far ? 1000 * (uniform(k, 0) - 0.5F) : uniform(k, 1));
  }
  ValueKernel angle;
  angle.distance = DistanceKind::angle;
  angle.channels = 3;
  ValueKernel euclidean;
  euclidean.distance = DistanceKind::euclidean;
  euclidean.channels = 2;
  for (const int count : {8, 34}) {
    EXPECT_LT(share_wrong(angle, FeatureMap(angle, count, sun), sun), 0.3) << count;
    EXPECT_LT(share_wrong(euclidean, FeatureMap(euclidean, count, peak), peak), 0.6) << count;
    EXPECT_LT(share_wrong(ValueKernel{}, FeatureMap(ValueKernel{}, count, tails), tails), 0.6) << count;
  }
}

TEST(FeatureMap, ServesListsOfWhichMostAreEqual) {
  std::vector<float> list(1000);
  for (std::size_t k = 0; k < 200; ++k) list[5 * k] = 1;
  EXPECT_LT(share_wrong(ValueKernel{}, FeatureMap(ValueKernel{}, 8, list), list), 1e-3);
}

TEST(Background, ServesTheStbnKernel) {
  EXPECT_LT(relative_error(test::all_spaces()[0], ValueKernelKind::stbn, 32), 0.35);
}

TEST(Background, HasTheSameBitsOnAllInstructionSets) {
  for (const BackgroundCase& one : cases()) {
    for (const Space& space : spaces()) {
      const Footprint footprint(one.extents, one.filter);
      const ValueKernel kernel = test::kernel_of(space, ValueKernelKind::distance, one.extents.num_axes());
      const Texture texture(footprint, kernel, 5);
      const FeatureMap map(kernel, 16, samples_of(texture, 1));
      const auto values = [&](std::int64_t target) {
        hwy::SetSupportedTargetsForTest(target);
        const auto delta = make_swap_delta(footprint, kernel, Precision::float32, &map);
        delta->bind(SliceIndex(1), texture.field(SliceIndex(1)), texture.field_of());
        hwy::SetSupportedTargetsForTest(0);
        std::vector<double> all;
        for (Cell i = 1; i < one.extents.cells_per_slice(); ++i) all.push_back(delta->delta(test::pair(i, 0)));
        return all;
      };
      const std::vector<double> reference = values(HWY_STATIC_TARGET);
      for (std::int64_t targets = hwy::SupportedTargets(); targets != 0; targets &= targets - 1) {
        EXPECT_EQ(values(targets & -targets), reference) << one.name << " " << space.name << " " << targets;
      }
    }
  }
}

TEST(Background, FollowsTheSwapsOfItsSlice) {
  const BackgroundCase one = cases()[0];
  const Footprint footprint(one.extents, one.filter);
  const ValueKernel kernel = test::kernel_of(test::all_spaces()[3], ValueKernelKind::distance, 3);
  Texture texture(footprint, kernel, 5);
  const FeatureMap map(kernel, 16, samples_of(texture, 1));
  const auto swapped = make_swap_delta(footprint, kernel, Precision::float32, &map);
  const auto bound = make_swap_delta(footprint, kernel, Precision::float32, &map);
  swapped->bind(SliceIndex(2), texture.field(SliceIndex(2)), texture.field_of());
  for (std::uint32_t k = 0; k < 50; ++k) {
    const CellPair pair{k, 200 - 3 * k};
    swapped->swap(pair);
    texture.field(SliceIndex(2)).swap(pair.i, pair.j);
  }
  bound->bind(SliceIndex(2), texture.field(SliceIndex(2)), texture.field_of());
  for (std::uint32_t k = 1; k < 300; ++k) EXPECT_EQ(swapped->delta({0, k}), bound->delta({0, k}));
}

TEST(FeatureMap, OfUniformScalarsIsTheCosineSeries) {
  std::vector<float> list;
  for (int k = 0; k < 1024; ++k) list.push_back((static_cast<float>(k) + 0.5F) / 1024);
  const FeatureMap map({ValueKernelKind::distance, DistanceKind::absolute, 1, 1, 1}, 4, list);
  for (int n = 0; n < 4; ++n) {
    const double closed_form = 4 / std::pow((n + 1) * math::pi, 2);
    EXPECT_NEAR(map.mixing()[static_cast<std::size_t>(5 * n)], closed_form, 0.01 * closed_form);
  }
}

// Visible normals of a smooth surface: nearly all within a few `roughness` of z, a few anywhere. Two of the bulk are
// told apart by features that span it; features that span the tails as well differ by less than 0.1 there.
TEST(FeatureMap, OfTheBulkIsNotDrawnOutByFarTails) {
  SampleSpec spec;
  spec.space = "ggx";
  const ValueKernel kernel{ValueKernelKind::distance, DistanceKind::euclidean, 3, 1, 1};
  for (const double roughness : {1e-4, 1e-2}) {
    spec.parameters = {roughness, 30};
    const std::vector<float> list = SampleSource(spec, 4096, 1, 1).list(SliceIndex(0));
    const float a[3] = {static_cast<float>(-roughness / 2), 0, 1};
    const float b[3] = {static_cast<float>(roughness / 2), 0, 1};
    const FeatureMap map(kernel, 16, list);
    const std::vector<double> of_a = map.features(a);
    const std::vector<double> of_b = map.features(b);
    double largest = 0;
    for (std::size_t n = 0; n < of_a.size(); ++n) largest = std::max(largest, std::fabs(of_a[n] - of_b[n]));
    EXPECT_GT(largest, 0.2);
  }
}

TEST(FeatureMap, OfEqualSamplesPullsNowhere) {
  const std::vector<float> list(64, 0.25F);
  const FeatureMap map({ValueKernelKind::distance, DistanceKind::absolute, 1, 1, 1}, 4, list);
  for (const double a : map.mixing()) EXPECT_EQ(a, 0);
}

}  // namespace
}  // namespace noiseloom
