#include "noiseloom/samples/sample_space.h"
#include "noiseloom/samples/space.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <numeric>

#include "noiseloom/core/math.h"
#include "noiseloom/core/random.h"
#include "support/sanitizers.h"

namespace noiseloom {
namespace {

SampleSpec space(const std::string& name) {
  SampleSpec spec;
  spec.space = name;
  return spec;
}

// Those without parameters; closed_form_test.cpp has the others.
std::vector<SampleSpec> all_spaces() {
  std::vector<SampleSpec> specs;
  for (const char* const kind :
       {"uniform", "tent", "gauss", "circle", "sphere", "hemisphere", "hemisphere-cosine", "disk"}) {
    specs.push_back(space(kind));
  }
  for (int channels = 2; channels <= 8; ++channels) specs.push_back(space("vector" + std::to_string(channels)));
  return specs;
}

std::vector<float> list_of(const SampleSpec& spec, std::int64_t n, std::uint64_t seed = 1, std::int32_t slice = 0) {
  return SampleSource(spec, n, slice + 1, seed).list(SliceIndex(slice));
}

// [0, 1), independent of the library's jitter.
double white(std::uint64_t index) {
  const RandomBlock bits = random_block(99, Purpose::subset, 0, 0, index);
  return to_unit_double(bits[0], bits[1]);
}

TEST(SampleSpace, EachStratumHoldsExactlyOneSample) {
  for (const SampleSpec& spec : all_spaces()) {
    for (const std::int64_t n : {1, 2, 3, 5, 17, 101, 128 * 128}) {
      const std::vector<float> list = list_of(spec, n);
      const auto channels = static_cast<std::size_t>(num_channels(spec));
      ASSERT_EQ(list.size(), static_cast<std::size_t>(n) * channels);
      for (std::int64_t id = 0; id < n; ++id) {
        ASSERT_EQ(sample_space(spec).invert(n, &list[static_cast<std::size_t>(id) * channels]), id)
            << spec.space << ", n = " << n;
      }
    }
  }
}

TEST(SampleSpace, InvertUndoesSampleAfterRoundingToFloat) {
  const std::array<double, 4> extremes = {0x1p-53, 0.5, 1 - 0x1p-26, 1 - 0x1p-53};
  for (const SampleSpec& spec : all_spaces()) {
    const std::int64_t most = std::int64_t{1} << (spec.space == "tent" ? 23 : 24);
    for (const std::int64_t n : {most, most - 3, std::int64_t{1'000'003}}) {
      for (std::uint64_t trial = 0; trial < testing_support::tried(20'000); ++trial) {
        std::array<double, 8> jitter;
        for (std::size_t c = 0; c < 8; ++c) {
          const double u = white(trial * 8 + c);
          jitter[c] = trial % 2 == 0 ? extremes[static_cast<std::size_t>(4 * u)] : std::max(u, 0x1p-53);
        }
        const double place = trial < 100 ? 0 : trial < 200 ? 1 : white(trial + 1'000'000);
        const auto id = static_cast<std::int64_t>(place * static_cast<double>(n - 1));
        std::array<float, 8> sample;
        sample_space(spec).sample(n, id, jitter.data(), sample.data());
        ASSERT_EQ(sample_space(spec).invert(n, sample.data()), id) << spec.space << ", n = " << n;
      }
    }
  }
}

TEST(SampleSpace, ListHoldsWhatSampleAtGivesForSomeJitter) {
  // A stratum is connected and the map monotone in each jitter, so the list's scalar lies between those of the
  // extremes.
  for (const char* const kind : {"uniform", "tent", "gauss", "circle"}) {
    const std::int64_t n = 101;
    const std::vector<float> list = list_of(space(kind), n);
    for (std::int64_t id = 0; id < n; ++id) {
      const double low = 0x1p-53;
      const double high = 1 - 0x1p-53;
      float first = 0;
      float last = 0;
      sample_space(space(kind)).sample(n, id, &low, &first);
      sample_space(space(kind)).sample(n, id, &high, &last);
      EXPECT_LE(first, list[static_cast<std::size_t>(id)]);
      EXPECT_GE(last, list[static_cast<std::size_t>(id)]);
    }
  }
}

// One point of the space by a method of its own: sums of uniforms and rejection from the cube; false when rejected.
bool independent_point(const SampleSpec& spec, std::uint64_t index, float* point) {
  const auto u = [index](std::uint64_t k) { return white(index * 16 + k); };
  const double x = 2 * u(0) - 1;
  const double y = 2 * u(1) - 1;
  const double z = 2 * u(2) - 1;
  const double length = std::sqrt(x * x + y * y + z * z);
  if (spec.space == "tent") {
    point[0] = static_cast<float>((u(0) + u(1)) / 2);
  } else if (spec.space == "gauss") {
    point[0] = static_cast<float>(std::sqrt(-2 * std::log(1 - u(0))) * std::cos(2 * math::pi * u(1)));
  } else if (spec.space == "disk") {
    point[0] = static_cast<float>(x);
    point[1] = static_cast<float>(y);
    return x * x + y * y < 1;
  } else if (sample_space(spec).traits().distance == DistanceKind::angle) {
    point[0] = static_cast<float>(x / length);
    point[1] = static_cast<float>(y / length);
    point[2] = static_cast<float>(z / length);
    if (spec.space != "sphere") point[2] = std::fabs(point[2]);
    if (spec.space == "hemisphere-cosine" && u(3) > static_cast<double>(point[2])) return false;
    return length > 0.01 && length < 1;
  } else {
    for (std::uint64_t c = 0; c < 8; ++c) point[c] = static_cast<float>(u(c) * (1 - 0x1p-24));
  }
  return true;
}

TEST(SampleSpace, StrataHaveEqualMeasure) {
  for (const SampleSpec& spec : all_spaces()) {
    constexpr std::int64_t n = 17;
    std::array<std::int64_t, n> count{};
    std::int64_t total = 0;
    for (std::uint64_t i = 0; i < 100'000; ++i) {
      std::array<float, 8> point;
      if (!independent_point(spec, i, point.data())) continue;
      ++count[static_cast<std::size_t>(sample_space(spec).invert(n, point.data()))];
      ++total;
    }
    double chi_square = 0;
    const double expected = static_cast<double>(total) / n;
    for (const std::int64_t c : count) {
      chi_square += (static_cast<double>(c) - expected) * (static_cast<double>(c) - expected) / expected;
    }
    // 16 degrees of freedom exceed 45 once in 7,000 trials; fixed seed.
    EXPECT_LT(chi_square, 45) << spec.space;
  }
}

TEST(SampleSpace, SamplesLieInTheirSpace) {
  for (const SampleSpec& spec : all_spaces()) {
    const std::vector<float> list = list_of(spec, 10'007);
    const auto channels = static_cast<std::size_t>(num_channels(spec));
    for (std::size_t i = 0; i < list.size(); i += channels) {
      double square = 0;
      for (std::size_t c = 0; c < channels; ++c) {
        square += static_cast<double>(list[i + c]) * static_cast<double>(list[i + c]);
        if (spec.space.starts_with("vector") || (channels == 1 && spec.space != "gauss")) {
          ASSERT_GE(list[i + c], 0);
          ASSERT_LT(list[i + c], 1);
        }
      }
      const bool unit = channels == 3 && !spec.space.starts_with("vector");
      const bool upper = spec.space == "hemisphere" || spec.space == "hemisphere-cosine";
      ASSERT_TRUE(!unit || std::fabs(square - 1) < 2e-7) << square;
      ASSERT_TRUE(spec.space != "disk" || square <= 1) << square;
      ASSERT_TRUE(!upper || list[i + 2] > 0) << list[i + 2];
      ASSERT_GT(sample_space(spec).density(&list[i]), 0);
    }
  }
}

// Mean of f over a stratified list.
double mean_of(const SampleSpec& spec, std::int64_t n, const std::function<double(const float*)>& f) {
  const std::vector<float> list = list_of(spec, n);
  double sum = 0;
  for (std::size_t i = 0; i < list.size(); i += static_cast<std::size_t>(num_channels(spec))) sum += f(&list[i]);
  return sum / static_cast<double>(n);
}

TEST(SampleSpace, MomentsEqualClosedForms) {
  // Stratified means are off by at most the largest stratum's size over sqrt(n): far below 1e-3 at n = 10,007 in one
  // and two dimensions.
  const std::int64_t n = 10'007;
  const auto first = [](const float* s) { return static_cast<double>(s[0]); };
  const auto square = [](const float* s) { return static_cast<double>(s[0]) * static_cast<double>(s[0]); };
  EXPECT_NEAR(mean_of(space("uniform"), n, first), 0.5, 1e-4);
  EXPECT_NEAR(mean_of(space("uniform"), n, square), 1.0 / 3, 1e-4);
  EXPECT_NEAR(mean_of(space("tent"), n, first), 0.5, 1e-4);
  EXPECT_NEAR(mean_of(space("tent"), n, square), 0.25 + 1.0 / 24, 1e-4);
  EXPECT_NEAR(mean_of(space("gauss"), n, first), 0, 1e-3);
  EXPECT_NEAR(mean_of(space("gauss"), n, square), 1, 2e-3);  // the outermost two strata scatter
  EXPECT_NEAR(mean_of(space("disk"), n, first), 0, 1e-3);
  EXPECT_NEAR(mean_of(space("disk"), n, square), 0.25, 1e-3);
  for (int c = 0; c < 3; ++c) {
    const auto channel = [c](const float* s) { return static_cast<double>(s[c]); };
    const auto channel_square = [c](const float* s) { return static_cast<double>(s[c]) * static_cast<double>(s[c]); };
    EXPECT_NEAR(mean_of(space("sphere"), n, channel), 0, 1e-3);
    EXPECT_NEAR(mean_of(space("sphere"), n, channel_square), 1.0 / 3, 1e-3);
    EXPECT_NEAR(mean_of(space("hemisphere"), n, channel), c == 2 ? 0.5 : 0, 1e-3);
    EXPECT_NEAR(mean_of(space("hemisphere"), n, channel_square), 1.0 / 3, 1e-3);
    EXPECT_NEAR(mean_of(space("hemisphere-cosine"), n, channel), c == 2 ? 2.0 / 3 : 0, 1e-3);
    EXPECT_NEAR(mean_of(space("hemisphere-cosine"), n, channel_square), c == 2 ? 0.5 : 0.25, 1e-3);
  }
}

// Mean distance between the lists of two slices: all pairs, so its error is that of the stratified means.
double mean_distance(const SampleSpec& spec, std::int64_t n) {
  const std::vector<float> a = list_of(spec, n, 1, 0);
  const std::vector<float> b = list_of(spec, n, 1, 1);
  const int channels = num_channels(spec);
  const auto step = static_cast<std::size_t>(channels);
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); i += step) {
    for (std::size_t j = 0; j < b.size(); j += step)
      sum += distance(distance_kind(spec, channels), channels, &a[i], &b[j]);
  }
  return sum / static_cast<double>(n * n);
}

TEST(SampleSpace, MeanDistancesEqualClosedForms) {
  const std::int64_t n = testing_support::under_sanitizers ? 401 : 1009;
  const double part = testing_support::under_sanitizers ? 6 : 1;  // of what strata leave, about 1 / n^2
  EXPECT_NEAR(mean_distance(space("uniform"), n), 1.0 / 3, part * 1e-4);
  EXPECT_NEAR(mean_distance(space("tent"), n), 7.0 / 30, part * 1e-4);
  EXPECT_NEAR(mean_distance(space("gauss"), n), 2 / std::sqrt(math::pi), part * 2e-3);
  EXPECT_NEAR(mean_distance(space("circle"), n), 0.25, part * 1e-4);
  EXPECT_NEAR(mean_distance(space("disk"), n), 128 / (45 * math::pi), part * 2e-3);
  EXPECT_NEAR(mean_distance(space("vector2"), n), (2 + std::sqrt(2.0) + 5 * std::asinh(1.0)) / 15, part * 1e-3);
  EXPECT_NEAR(mean_distance(space("sphere"), n), math::pi / 2, part * 1e-3);
}

TEST(SampleSpace, PdfIntegratesToOne) {
  constexpr int steps = 100'000;
  double tent = 0;
  double gauss = 0;
  for (int i = 0; i < steps; ++i) {
    const auto x = static_cast<float>((i + 0.5) / steps);
    tent += sample_space(space("tent")).density(&x) / steps;
    const float y = 20 * x - 10;
    gauss += sample_space(space("gauss")).density(&y) * 20 / steps;
  }
  EXPECT_NEAR(tent, 1, 1e-5);
  EXPECT_NEAR(gauss, 1, 1e-5);
  // Uniform over solid angle: each sample stands for an equal part of the sphere or hemisphere.
  const auto integral = [](const std::string& over, double measure, const std::string& pdf) {
    return measure *
           mean_of(space(over), 10'007, [pdf](const float* s) { return sample_space(space(pdf)).density(s); });
  };
  EXPECT_NEAR(integral("sphere", 4 * math::pi, "sphere"), 1, 1e-12);
  EXPECT_NEAR(integral("hemisphere", 2 * math::pi, "hemisphere"), 1, 1e-12);
  EXPECT_NEAR(integral("sphere", 4 * math::pi, "hemisphere-cosine"), 1, 1e-3);
  EXPECT_NEAR(integral("disk", math::pi, "disk"), 1, 1e-12);
  EXPECT_EQ(sample_space(space("vector2")).density(std::array<float, 2>{0.5F, 0.1F}.data()), 1);
}

TEST(SampleSpace, NeighboursInTheListAreNeighboursInSpace) {
  for (const SampleSpec& spec : all_spaces()) {
    const std::int64_t n = 4099;
    const std::vector<float> list = list_of(spec, n);
    const int channels = num_channels(spec);
    const auto step = static_cast<std::size_t>(channels);
    double near = 0;
    for (std::size_t i = step; i < list.size(); i += step) {
      near += distance(distance_kind(spec, channels), channels, &list[i - step], &list[i]) / static_cast<double>(n - 1);
    }
    // A stratum of a D-dimensional space is about n^(-1/D) wide; steps are a few strata on average.
    const double width = std::pow(static_cast<double>(n), -1.0 / sample_space(spec).traits().dimensions);
    EXPECT_LT(near, std::min(8 * width, 0.6) * mean_distance(spec, 101)) << spec.space;
  }
}

TEST(SampleSource, ListIsAFunctionOfSpecSeedAndSlice) {
  for (const SampleSpec& spec : all_spaces()) {
    const SampleSource source(spec, 101, 3, 5);
    EXPECT_EQ(source.list(SliceIndex(1)), source.list(SliceIndex(1)));
    EXPECT_EQ(source.list(SliceIndex(1)), SampleSource(spec, 101, 2, 5).list(SliceIndex(1)));
    EXPECT_NE(source.list(SliceIndex(1)), source.list(SliceIndex(2)));
    EXPECT_NE(source.list(SliceIndex(1)), SampleSource(spec, 101, 3, 6).list(SliceIndex(1)));
    EXPECT_EQ(source.channels(), num_channels(spec));
    EXPECT_EQ(source.distance(), distance_kind(spec, num_channels(spec)));
  }
}

// FNV-1a over the bits of a list of every space: other bits mean other textures, so a change is a change of format.
TEST(SampleSource, ListsHaveTheSameBitsOnEveryMachine) {
  std::uint64_t digest = 0xcbf29ce484222325U;
  for (const SampleSpec& spec : all_spaces()) {
    for (const float value : list_of(spec, 10'007, 5, 2)) {
      digest = (digest ^ std::bit_cast<std::uint32_t>(value)) * 0x100000001b3U;
    }
  }
  EXPECT_EQ(digest, 9783992489851332987U);
}

TEST(SampleSource, JitterIsUniformAndUncorrelatedBetweenStrataAndSlices) {
  constexpr std::int64_t n = 16'381;
  const std::vector<float> first = list_of(space("uniform"), n, 1, 0);
  const std::vector<float> second = list_of(space("uniform"), n, 1, 1);
  const auto centred = [](const std::vector<float>& list, std::size_t id) {
    return static_cast<double>(list[id]) * static_cast<double>(n) - static_cast<double>(id) - 0.5;
  };
  double mean = 0;
  double variance = 0;
  double between_strata = 0;
  double between_slices = 0;
  for (std::size_t id = 0; id < first.size(); ++id) {
    mean += centred(first, id) / static_cast<double>(n);
    variance += centred(first, id) * centred(first, id) / static_cast<double>(n);
    between_strata += centred(first, id) * centred(first, (id + 1) % first.size()) / static_cast<double>(n);
    between_slices += centred(first, id) * centred(second, id) / static_cast<double>(n);
  }
  // Four standard errors: of the mean sqrt(1/12 / n), of the products (1/12) / sqrt(n), of the square sqrt(1/180 / n).
  const double root = std::sqrt(static_cast<double>(n));
  EXPECT_NEAR(mean, 0, 4 * std::sqrt(1.0 / 12) / root);
  EXPECT_NEAR(variance, 1.0 / 12, 4 * std::sqrt(1.0 / 180) / root);
  EXPECT_NEAR(between_strata, 0, 4.0 / 12 / root);
  EXPECT_NEAR(between_slices, 0, 4.0 / 12 / root);
}

TEST(SampleSource, SaysWhichSpacesHaveAPdf) {
  for (const SampleSpec& spec : all_spaces()) {
    const std::vector<float> list = list_of(spec, 1009);
    const SampleSource source(spec, 1, 1, 1);
    double least = INFINITY;
    double most = 0;
    for (std::size_t i = 0; i < list.size(); i += static_cast<std::size_t>(source.channels())) {
      least = std::min(least, source.pdf(&list[i]));
      most = std::max(most, source.pdf(&list[i]));
    }
    EXPECT_EQ(source.has_pdf(), least != most) << spec.space;
  }
}

}  // namespace
}  // namespace noiseloom
