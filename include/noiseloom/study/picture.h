// Small pictures for people: slices, strips of slices, spectra. 8 bit RGB, [y][x][channel].
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "noiseloom/study/encoding.h"
#include "noiseloom/study/spectrum.h"
#include "noiseloom/study/texture_file.h"

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

// Power as grey: sqrt(P / 2), so black is none, white noise light grey and white twice its power.
Picture spectrum_picture(const PlaneSpectrum& spectrum);

// Every pixel as factor x factor pixels.
Picture enlarged(const Picture& picture, int factor);
// The whole number >= 1 by which a picture fills `size` pixels best without passing it.
int factor_to_fill(const Picture& picture, int size);
// Pictures of equal height, white columns of `gap` pixels between them.
Picture side_by_side(const std::vector<Picture>& pictures, int gap);

// Writes an 8 bit RGB PNG; the file must not exist. Throws EnvironmentError.
void write_picture(const std::string& path, const Picture& picture, const std::string& description);

}  // namespace noiseloom
