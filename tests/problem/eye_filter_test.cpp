#include "problem/filters/eye_filter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "noiseloom/core/math.h"
#include "noiseloom/problem/footprint.h"

namespace noiseloom {
namespace {

// Kelly's surface as it is printed, in other words than the library's.
double printed(double hertz, double cycles_per_degree) {
  const double v = std::fmax(hertz / cycles_per_degree, 0.15);
  const double a = 2 * 3.14159265358979 * cycles_per_degree;
  return (6.1 + 7.3 * std::pow(std::fabs(std::log10(v / 3)), 3)) * v * a * a * std::exp(-2 * a * (v + 2) / 45.9);
}

TEST(EyeFilter, RespondsAsKellysSurfaceAtThreeEighthsOfACycleAPixel) {
  for (const double pixels : {10.0, 30.0, 60.0}) {
    for (const double hertz : {0.5, 5.0, 11.0, 25.0}) {
      EXPECT_NEAR(eye_response(hertz, 60, pixels) / eye_response(2, 60, pixels),
                  printed(hertz, 0.375 * pixels) / printed(2, 0.375 * pixels), 1e-9);
    }
  }
}

TEST(EyeFilter, TapsHaveTheResponseAsTheirTransform) {
  for (const double frames : {24.0, 60.0, 120.0}) {
    for (const double pixels : {8.0, 30.0, 60.0}) {
      const std::vector<double> taps = eye_taps(frames, pixels);
      ASSERT_EQ(taps.size() % 2, 1U);
      const auto middle = static_cast<std::ptrdiff_t>(taps.size() / 2);
      for (int k = 0; k <= 16; ++k) {
        double transform = 0;
        for (std::ptrdiff_t i = 0; i < std::ssize(taps); ++i) {
          transform += taps[static_cast<std::size_t>(i)] * math::cos_2pi(k / 32.0 * static_cast<double>(i - middle));
        }
        // The taps that were cut are some tens of 5/1000 of the middle one, of both signs.
        EXPECT_NEAR(transform, eye_response(frames * k / 32, frames, pixels), 0.05) << frames << ", " << pixels;
      }
    }
  }
}

// At 60 frames a second and 40 pixels a degree, as flicker is seen in fine patterns: up to some ten cycles a second.
TEST(EyeFilter, LetsSlowFlickerThroughAndFastFlickerNot) {
  EXPECT_GT(eye_response(1, 60, 40), 0.8);
  EXPECT_GT(eye_response(5, 60, 40), 0.3);
  EXPECT_LT(eye_response(25, 60, 40), 0.05);
  // Coarse patterns flicker visibly up to higher frequencies, and least of all when they stand still.
  EXPECT_GT(eye_response(12, 60, 5), 2 * eye_response(12, 60, 40));
  EXPECT_LT(eye_response(0, 60, 5), 0.9);
}

TEST(EyeFilter, MakesAFootprintOverTime) {
  FilterSpec filter{Combine::product, {{{2}, {}, 0}}};
  filter.groups[0].kernel.kind = KernelKind::eye;
  const Footprint footprint(Extents({4, 4, 64}), filter);
  EXPECT_TRUE(footprint.couples_slices());
  EXPECT_GT(footprint.weight_zero(), 0);
}

}  // namespace
}  // namespace noiseloom
