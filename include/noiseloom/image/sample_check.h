// Whether values are samples of the space that they are said to be of.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "noiseloom/image/texture_file.h"
#include "noiseloom/problem/spec.h"

namespace noiseloom {

// Throws UserError naming the first sample that lies outside the space, how many do, and what they may be instead
// (degrees, radians, -1..1). `step`: between neighbouring values that the file could hold; lengths may be off by as
// much as rounding to it can make them, and by 0.001.
void check_in_space(const Texture& texture, const SampleSpec& samples, double step, const std::string& name);

// How many samples lie outside the space, by the same rule.
std::int64_t count_outside(const Texture& texture, const SampleSpec& samples, double step);
// What samples of the space are, in words: "unit vectors".
std::string support_text(const SampleSpec& samples);

// True where one sample, as floats give it, may lie in the space: as its values, or coded as 0..1.
bool may_be_sample(const SampleSpec& samples, std::span<const float> sample);

}  // namespace noiseloom
