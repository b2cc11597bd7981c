// Space-filling curves: one number for a point of the unit cube, near numbers for near points. They make vectors of
// constructed scalars: the pixel of place r gets the r-th sample along the curve.
#pragma once

#include <cstdint>
#include <vector>

#include "noiseloom/samples/spec.h"

namespace noiseloom {

// The place of a point of [0, 1)^dimensions along a curve through a grid of 2^(64 / dimensions) cells each way (2^24 at
// most, which is what float32 tells apart). Pure. 2 <= dimensions <= 4; not Curve::none.
std::uint64_t curve_place(Curve curve, int dimensions, const float* point);

// The samples of a list, interleaved, in the order of their places; those in one cell as they were.
std::vector<float> along_curve(Curve curve, int channels, const std::vector<float>& list);

}  // namespace noiseloom
