// How sample values become the numbers of an image, and back.
//
//   integers of n bits:  b = floor(2^n u), clamped;  u = (b + 0.5) / 2^n
//   u = (v - lo) / (hi - lo)
//
// lo..hi is 0..1 for scalars and vectors in the unit cube and -1..1 for directions and disks (u = 0.5 + 0.5 v).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "noiseloom/samples/space.h"

namespace noiseloom {

// The range that the values of a sample space fill; none for spaces without bounds (gauss) or known ones (file).
std::optional<ValueRange> natural_range(const SampleSpec& samples);

// "LO:HI" to a range. Throws UserError unless both are finite numbers and lo < hi.
ValueRange parse_range(const std::string& text);

// The number as a person writes it: shortest digits that read back to the same double.
std::string shortest_number(double value);

inline double to_unit(const ValueRange& range, double value) { return (value - range.lo) / (range.hi - range.lo); }
inline double from_unit(const ValueRange& range, double u) { return range.lo + (range.hi - range.lo) * u; }

// floor(2^bits u), clamped to what fits; NaN gives 0. Requires bits <= 16.
inline std::uint16_t quantise(double u, int bits) {
  const double levels = static_cast<double>(1 << bits);
  const double scaled = u * levels;
  if (!(scaled >= 0)) return 0;
  return static_cast<std::uint16_t>(scaled >= levels ? levels - 1 : scaled);
}
// The same for 32 bits.
inline std::uint32_t quantise_32(double u) {
  const double scaled = u * 0x1p32;
  if (!(scaled >= 0)) return 0;
  return scaled >= 0x1p32 ? 0xFFFFFFFF : static_cast<std::uint32_t>(scaled);
}
// (b + 0.5) / 2^bits: the middle of the step.
inline double dequantise(std::uint16_t b, int bits) { return (b + 0.5) / static_cast<double>(1 << bits); }

// What one channel of an image pixel holds: a channel of the sample (>= 0), or one of these.
inline constexpr int zero_channel = -1;     // zero
inline constexpr int density_channel = -2;  // the density of the sample over the largest density
inline constexpr int opaque_channel = -3;   // the largest number, as alpha

struct PixelLayout {
  std::vector<int> source;
  std::vector<std::string> names;
  int alpha = -1;  // index of the alpha channel, -1: none
};

// The channels of an image for samples of `channels` channels, as the containers hold them:
//   png_pixel    1: Y    2: R G 0    3: RGB    4: RGBA
//   tiff_pixel   the same, and more than 4: c0, c1, ...
//   exr_pixel    1: Y    2: R G      3: RGB    4: RGBA    more: c0, c1, ...
//   rgb_pixel    RGB always: a scalar three times, 2: R G 0
//   plain_pixel  the channels of the sample, without names
//   rgba_pixel   RGBA always, opaque: 2: R G 0 A
//   texture_pixel  1: R    2: R G    3 and 4: RGBA, opaque where the sample has three
// With density, the channel A holds it, which requires at most 3 channels: png and tiff are then always RGBA (a scalar
// three times), exr has one channel more, texture_pixel is RGBA. rgb_pixel, plain_pixel and rgba_pixel hold none.
PixelLayout png_pixel(int channels, bool with_density);
PixelLayout tiff_pixel(int channels, bool with_density);
PixelLayout exr_pixel(int channels, bool with_density);
PixelLayout rgb_pixel(int channels, bool with_density);
PixelLayout plain_pixel(int channels, bool with_density);
PixelLayout rgba_pixel(int channels, bool with_density);
PixelLayout texture_pixel(int channels, bool with_density);
// R, RG, RGB or RGBA for samples of fewer channels or as many: a scalar stands in all of R, G and B of three and four,
// what a sample has not is zero, and alpha is opaque.
PixelLayout pixel_of_size(int size, int channels);

}  // namespace noiseloom
