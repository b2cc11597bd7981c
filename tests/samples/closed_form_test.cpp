// Spaces with parameters and densities in closed form, each held against a description of its own: which points it
// holds and how densely, as a function of a point of the box around them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "noiseloom/core/math.h"
#include "noiseloom/core/random.h"
#include "noiseloom/samples/sample_space.h"
#include "noiseloom/samples/space.h"

namespace noiseloom {
namespace {

constexpr std::size_t most_channels = 4;
using Point = std::array<float, most_channels>;

// [0, 1), independent of the library's jitter.
double random_number(std::uint64_t index, std::uint64_t k) {
  const RandomBlock bits = random_block(77, Purpose::subset, 0, 0, index * 16 + k);
  return to_unit_double(bits[0], bits[1]);
}

struct Case {
  SampleSpec spec;
  // A point of the space at the i-th place of an independent random walk through it, by another way than the library's;
  // false where the draw is rejected.
  std::function<bool(std::uint64_t i, Point& point)> draw;
  double measure;  // of the support, in the measure of the density; infinite where it is unbounded

  const SampleSpace& space() const { return sample_space(spec); }
  std::string name() const {
    std::string text = spec.space;
    for (const double value : spec.parameters) text += ' ' + std::to_string(value);
    return text;
  }
};

SampleSpec spec_of(const std::string& name, const std::vector<double>& parameters) {
  SampleSpec spec;
  spec.space = name;
  spec.parameters = parameters;
  return spec;
}

double radians(double degrees) { return degrees * math::pi / 180; }

Case cone(double angle) {
  const double lowest = std::cos(radians(angle));
  return {spec_of("cone", {angle}),
          [lowest](std::uint64_t i, Point& point) {  // Archimedes: z is uniform
            const double z = lowest + (1 - lowest) * random_number(i, 0);
            const double turn = 2 * math::pi * random_number(i, 1);
            const double side = std::sqrt((1 - z) * (1 + z));
            point = {static_cast<float>(side * std::cos(turn)), static_cast<float>(side * std::sin(turn)),
                     static_cast<float>(z)};
            return true;
          },
          2 * math::pi * (1 - lowest)};
}

std::vector<Case> all_cases() { return {cone(0.01), cone(1), cone(30), cone(90), cone(135), cone(180)}; }

std::vector<float> list_of_case(const SampleSpec& spec, std::int64_t n) { return SampleSource(spec, n, 1, 1).list(0); }

TEST(ClosedForm, EachStratumHoldsExactlyOneSample) {
  for (const Case& c : all_cases()) {
    const auto channels = static_cast<std::size_t>(c.space().traits().channels);
    for (const std::int64_t n : {1, 2, 3, 5, 17, 101, 128 * 128}) {
      const std::vector<float> list = list_of_case(c.spec, n);
      ASSERT_EQ(list.size(), static_cast<std::size_t>(n) * channels);
      for (std::int64_t id = 0; id < n; ++id) {
        ASSERT_EQ(c.space().invert(n, &list[static_cast<std::size_t>(id) * channels]), id) << c.name() << ", n = " << n;
      }
    }
  }
}

TEST(ClosedForm, InvertUndoesSampleAfterRoundingToFloat) {
  const std::array<double, 4> extremes = {0x1p-53, 0.5, 1 - 0x1p-26, 1 - 0x1p-53};
  for (const Case& c : all_cases()) {
    for (const std::int64_t n : {std::int64_t{1} << 24, std::int64_t{1'000'003}}) {
      for (std::uint64_t trial = 0; trial < 20'000; ++trial) {
        std::array<double, most_channels> jitter;
        for (std::uint64_t k = 0; k < jitter.size(); ++k) {
          const double u = random_number(trial, k);
          jitter[k] = trial % 2 == 0 ? extremes[static_cast<std::size_t>(4 * u)] : std::max(u, 0x1p-53);
        }
        const double place = trial < 100 ? 0 : trial < 200 ? 1 : random_number(trial, 8);
        const auto id = static_cast<std::int64_t>(place * static_cast<double>(n - 1));
        Point sample;
        c.space().sample(n, id, jitter.data(), sample.data());
        ASSERT_EQ(c.space().invert(n, sample.data()), id) << c.name() << ", n = " << n;
        ASSERT_GT(c.space().density(sample.data()), 0) << c.name();
      }
    }
  }
}

// The chi-square of points that were drawn by another way, over n strata, with its standard deviation sqrt(2 (n - 1)):
// by chance it passes 5 of them less than once in 100,000 trials (n = 64) and in 2 million (n = 1,000).
TEST(ClosedForm, StrataHoldEqualSharesOfPointsDrawnInAnotherWay) {
  for (const Case& c : all_cases()) {
    for (const std::int64_t n : {64, 1000}) {
      std::vector<std::int64_t> count(static_cast<std::size_t>(n), 0);
      std::int64_t total = 0;
      for (std::uint64_t i = 0; i < 200'000; ++i) {
        Point point;
        if (!c.draw(i, point)) continue;
        ++count[static_cast<std::size_t>(c.space().invert(n, point.data()))];
        ++total;
      }
      const double expected = static_cast<double>(total) / static_cast<double>(n);
      ASSERT_GT(expected, 20) << c.name();
      double chi_square = 0;
      for (const std::int64_t k : count) {
        chi_square += (static_cast<double>(k) - expected) * (static_cast<double>(k) - expected) / expected;
      }
      const double freedom = static_cast<double>(n - 1);
      EXPECT_LT(chi_square, freedom + 5 * std::sqrt(2 * freedom)) << c.name() << ", n = " << n;
    }
  }
}

// Means over the stratified list: E[1/density] is the measure of the support, and so the integral of the density is 1.
TEST(ClosedForm, MeanOfOneOverTheDensityIsTheMeasureOfTheSupport) {
  for (const Case& c : all_cases()) {
    if (!std::isfinite(c.measure)) continue;
    const std::int64_t n = 10'007;
    const std::vector<float> list = list_of_case(c.spec, n);
    const auto channels = static_cast<std::size_t>(c.space().traits().channels);
    double sum = 0;
    for (std::size_t i = 0; i < list.size(); i += channels) sum += 1 / c.space().density(&list[i]);
    EXPECT_NEAR(sum / static_cast<double>(n) / c.measure, 1, 1e-3) << c.name();
  }
}

TEST(ClosedForm, NeighboursInTheListAreNeighboursInSpace) {
  for (const Case& c : all_cases()) {
    const std::int64_t n = 4099;
    const std::vector<float> list = list_of_case(c.spec, n);
    const int channels = c.space().traits().channels;
    const DistanceKind kind = c.space().traits().distance;
    const auto step = static_cast<std::size_t>(channels);
    double near = 0;
    double far = 0;
    for (std::size_t i = step; i < list.size(); i += step) {
      near += distance(kind, channels, &list[i - step], &list[i]);
      far += distance(kind, channels, &list[i], &list[i * 7919 % list.size() / step * step]);
    }
    const double width = std::pow(static_cast<double>(n), -1.0 / c.space().traits().dimensions);
    EXPECT_LT(near, 8 * width * far) << c.name();
  }
}

// The distribution function of each coordinate, against points that were drawn in another way: their largest distance
// passes the bound (Kolmogorov's) by chance less than once in a million trials.
TEST(ClosedForm, ShareBelowIsTheDistributionOfACoordinate) {
  for (const Case& c : all_cases()) {
    for (int channel = 0; channel < c.space().traits().channels; ++channel) {
      std::vector<double> values;
      for (std::uint64_t i = 0; values.size() < 20'000; ++i) {
        Point point;
        if (c.draw(i, point)) values.push_back(static_cast<double>(point[static_cast<std::size_t>(channel)]));
      }
      std::sort(values.begin(), values.end());
      const double n = static_cast<double>(values.size());
      const double bound = std::sqrt(std::log(2 / 1e-6) / (2 * n));
      for (std::size_t i = 0; i < values.size(); i += 400) {
        // Values that are alike as floats count as below each other or not.
        const auto [first, last] = std::equal_range(values.begin(), values.end(), values[i]);
        const double share = c.space().share_below(channel, values[i]);
        EXPECT_GT(share, static_cast<double>(first - values.begin()) / n - bound)
            << c.name() << ", channel " << channel;
        EXPECT_LT(share, static_cast<double>(last - values.begin()) / n + bound) << c.name() << ", channel " << channel;
      }
    }
  }
}

}  // namespace
}  // namespace noiseloom
