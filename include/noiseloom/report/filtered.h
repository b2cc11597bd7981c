// What a filter leaves of the error that a texture makes: a picture of the relative error R for one integrand.
//
// The integrand is a step at the median of the first channel: each pixel's estimate is 0 or 1, where the truth is 1/2.
// The filter acts inside the slice, by its gain sqrt(transform of the overlap).
#pragma once

#include <vector>

#include "noiseloom/image/texture_file.h"
#include "noiseloom/problem/footprint.h"
#include "noiseloom/report/picture.h"

namespace noiseloom {

struct FilteredError {
  Picture before;       // the estimates, black and white
  Picture texture;      // their error after the filter around mid grey, and
  Picture white_noise;  // the same for the same estimates in random order; both with the same contrast
  double ratio = 1;     // mean squared error of the texture over that of white noise, after the filter
};

FilteredError filtered_error(const Texture& texture, SliceIndex slice, const Footprint& footprint);

}  // namespace noiseloom
