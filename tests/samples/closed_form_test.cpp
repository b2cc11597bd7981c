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
#include "support/sanitizers.h"

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

// alpha and the angle of the view. Slopes of visible normals in the plane of the view, over alpha, have the density
// (alpha tan(view) x + 1)^+ / (1 + x^2)^(3/2), and across it, for a slope x, 1 / (1 + x^2 + y^2)^2.
Case ggx(double alpha, double view) {
  const double along = std::cos(radians(view));
  const double across = alpha * std::sin(radians(view));
  return {spec_of("ggx", {alpha, view}),
          [alpha, along, across](std::uint64_t i, Point& point) {
            double x = 0;
            const double u = random_number(i, 1);
            if (random_number(i, 0) * (along + across / 2) < along) {
              x = (2 * u - 1) / (2 * std::sqrt(u * (1 - u)));
              if (x < 0 && random_number(i, 2) * along > along + across * x) return false;
            } else {
              x = std::sqrt(1 / ((1 - u) * (1 - u)) - 1);
            }
            const double omega = math::pi * (random_number(i, 3) - 0.5);
            if (random_number(i, 4) > std::cos(omega) * std::cos(omega)) return false;
            const double y = std::sqrt(1 + x * x) * std::tan(omega);
            const double length = std::sqrt(1 + alpha * alpha * (x * x + y * y));
            point = {static_cast<float>(alpha * x / length), static_cast<float>(alpha * y / length),
                     static_cast<float>(1 / length)};
            return true;
          },
          2 * (math::pi - radians(view))};
}

// Points of the square around the unit disk of which `inside` is true.
Case part_of_square(const SampleSpec& spec, double measure, const std::function<bool(double x, double y)>& inside) {
  return {spec,
          [inside](std::uint64_t i, Point& point) {
            const double x = 2 * random_number(i, 0) - 1;
            const double y = 2 * random_number(i, 1) - 1;
            point = {static_cast<float>(x), static_cast<float>(y)};
            return inside(x, y);
          },
          measure};
}

Case ring(double inner) {
  return {spec_of("ring", {inner}),
          [inner](std::uint64_t i, Point& point) {
            const double radius = std::sqrt(inner * inner + (1 - inner * inner) * random_number(i, 0));
            const double turn = 2 * math::pi * random_number(i, 1);
            point = {static_cast<float>(radius * std::cos(turn)), static_cast<float>(radius * std::sin(turn))};
            return true;
          },
          math::pi * (1 - inner * inner)};
}

// Whether a ray from the point crosses the outline an odd number of times.
bool in_polygon(const std::vector<std::array<double, 2>>& corners, double x, double y) {
  bool inside = false;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const auto& a = corners[k];
    const auto& b = corners[(k + 1) % corners.size()];
    if ((a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) * (b[0] - a[0]) / (b[1] - a[1])) inside = !inside;
  }
  return inside;
}

Case polygon(const SampleSpec& spec, int corners, double inner) {
  std::vector<std::array<double, 2>> outline;
  for (int k = 0; k < corners; ++k) {
    const double radius = k % 2 == 0 ? 1 : inner;
    outline.push_back({radius * std::cos(2 * math::pi * k / corners), radius * std::sin(2 * math::pi * k / corners)});
  }
  return part_of_square(spec, 0.5 * corners * inner * std::sin(2 * math::pi / corners),
                        [outline](double x, double y) { return in_polygon(outline, x, y); });
}

Case star(int points, double inner) {
  return polygon(spec_of("star", {static_cast<double>(points), inner}), 2 * points, inner);
}

Case exponential() {
  return {spec_of("exponential", {}),
          [](std::uint64_t i, Point& point) {
            point[0] = static_cast<float>(-std::log(1 - random_number(i, 0)));
            return true;
          },
          INFINITY};
}

Case gauss2() {
  return {spec_of("gauss2", {}),
          [](std::uint64_t i, Point& point) {
            const double radius = std::sqrt(-2 * std::log(1 - random_number(i, 0)));
            const double turn = 2 * math::pi * random_number(i, 1);
            point = {static_cast<float>(radius * std::cos(turn)), static_cast<float>(radius * std::sin(turn))};
            return true;
          },
          INFINITY};
}

Case triangle() {
  return {spec_of("triangle", {}),
          [](std::uint64_t i, Point& point) {
            for (std::uint64_t c = 0; c < 2; ++c) {
              point[c] = static_cast<float>(random_number(i, 2 * c) - random_number(i, 2 * c + 1));
            }
            return true;
          },
          4};
}

// A point of the sphere in as many dimensions by rejection from its cube, and of it and its opposite the one whose last
// number is positive.
Case half_sphere(const std::string& name, std::uint64_t channels, double measure) {
  return {spec_of(name, {}),
          [channels](std::uint64_t i, Point& point) {
            std::array<double, most_channels> x{};
            double square = 0;
            for (std::uint64_t c = 0; c < channels; ++c) {
              x[c] = 2 * random_number(i, c) - 1;
              square += x[c] * x[c];
            }
            const double scale = std::copysign(1 / std::sqrt(square), x[channels - 1]);
            for (std::uint64_t c = 0; c < channels; ++c) point[c] = static_cast<float>(x[c] * scale);
            return square > 0.01 && square < 1;
          },
          measure};
}

std::vector<Case> all_cases() {
  std::vector<Case> cases = {cone(0.01), cone(1), cone(30), cone(90), cone(135), cone(180)};
  for (const double alpha : {1e-4, 0.3, 1.0}) {
    for (const double view : {0.0, 60.0, 89.9}) cases.push_back(ggx(alpha, view));
  }
  for (const double inner : {0.0, 0.5, 0.999}) cases.push_back(ring(inner));
  cases.push_back(polygon(spec_of("hexagon", {}), 6, 1));
  for (const int points : {3, 5, 16}) {
    for (const double inner : {0.1, 0.4, 1.0}) cases.push_back(star(points, inner));
  }
  cases.push_back(star(3, 0.01));
  cases.push_back(half_sphere("axis", 3, 2 * math::pi));
  cases.push_back(half_sphere("rotation", 4, math::pi * math::pi));
  cases.push_back(exponential());
  cases.push_back(gauss2());
  cases.push_back(triangle());
  return cases;
}

std::vector<float> list_of_case(const SampleSpec& spec, std::int64_t n) {
  return SampleSource(spec, n, 1, 1).list(SliceIndex(0));
}

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
      for (std::uint64_t trial = 0; trial < testing_support::tried(20'000); ++trial) {
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
    std::vector<Point> points;
    for (std::uint64_t i = 0; points.size() < testing_support::tried(100'000); ++i) {
      Point point;
      if (c.draw(i, point)) points.push_back(point);
    }
    for (const std::int64_t n : {64, 1000}) {
      std::vector<std::int64_t> count(static_cast<std::size_t>(n), 0);
      for (const Point& point : points) ++count[static_cast<std::size_t>(c.space().invert(n, point.data()))];
      const double expected = static_cast<double>(points.size()) / static_cast<double>(n);
      double chi_square = 0;
      for (const std::int64_t k : count) {
        chi_square += (static_cast<double>(k) - expected) * (static_cast<double>(k) - expected) / expected;
      }
      const double freedom = static_cast<double>(n - 1);
      EXPECT_LT(chi_square, freedom + 5 * std::sqrt(2 * freedom)) << c.name() << ", n = " << n;
    }
  }
}

// E[1/density] is the measure of the support: where the density is constant to the last digits, and its integral so 1;
// else to 4 standard errors of as many independent samples. (Of a mirror, ten thousand samples meet no part of what
// the density's tail covers.)
TEST(ClosedForm, MeanOfOneOverTheDensityIsTheMeasureOfTheSupport) {
  for (const Case& c : all_cases()) {
    if (!std::isfinite(c.measure) || (c.spec.space == "ggx" && c.spec.parameters[0] < 0.1)) continue;
    const std::int64_t n = 10'007;
    const std::vector<float> list = list_of_case(c.spec, n);
    const auto channels = static_cast<std::size_t>(c.space().traits().channels);
    double mean = 0;
    double squares = 0;
    for (std::size_t i = 0; i < list.size(); i += channels) {
      const double value = 1 / c.space().density(&list[i]) / c.measure;
      mean += value / static_cast<double>(n);
      squares += value * value / static_cast<double>(n);
    }
    const double error = std::sqrt(std::max(0.0, squares - mean * mean) / static_cast<double>(n));
    EXPECT_NEAR(mean, 1, 4 * error + 1e-12) << c.name();
    EXPECT_EQ(squares - mean * mean < 1e-9, c.space().traits().has_constant_density) << c.name();
  }
}

TEST(ClosedForm, NeighboursInTheListAreNeighboursInSpace) {
  for (const Case& c : all_cases()) {
    const std::int64_t n = 4099;
    const std::vector<float> list = list_of_case(c.spec, n);
    const int channels = c.space().traits().channels;
    const DistanceKind kind = c.space().traits().distance;
    const auto step = static_cast<std::size_t>(channels);
    std::vector<double> near;  // medians: densities may have far tails
    std::vector<double> far;
    for (std::size_t i = step; i < list.size(); i += step) {
      near.push_back(distance(kind, channels, &list[i - step], &list[i]));
      far.push_back(distance(kind, channels, &list[i], &list[i * 7919 % list.size() / step * step]));
    }
    const auto median = [](std::vector<double>& values) {
      std::sort(values.begin(), values.end());
      return values[values.size() / 2];
    };
    const double width = std::pow(static_cast<double>(n), -1.0 / c.space().traits().dimensions);
    EXPECT_LT(median(near), 4 * width * median(far)) << c.name();
  }
}

// The distribution function of each coordinate, against points that were drawn in another way: their largest distance
// passes the bound (Kolmogorov's) by chance less than once in a million trials.
TEST(ClosedForm, ShareBelowIsTheDistributionOfACoordinate) {
  for (const Case& c : all_cases()) {
    for (int channel = 0; channel < c.space().traits().channels; ++channel) {
      std::vector<double> values;
      for (std::uint64_t i = 0; values.size() < testing_support::tried(20'000); ++i) {
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
