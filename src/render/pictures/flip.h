// The difference that is seen when two pictures are shown in turns: FLIP [Andersson20] of pictures of 0 to 1.
#pragma once

#include "render/world/image.h"

namespace noiseloom::render {

// The mean over all pixels, 0 to 1. Values are codes of sRGB, as a screen is given them, cut off at 0 and 1; one
// channel is grey. `pixels_per_degree`: of the viewer; 67 is a screen of 4K, 0.7 m wide, at 0.7 m.
double flip_error(const Image& a, const Image& b, int channels, Border border, Rows rows,
                  double pixels_per_degree = 67);

}  // namespace noiseloom::render
