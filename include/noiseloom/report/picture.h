// Small pictures for people: slices, strips of slices, spectra. 8 bit RGB, [y][x][channel].
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "noiseloom/image/encoding.h"
#include "noiseloom/image/texture_file.h"
#include "noiseloom/measure/spectrum.h"

namespace noiseloom {

struct Picture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;
};

// The range to show values in: that of the sample space, else from the least to the largest value.
ValueRange shown_range(const TextureFile& file);

// One slice: a scalar grey, two channels red and green, more than three the first three.
Picture slice_picture(const Texture& texture, const ValueRange& range, SliceIndex slice);

// Power as grey: sqrt(P / 2), so black is none, white noise light grey and white twice its power. Along an axis with
// more than `most_pixels` frequencies, neighbours are averaged.
Picture spectrum_picture(const PlaneSpectrum& spectrum, int most_pixels);

// The corner at (0, 0) of at most that size.
Picture cropped(const Picture& picture, int width, int height);

// Every pixel as across x down pixels.
Picture enlarged(const Picture& picture, int across, int down);
// The whole number >= 1 by which `length` pixels fill `size` best without passing it.
int factor_to_fill(int length, int size);

// Writes an 8 bit RGB PNG; the file must not exist. Throws EnvironmentError.
void write_picture(const std::string& path, const Picture& picture, const std::string& description);

}  // namespace noiseloom
