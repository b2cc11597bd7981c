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
using testing::HasSubstr;

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

std::optional<PixelLayout> layout_of(ImageFormat format, int channels, bool with_density = false) {
  std::string why;
  return pixel_layout(format, channels, with_density, why);
}

TEST(PixelLayout, FillsTheChannelsThatTheFormatHas) {
  EXPECT_THAT(layout_of(ImageFormat::png, 1)->source, ElementsAre(0));
  EXPECT_THAT(layout_of(ImageFormat::png, 2)->source, ElementsAre(0, 1, zero_channel));
  EXPECT_THAT(layout_of(ImageFormat::tiff, 3)->source, ElementsAre(0, 1, 2));
  EXPECT_EQ(layout_of(ImageFormat::png, 4)->alpha, 3);
  EXPECT_THAT(layout_of(ImageFormat::exr, 2)->source, ElementsAre(0, 1));
  EXPECT_THAT(layout_of(ImageFormat::exr, 6)->names, ElementsAre("c0", "c1", "c2", "c3", "c4", "c5"));
  EXPECT_THAT(layout_of(ImageFormat::hdr, 1)->source, ElementsAre(0, 0, 0));
  EXPECT_THAT(layout_of(ImageFormat::hdr, 2)->source, ElementsAre(0, 1, zero_channel));
}

TEST(PixelLayout, PutsTheDensityIntoAlpha) {
  EXPECT_THAT(layout_of(ImageFormat::png, 1, true)->source, ElementsAre(0, 0, 0, density_channel));
  EXPECT_THAT(layout_of(ImageFormat::png, 2, true)->source, ElementsAre(0, 1, zero_channel, density_channel));
  const auto exr = layout_of(ImageFormat::exr, 1, true);
  EXPECT_THAT(exr->source, ElementsAre(0, density_channel));
  EXPECT_EQ(exr->alpha, 1);
}

TEST(PixelLayout, SaysWhatHoldsSamplesThatDoNotFit) {
  std::string why;
  EXPECT_FALSE(pixel_layout(ImageFormat::png, 5, false, why));
  EXPECT_THAT(why, HasSubstr("accepted for them: exr, tiff, npy, raw"));
  EXPECT_FALSE(pixel_layout(ImageFormat::hdr, 4, false, why));
  EXPECT_THAT(why, HasSubstr("the samples have 4"));
  EXPECT_FALSE(pixel_layout(ImageFormat::png, 4, true, why));
  EXPECT_FALSE(pixel_layout(ImageFormat::hdr, 3, true, why));
  EXPECT_THAT(why, HasSubstr("no alpha"));
}

}  // namespace
}  // namespace noiseloom
