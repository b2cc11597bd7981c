// Which pixel of a texture a shader reads: the texture tiles the picture and, slice after slice, the frames.
//
//   the pixel read = (pixel + offset(value) + offset of the round) mod size, in slice frame mod slices
//
// Several values in one frame are read at the offsets of the R2 sequence [Roberts18], as far from each other as may be,
// where a texture is uncorrelated; or from the slices that follow, where it is progressive. When all slices have been
// used (a round), the whole texture moves on: over width * height rounds to every place once. Integers alone, so that a
// shader computes the same (README, "In a shader").
#pragma once

#include <cstdint>

#include "noiseloom/core/extents.h"

namespace noiseloom {

enum class ValuesFrom {
  offsets,  // one slice, at the R2 offsets
  slices,   // the slices that follow, at one place: frame f of k values reads slices f k to f k + k - 1
};

struct TextureRead {
  std::int64_t width = 1;  // of the texture; 1 to 65536
  std::int64_t height = 1;
  std::int32_t num_slices = 1;
  int values = 1;  // that a pixel reads in a frame
  ValuesFrom from = ValuesFrom::offsets;

  struct Place {
    std::int64_t dx = 0;  // to add to the pixel, 0 <= dx < width
    std::int64_t dy = 0;
    SliceIndex slice;
  };
  // frame >= 0; 0 <= value < values.
  Place place(std::int64_t frame, int value) const;
};

// How far a round moves along an axis: about 0.755 of its size, and without a common divisor.
std::int64_t round_step(std::int64_t size);

}  // namespace noiseloom
