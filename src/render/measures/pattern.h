// How well an error follows a mask.
#pragma once

#include <string>
#include <vector>

#include "render/world/image.h"

namespace noiseloom::render {

struct Job;

// 1 - the rank correlation of the brightness of the picture with the mask, the mean over windows of 8 x 8 pixels in
// which both vary, so that what is smooth in the picture does not count; 1 where there is no such window. 0 where the
// picture is in the mask's order, 2 where it is in the opposite one.
double pattern_error(const Image& image, int channels, const std::vector<float>& mask);

// The mask of the frame: that which the noise's seeds follow, or else those of the first noise that has seeds.
std::vector<float> mask_of_job(const Job& job);

}  // namespace noiseloom::render
