#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "noiseloom/core/error.h"
#include "noiseloom/core/math.h"
#include "noiseloom/core/random.h"
#include "noiseloom/files/image_decoder.h"
#include "noiseloom/files/npy.h"
#include "noiseloom/samples/luminance.h"
#include "noiseloom/samples/sample_space.h"
#include "noiseloom/samples/space.h"
#include "support/sanitizers.h"

namespace noiseloom {
namespace {

using testing_support::tried;
using testing_support::under_sanitizers;

constexpr ImageDomain all_domains[] = {ImageDomain::square, ImageDomain::disk, ImageDomain::sphere,
                                       ImageDomain::hemisphere};

std::string name_of(ImageDomain domain) {
  return std::array{"square", "disk", "sphere", "hemisphere"}[static_cast<std::size_t>(domain)];
}

SampleSpec image(ImageDomain onto, std::int64_t height, std::int64_t width, std::vector<float> luminance) {
  SampleSpec spec;
  spec.space = "image";
  spec.file = "picture.npy";
  spec.onto = onto;
  spec.array = std::make_shared<const InputArray>(InputArray{{height, width}, std::move(luminance)});
  return spec;
}

// [0, 1), independent of the library's jitter.
double random_at(std::uint64_t index) {
  const RandomBlock bits = random_block(77, Purpose::subset, 0, 0, index);
  return to_unit_double(bits[0], bits[1]);
}

// Bright spots, slopes, and black parts with edges of all kinds.
SampleSpec rough(ImageDomain onto, int height, int width) {
  std::vector<float> values;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double u = random_at(static_cast<std::uint64_t>(y) * 1000 + static_cast<std::uint64_t>(x));
      const bool black = (x * 5 / width + y * 7 / height) % 3 == 0 || u < 0.2;
      values.push_back(static_cast<float>(black ? 0 : u > 0.97 ? 20 * u : u + 0.3 * x / width));
    }
  }
  return image(onto, height, width, values);
}

double measure_of(ImageDomain onto) {
  switch (onto) {
    case ImageDomain::square:
      return 1;
    case ImageDomain::disk:
      return math::pi;
    case ImageDomain::sphere:
      return 4 * math::pi;
    case ImageDomain::hemisphere:
      return 2 * math::pi;
  }
  return 0;
}

// A point of the space, uniform in its measure: by the textbook's map, not by the library's.
std::array<float, 3> uniform_point(ImageDomain onto, double u, double v) {
  if (onto == ImageDomain::square) return {static_cast<float>(u), static_cast<float>(v), 0};
  if (onto == ImageDomain::disk) {
    const double r = std::sqrt(u);
    return {static_cast<float>(r * std::cos(2 * math::pi * v)), static_cast<float>(r * std::sin(2 * math::pi * v)), 0};
  }
  const double y = onto == ImageDomain::sphere ? 1 - 2 * u : 1 - u;
  const double r = std::sqrt(std::max(0.0, 1 - y * y));
  return {static_cast<float>(r * std::cos(2 * math::pi * v)), static_cast<float>(y),
          static_cast<float>(r * std::sin(2 * math::pi * v))};
}

// The luminance that a point looks at, from the definition of each domain.
double luminance_at(const SampleSpec& spec, const float* p) {
  const double height = static_cast<double>(spec.array->shape[0]);
  const double width = static_cast<double>(spec.array->shape[1]);
  double u = p[0];
  double v = p[1];
  if (spec.onto == ImageDomain::disk) {
    u = 0.5 * (u + 1);
    v = 0.5 * (v + 1);
  } else if (spec.onto != ImageDomain::square) {
    u = std::atan2(static_cast<double>(p[2]), static_cast<double>(p[0])) / (2 * math::pi);
    if (u < 0) u += 1;
    v = std::acos(std::clamp(static_cast<double>(p[1]), -1.0, 1.0)) / math::pi;
  }
  const double x = std::clamp(std::floor(u * width), 0.0, width - 1);
  const double y = std::clamp(std::floor(v * height), 0.0, height - 1);
  return static_cast<double>(
      std::get<SharedValues<float>>(spec.array->values)[static_cast<std::size_t>(y * width + x)]);
}

TEST(ImageDensity, EachStratumHoldsItsOwnSampleWhereThereIsLight) {
  for (const ImageDomain onto : all_domains) {
    for (const auto& [height, width] : {std::pair(1, 1), std::pair(3, 1), std::pair(17, 31), std::pair(64, 128)}) {
      const SampleSpec spec = rough(onto, height, width);
      if (height == 1) const_cast<float&>(std::get<SharedValues<float>>(spec.array->values)[0]) = 1;
      const auto space = space_of(spec);
      const auto channels = static_cast<std::size_t>(space->traits().channels);
      for (const std::int64_t n : {1, 2, 3, 5, 101, under_sanitizers ? 1024 : 128 * 128}) {
        const std::vector<float> list = SampleSource(spec, n, 1, 5).list(SliceIndex(0));
        ASSERT_EQ(list.size(), static_cast<std::size_t>(n) * channels);
        for (std::int64_t id = 0; id < n; ++id) {
          const float* const sample = &list[static_cast<std::size_t>(id) * channels];
          ASSERT_GT(space->density(sample), 0) << name_of(onto) << " " << height << " x " << width << ", id " << id;
          ASSERT_EQ(space->invert(n, sample), id) << name_of(onto) << " " << height << " x " << width << ", n " << n;
        }
      }
    }
  }
}

TEST(ImageDensity, DensityIsTheLuminanceOverItsIntegral) {
  for (const ImageDomain onto : all_domains) {
    const SampleSpec spec = rough(onto, 40, 80);
    const auto space = space_of(spec);
    double integral = 0;
    constexpr int side = 1000;
    double factor = 0;
    for (int i = 0; i < side; ++i) {
      for (int k = 0; k < side; ++k) {
        const auto p = uniform_point(onto, (i + random_at(static_cast<std::uint64_t>(i))) / side, (k + 0.5) / side);
        const double density = space->density(p.data());
        integral += density / (static_cast<double>(side) * side);
        const double luminance = luminance_at(spec, p.data());
        ASSERT_EQ(density > 0, luminance > 0);
        if (luminance > 0 && factor == 0) factor = density / luminance;
        if (luminance > 0) {
          ASSERT_NEAR(density / luminance, factor, 1e-6 * factor) << name_of(onto);
        }
      }
    }
    EXPECT_NEAR(integral * measure_of(onto), 1, 0.02) << name_of(onto);
  }
}

// Chi-square of samples in cells of equal measure whose masses come from a fine grid of points; the odds of passing by
// chance are those of the normal approximation, 5 sigma. Strata make the counts evener than chance, so the upper bound
// alone is asked for; a wrong density of a few percent exceeds it many times.
TEST(ImageDensity, SamplesFollowTheDensity) {
  for (const ImageDomain onto : all_domains) {
    const SampleSpec spec = rough(onto, 16, 32);
    const auto space = space_of(spec);
    const auto channels = static_cast<std::size_t>(space->traits().channels);
    for (const int cells : {64, 1000}) {
      if (under_sanitizers && cells == 1000) continue;
      // Cells by a coordinate and the angle or other coordinate, the same for samples and for the fine points.
      const int columns = cells == 64 ? 8 : 40;
      const int rows = cells / columns;
      const auto cell_of = [&](const float* p) {
        const double a = onto == ImageDomain::square ? p[0] : 0.5 * (static_cast<double>(p[0]) + 1);
        const double b = onto == ImageDomain::square ? p[1] : 0.5 * (static_cast<double>(p[1]) + 1);
        const int x = std::clamp(static_cast<int>(a * columns), 0, columns - 1);
        const int y = std::clamp(static_cast<int>(b * rows), 0, rows - 1);
        return static_cast<std::size_t>(y * columns + x);
      };
      std::vector<double> expected(static_cast<std::size_t>(cells), 0);
      constexpr int side = under_sanitizers ? 500 : 1500;
      for (int i = 0; i < side; ++i) {
        for (int k = 0; k < side; ++k) {
          const auto p = uniform_point(onto, (i + 0.5) / side, (k + 0.5) / side);
          expected[cell_of(p.data())] += space->density(p.data()) * measure_of(onto) / side / side;
        }
      }
      constexpr std::int64_t n = tried(100'003);
      const std::vector<float> list = SampleSource(spec, n, 1, 3).list(SliceIndex(0));
      std::vector<double> found(static_cast<std::size_t>(cells), 0);
      for (std::size_t i = 0; i < list.size(); i += channels) ++found[cell_of(&list[i])];
      double chi = 0;
      int degrees = -1;
      for (std::size_t c = 0; c < expected.size(); ++c) {
        const double mean = expected[c] * static_cast<double>(n);
        if (mean < 10) continue;
        chi += (found[c] - mean) * (found[c] - mean) / mean;
        ++degrees;
      }
      ASSERT_GT(degrees, cells / 5);
      EXPECT_LT(chi, degrees + 5 * std::sqrt(2.0 * degrees)) << name_of(onto) << ", " << cells << " cells";
    }
  }
}

TEST(ImageDensity, WeightedMeansAreIntegralsOverTheSupport) {
  using Integrand = double (*)(double, double, double);
  constexpr Integrand integrands[] = {
      [](double, double, double) { return 1.0; },
      [](double x, double, double) { return x; },
      [](double, double y, double) { return y; },
      [](double x, double y, double) { return x * y; },
      [](double x, double, double) { return x * x; },
      [](double, double y, double) { return std::cos(5 * y); },
      [](double x, double, double) { return x < 0.3 ? 1.0 : 0.0; },
      [](double x, double y, double) { return std::exp(-x * x - 2 * y * y); },
      [](double, double y, double z) { return std::fabs(y) + z; },
      [](double x, double y, double) { return std::sin(9 * x + 4 * y); },
  };
  for (const ImageDomain onto : all_domains) {
    // Bright and dark, but nowhere black: the mean is over the whole space.
    std::vector<float> values;
    for (std::uint64_t i = 0; i < 24 * 48; ++i) values.push_back(static_cast<float>(0.2 + 3 * random_at(i)));
    const SampleSpec spec = image(onto, 24, 48, values);
    const auto space = space_of(spec);
    const auto channels = static_cast<std::size_t>(space->traits().channels);
    constexpr std::int64_t n = tried(1 << 17);
    const std::vector<float> list = SampleSource(spec, n, 1, 11).list(SliceIndex(0));
    for (const Integrand f : integrands) {
      double sum = 0;
      double squares = 0;
      for (std::size_t i = 0; i < list.size(); i += channels) {
        const float* const p = &list[i];
        const double z = channels == 3 ? p[2] : 0;
        const double value = f(p[0], p[1], z) / space->density(p);
        sum += value;
        squares += value * value;
      }
      double exact = 0;
      constexpr int side = under_sanitizers ? 200 : 500;
      for (int i = 0; i < side; ++i) {
        for (int k = 0; k < side; ++k) {
          const auto p = uniform_point(onto, (i + 0.5) / side, (k + 0.5) / side);
          exact += f(p[0], p[1], p[2]) * measure_of(onto) / side / side;
        }
      }
      const double mean = sum / n;
      const double error = std::sqrt((squares / n - mean * mean) / n);  // of independent samples: strata have less
      EXPECT_NEAR(mean, exact, 4 * error + 2e-3) << name_of(onto);
    }
  }
}

TEST(ImageDensity, ASunOfOneTexelGetsItsShareAndNoMore) {
  constexpr int height = 512;
  constexpr int width = 1024;
  std::vector<float> sky(static_cast<std::size_t>(height) * width, 1);
  constexpr std::size_t sun = 100 * width + 700;
  sky[sun] = 1e5;
  for (int x = 0; x < width; ++x) sky[static_cast<std::size_t>(300 * width + x)] = 0;
  const SampleSpec spec = image(ImageDomain::sphere, height, width, sky);
  const auto space = space_of(spec);
  constexpr std::int64_t n = 128 * 128;
  const std::vector<float> list = SampleSource(spec, n, 1, 1).list(SliceIndex(0));
  const auto row_measure = [](int y) {
    return std::cos(math::pi * y / height) - std::cos(math::pi * (y + 1) / height);
  };
  const double share = 1e5 * row_measure(100) / (width * (2 - row_measure(300)) + (1e5 - 1) * row_measure(100));
  int in_sun = 0;
  for (std::size_t i = 0; i < list.size(); i += 3) {
    in_sun += luminance_at(spec, &list[i]) > 2 ? 1 : 0;
    EXPECT_GT(luminance_at(spec, &list[i]), 0);
  }
  EXPECT_NEAR(in_sun, share * n, 2);  // a stratum may lie on either side of the sun's edge
}

TEST(ImageDensity, ConstantImagesAreUniform) {
  for (const ImageDomain onto : all_domains) {
    for (const auto& [height, width] : {std::pair(1, 1), std::pair(5, 9)}) {
      const SampleSpec spec =
          image(onto, height, width, std::vector<float>(static_cast<std::size_t>(height * width), 7));
      const auto space = space_of(spec);
      for (int i = 0; i < 100; ++i) {
        const auto p = uniform_point(onto, random_at(static_cast<std::uint64_t>(i)),
                                     random_at(static_cast<std::uint64_t>(i + 500)));
        EXPECT_NEAR(space->density(p.data()) * measure_of(onto), 1, 1e-9) << name_of(onto);
      }
    }
  }
}

// However large the image, a list does not depend on where rounding puts it.
TEST(ImageDensity, HoldsInFloatOnLargeImagesAndManyStrata) {
  std::vector<float> values(static_cast<std::size_t>(4096) * 4, 0);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = i % 3 == 0 ? 1e-30F : i % 3 == 1 ? 0 : 1e8F;
  for (const ImageDomain onto : all_domains) {
    const SampleSpec spec = image(onto, 4, 4096, values);
    const auto space = space_of(spec);
    const auto channels = static_cast<std::size_t>(space->traits().channels);
    const std::vector<float> list = SampleSource(spec, tried(1 << 18), 1, 2).list(SliceIndex(0));
    for (std::size_t i = 0; i < list.size(); i += channels) ASSERT_GT(space->density(&list[i]), 0) << name_of(onto);
  }
}

TEST(ImageDensity, WhatIsNoDensityIsRefusedByName) {
  const auto refused = [](ImageDomain onto, std::int64_t height, std::int64_t width, std::vector<float> values,
                          const std::string& words) {
    try {
      SampleSource(image(onto, height, width, std::move(values)), 16, 1, 1);
      ADD_FAILURE() << "accepted: " << words;
    } catch (const UserError& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
      EXPECT_EQ(error.faults().front().where, "picture.npy");
    }
  };
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  constexpr float infinity = std::numeric_limits<float>::infinity();
  refused(ImageDomain::square, 2, 3, {0, 0, 0, 0, 0, 0}, "every pixel is black");
  refused(ImageDomain::square, 2, 3, {1, 1, 1, 1, nan, 1}, "pixel 1, 1");
  refused(ImageDomain::square, 2, 3, {1, 1, infinity, 1, 1, 1}, "not finite");
  refused(ImageDomain::square, 2, 3, {1, -1, 1, -2, 1, 1}, "2 of 6 pixels are negative; the first is pixel 1, 0");
  refused(ImageDomain::hemisphere, 2, 2, {0, 0, 1, 1}, "every pixel that lies in the space is black");
  std::vector<float> corners(64 * 64, 0);
  corners.front() = corners.back() = 1;
  refused(ImageDomain::disk, 64, 64, corners, "every pixel that lies in the space is black");
}

TEST(Luminance, WeighsColoursAndDecodesCodes) {
  set_image_decoder([](const std::string& path) {
    const std::int64_t channels = path == "grey.png" ? 1 : 3;
    const std::vector<float> values =
        channels == 1 ? std::vector<float>{0.5F, 1} : std::vector<float>{1, 0, 0, 0, 1, 0};
    return std::make_shared<const InputArray>(InputArray{{1, 2, channels}, values});
  });
  SampleSpec spec;
  spec.space = "image";
  const auto luminance = [&](const std::string& path, ImageEncoding encoding) {
    spec.file = path;
    spec.encoding = encoding;
    const InputArrayPtr light = read_luminance(spec);
    const auto& values = std::get<SharedValues<float>>(light->values);
    return std::vector(values.begin(), values.end());
  };
  EXPECT_EQ(luminance("colour.png", ImageEncoding::linear), (std::vector<float>{0.2126F, 0.7152F}));
  EXPECT_EQ(luminance("grey.png", ImageEncoding::unstated), (std::vector<float>{0.5F, 1}));
  const std::vector<float> light = luminance("grey.png", ImageEncoding::srgb);
  EXPECT_NEAR(light[0], 0.21404, 1e-5);  // of the standard's own table
  EXPECT_EQ(light[1], 1);
  set_image_decoder({});
  EXPECT_THROW(luminance("grey.png", ImageEncoding::linear), UserError);
}

}  // namespace
}  // namespace noiseloom
