// The colour of an image file as bare numbers, for densities.
#pragma once

#include <string>

#include "noiseloom/files/input_array.h"

namespace noiseloom {

// float [height, width, channels]: red, green and blue, or grey alone. Integers over their largest value (255, 65535),
// floats as they are; alpha is left out, and colour is not multiplied by it. No gamma. Throws UserError where the file
// is no image that is read here, has several images, covers a part of its picture only, or has other channels than
// these. This is what set_image_decoder() (files/image_decoder.h) is given.
InputArrayPtr read_colour(const std::string& path);

}  // namespace noiseloom
