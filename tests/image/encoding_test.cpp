// Values to stored numbers and back.
#include "noiseloom/image/encoding.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

using testing::ElementsAre;

TEST(Quantise, IsTheFloorOfTheScaledValue) {
  for (const int bits : {8, 16}) {
    const double levels = std::ldexp(1.0, bits);
    for (int i = 0; i < 1009; ++i) {
      const double u = i / 1009.0;
      EXPECT_EQ(quantise(u, bits), static_cast<int>(std::floor(levels * u))) << u;
    }
    EXPECT_EQ(quantise(1.0, bits), levels - 1);
    EXPECT_EQ(quantise(std::nextafter(1.0, 0.0), bits), levels - 1);
    EXPECT_EQ(quantise(1e30, bits), levels - 1);
    EXPECT_EQ(quantise(-0.25, bits), 0);
    EXPECT_EQ(quantise(std::numeric_limits<double>::quiet_NaN(), bits), 0);
  }
}

TEST(Quantise, IsUndoneByTheMiddleOfTheStep) {
  for (int b = 0; b < 65536; ++b) {
    EXPECT_EQ(quantise(dequantise(static_cast<std::uint16_t>(b), 16), 16), b);
    if (b < 256) {
      EXPECT_DOUBLE_EQ(dequantise(static_cast<std::uint16_t>(b), 8), (b + 0.5) / 256);
    }
  }
}

TEST(ValueRange, StoresDirectionsAsHalfPlusHalf) {
  SampleSpec samples;
  samples.kind = SampleKind::sphere;
  const ValueRange range = *natural_range(samples);
  for (const double v : {-1.0, -0.3, 0.0, 0.7, 1.0}) {
    EXPECT_DOUBLE_EQ(to_unit(range, v), 0.5 + 0.5 * v);
    EXPECT_DOUBLE_EQ(from_unit(range, to_unit(range, v)), v);
  }
}

TEST(ValueRange, IsKnownExceptForGaussAndFiles) {
  const auto range_of = [](SampleKind kind) {
    SampleSpec samples;
    samples.kind = kind;
    return natural_range(samples);
  };
  for (const SampleKind kind : {SampleKind::uniform, SampleKind::tent, SampleKind::circle, SampleKind::vector})
    EXPECT_EQ(range_of(kind), (ValueRange{0, 1}));
  for (const SampleKind kind :
       {SampleKind::sphere, SampleKind::hemisphere, SampleKind::hemisphere_cosine, SampleKind::disk})
    EXPECT_EQ(range_of(kind), (ValueRange{-1, 1}));
  EXPECT_FALSE(range_of(SampleKind::gauss));
  EXPECT_FALSE(range_of(SampleKind::file));
}

TEST(ValueRange, IsReadFromTwoNumbers) {
  EXPECT_EQ(parse_range("-4:4.5"), (ValueRange{-4, 4.5}));
  for (const char* const text : {"", "1", "1:", ":1", "1:1", "2:1", "a:b", "0:inf", "nan:1", "0:1:2", "0:1 "})
    EXPECT_THROW(parse_range(text), UserError) << text;
}

TEST(PixelLayout, FillsTheChannelsThatTheFormatHas) {
  EXPECT_THAT(png_pixel(1, false).source, ElementsAre(0));
  EXPECT_THAT(png_pixel(2, false).source, ElementsAre(0, 1, zero_channel));
  EXPECT_THAT(tiff_pixel(3, false).source, ElementsAre(0, 1, 2));
  EXPECT_EQ(png_pixel(4, false).alpha, 3);
  EXPECT_THAT(exr_pixel(2, false).source, ElementsAre(0, 1));
  EXPECT_THAT(exr_pixel(6, false).names, ElementsAre("c0", "c1", "c2", "c3", "c4", "c5"));
  EXPECT_THAT(rgb_pixel(1, false).source, ElementsAre(0, 0, 0));
  EXPECT_THAT(rgb_pixel(2, false).source, ElementsAre(0, 1, zero_channel));
  EXPECT_THAT(rgba_pixel(2, false).source, ElementsAre(0, 1, zero_channel, opaque_channel));
  EXPECT_EQ(rgba_pixel(3, false).alpha, 3);
}

TEST(PixelLayout, PutsTheDensityIntoAlpha) {
  EXPECT_THAT(png_pixel(1, true).source, ElementsAre(0, 0, 0, density_channel));
  EXPECT_THAT(tiff_pixel(2, true).source, ElementsAre(0, 1, zero_channel, density_channel));
  const PixelLayout exr = exr_pixel(1, true);
  EXPECT_THAT(exr.source, ElementsAre(0, density_channel));
  EXPECT_EQ(exr.alpha, 1);
}

}  // namespace
}  // namespace noiseloom
