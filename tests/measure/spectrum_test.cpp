// Power spectra against a plain double sum and against signals whose spectra are known.
#include "noiseloom/measure/spectrum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <complex>
#include <map>
#include <numbers>

#include "support/run_files.h"

namespace noiseloom {
namespace {

constexpr double turn = 2 * std::numbers::pi;

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

// P(kx, ky) of the planes over axes 0 and `axis`, straight from the definition.
double power_by_sums(const Texture& texture, int axis, int kx, int ky) {
  const Extents& e = texture.extents;
  const std::int64_t total = e.num_cells();
  const auto value = [&](int c, std::int64_t flat) {
    return static_cast<double>(
        texture.slice(SliceIndex(flat / e.cells_per_slice()))[c * e.cells_per_slice() + flat % e.cells_per_slice()]);
  };
  std::int64_t stride = 1;
  for (int a = 0; a < axis; ++a) stride *= e.size(a);
  double power = 0;
  double variance = 0;
  int planes = 0;
  for (int c = 0; c < texture.channels; ++c) {
    double mean = 0;
    for (std::int64_t i = 0; i < total; ++i) mean += value(c, i) / static_cast<double>(total);
    for (std::int64_t i = 0; i < total; ++i) variance += std::pow(value(c, i) - mean, 2) / static_cast<double>(total);
    planes = 0;
    for (std::int64_t origin = 0; origin < total; ++origin) {
      if (origin % e.width() != 0 || origin / stride % e.size(axis) != 0) continue;
      ++planes;
      std::complex<double> sum = 0;
      for (std::int64_t y = 0; y < e.size(axis); ++y)
        for (std::int64_t x = 0; x < e.width(); ++x) {
          const double phase = turn * (static_cast<double>(kx * x) / static_cast<double>(e.width()) +
                                       static_cast<double>(ky * y) / static_cast<double>(e.size(axis)));
          sum += (value(c, origin + x + y * stride) - mean) * std::polar(1.0, -phase);
        }
      power += std::norm(sum);
    }
  }
  return power / (planes * static_cast<double>(e.width() * e.size(axis)) * variance);
}

TEST(PlaneSpectrum, IsTheDiscreteFourierTransform) {
  const Texture texture = start_texture(small_config("vector3", "x = 7, y = 5, t = 3, z = 2"));
  for (const int axis : {1, 2, 3}) {
    const PlaneSpectrum spectrum = plane_spectrum(texture, DistanceKind::euclidean, 0, axis);
    ASSERT_EQ(spectrum.width, 7);
    ASSERT_EQ(spectrum.height, texture.extents.size(axis));
    for (int y = 0; y < spectrum.height; ++y)
      for (int x = 0; x < spectrum.width; ++x) {
        const int kx = x - spectrum.width / 2;
        const int ky = y - spectrum.height / 2;
        const double expected = kx == 0 && ky == 0 ? 0 : power_by_sums(texture, axis, kx, ky);
        EXPECT_NEAR(spectrum.at(x, y), expected, 1e-12) << "axis " << axis << " frequency " << kx << ", " << ky;
      }
  }
}

TEST(PlaneSpectrum, HasMeanOneByParseval) {
  // Each slice of stratified samples has nearly the mean of all, so little is at frequency zero.
  const Texture texture = start_texture(small_config("uniform", "x = 31, y = 29, t = 2"));
  EXPECT_NEAR(mean_of(plane_spectrum(texture, DistanceKind::absolute, 0, 1).power), 1, 1e-5);
}

TEST(PlaneSpectrum, ShowsAWaveAsTwoPoints) {
  Texture texture = make_texture(Extents({12, 10}), 1);
  for (int y = 0; y < 10; ++y)
    for (int x = 0; x < 12; ++x)
      texture.values[static_cast<std::size_t>(12 * y + x)] =
          static_cast<float>(std::cos(turn * (2 * x / 12.0 - 3 * y / 10.0)));
  const PlaneSpectrum spectrum = plane_spectrum(texture, DistanceKind::absolute, 0, 1);
  EXPECT_NEAR(spectrum.at(6 + 2, 5 - 3), 60, 1e-4);
  EXPECT_NEAR(spectrum.at(6 - 2, 5 + 3), 60, 1e-4);
  EXPECT_NEAR(mean_of(spectrum.power), 1, 1e-9);
}

TEST(PlaneSpectrum, DoesNotSeeWhereACircleIsCut) {
  Texture texture = start_texture(small_config("circle", "x = 11, y = 7"));
  const PlaneSpectrum before = plane_spectrum(texture, DistanceKind::circle, 0, 1);
  for (float& v : texture.values) v = v + 0.375F < 1 ? v + 0.375F : v - 0.625F;
  const PlaneSpectrum after = plane_spectrum(texture, DistanceKind::circle, 0, 1);
  for (std::size_t i = 0; i < before.power.size(); ++i) EXPECT_NEAR(after.power[i], before.power[i], 1e-5);
}

TEST(PlaneSpectrum, OfAConstantTextureIsZero) {
  Texture texture = make_texture(Extents({5, 3}), 1);
  for (float& v : texture.values) v = 0.5F;
  for (const double p : plane_spectrum(texture, DistanceKind::absolute, 0, 1).power) EXPECT_EQ(p, 0);
}

// P along any axes, straight from the definition: one frequency of a scalar texture.
double axes_power_by_sums(const Texture& texture, const std::vector<int>& axes, const std::vector<std::int64_t>& k) {
  const Extents& e = texture.extents;
  double mean = 0;
  double squares = 0;
  for (const float v : texture.values) mean += v / static_cast<double>(e.num_cells());
  for (const float v : texture.values) squares += (v - mean) * (v - mean);
  std::map<std::vector<std::int64_t>, std::complex<double>> sums;  // by the position along the other axes
  for (std::int64_t flat = 0; flat < e.num_cells(); ++flat) {
    std::vector<std::int64_t> rest;
    double phase = 0;
    std::int64_t left = flat;
    for (int axis = 0; axis < e.num_axes(); left /= e.size(axis), ++axis) {
      const std::int64_t x = left % e.size(axis);
      const auto found = std::find(axes.begin(), axes.end(), axis);
      if (found == axes.end()) {
        rest.push_back(x);
      } else {
        phase += turn * static_cast<double>(x * k[static_cast<std::size_t>(found - axes.begin())]) /
                 static_cast<double>(e.size(axis));
      }
    }
    sums[rest] += (texture.values[static_cast<std::size_t>(flat)] - mean) * std::polar(1.0, -phase);
  }
  double power = 0;
  for (const auto& [rest, sum] : sums) power += std::norm(sum);
  return power / squares;
}

TEST(AxesSpectrum, IsTheDiscreteFourierTransformOverAnyAxes) {
  const Texture texture = start_texture(small_config("uniform", "x = 5, y = 4, t = 3, z = 6"));
  for (const auto& axes :
       std::vector<std::vector<int>>{{2}, {3}, {0}, {0, 1}, {2, 3}, {1, 3}, {0, 1, 2}, {0, 1, 2, 3}}) {
    const AxesSpectrum spectrum = axes_spectrum(texture, DistanceKind::absolute, axes);
    ASSERT_EQ(spectrum.sizes.size(), axes.size());
    std::vector<std::int64_t> k(axes.size(), 0);
    for (std::size_t i = 0; i < spectrum.power.size(); ++i) {
      EXPECT_NEAR(spectrum.power[i], i == 0 ? 0 : axes_power_by_sums(texture, axes, k), 1e-6)
          << axes.size() << " " << i;
      for (std::size_t a = 0; a < k.size() && ++k[a] == spectrum.sizes[a]; ++a) k[a] = 0;
    }
  }
}

TEST(AxesSpectrum, OfALineIsThatOfThePlaneAveragedOverTheOtherAxis) {
  const Texture texture = start_texture(small_config("uniform", "x = 9, y = 4, t = 10"));
  const std::vector<SpectrumBin> rows = row_average(plane_spectrum(texture, DistanceKind::absolute, 0, 2));
  const std::vector<SpectrumBin> line = radial_average(axes_spectrum(texture, DistanceKind::absolute, {2}));
  ASSERT_EQ(line.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(line[i].frequency, rows[i + 1].frequency, 1e-15);
    EXPECT_NEAR(line[i].power, rows[i + 1].power, 1e-12);
    EXPECT_EQ(line[i].count, i == 4 ? 1 : 2);
  }
}

TEST(PowerBelow, IsTheMeanOverTheFrequenciesInsideTheCircle) {
  AxesSpectrum spectrum{{40, 60}, std::vector<double>(2400, 1000.0)};
  const auto at = [&](int kx, int ky) -> double& {
    return spectrum.power[static_cast<std::size_t>((kx + 40) % 40 + 40 * ((ky + 60) % 60))];
  };
  // Below 0.05: (+-1, 0), (+-1, +-1), (+-1, +-2)? |(1/40, 2/60)| = 0.0417; (0, +-1), (0, +-2); 3/60 and 2/40 are not.
  for (const int s : {-1, 1}) {
    at(s, 0) = 1;
    at(0, s) = 2;
    at(0, 2 * s) = 3;
    for (const int r : {-1, 1}) {
      at(s, r) = 4;
      at(s, 2 * r) = 5;
    }
  }
  EXPECT_NEAR(power_below(spectrum, 0.05), (2 * 1 + 2 * 2 + 2 * 3 + 4 * 4 + 4 * 5) / 14.0, 1e-12);
  EXPECT_TRUE(std::isnan(power_below(spectrum, 1.0 / 60)));
}

TEST(RadialAverage, KeepsAFunctionOfTheRadius) {
  PlaneSpectrum spectrum{40, 30, std::vector<double>(1200)};
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x)
      spectrum.power[static_cast<std::size_t>(40 * y + x)] = std::hypot((x - 20) / 40.0, (y - 15) / 30.0);
  int count = 0;
  for (const SpectrumBin& bin : radial_average(spectrum)) {
    EXPECT_NEAR(bin.power, bin.frequency, 1e-12);
    EXPECT_LE(bin.frequency, 0.5 + 0.5 / 40);
    count += bin.count;
  }
  EXPECT_GT(count, 1200 * 3 / 4 * 0.9);  // about pi/4 of all frequencies are nearer than 1/2
}

TEST(RowAverage, IsTheMeanOverColumns) {
  PlaneSpectrum spectrum{5, 6, std::vector<double>(30)};
  for (std::size_t i = 0; i < 30; ++i) spectrum.power[i] = static_cast<double>(i / 5 * i / 5);
  const std::vector<SpectrumBin> bins = row_average(spectrum);
  ASSERT_EQ(bins.size(), 4U);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(bins[k].frequency, static_cast<double>(k) / 6, 1e-15);
    EXPECT_EQ(bins[k].count, k == 0 ? 4 : 5);
  }
}

TEST(FilterResponse, IsTheSquareOfTheFiltersGain) {
  const RunConfig config = small_config("uniform", "x = 16, y = 15");
  const PlaneSpectrum response = filter_response(Footprint(config.problem.extents, config.problem.filter));
  for (int y = 0; y < 15; ++y)
    for (int x = 0; x < 16; ++x) {  // box 3: (1 + 2 cos)/3 along each axis
      const double gx = (1 + 2 * std::cos(turn * (x - 8) / 16)) / 3;
      const double gy = (1 + 2 * std::cos(turn * (y - 7) / 15)) / 3;
      EXPECT_NEAR(response.at(x, y), gx * gx * gy * gy, 1e-12);
    }
}

}  // namespace
}  // namespace noiseloom
