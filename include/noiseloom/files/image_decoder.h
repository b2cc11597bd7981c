// How a program that links no image library comes to the pixels of an image.
//
// Only one program reads images (layers.txt). What needs their numbers asks here, and each program says at its start
// how that is answered: with the library itself, or by asking the other program. A program that said nothing reads
// none.
#pragma once

#include <functional>
#include <string>

#include "noiseloom/files/input_array.h"

namespace noiseloom {

// The colour of an image file as float [height, width, channels], one channel (grey) or three (red, green, blue):
// integers over their largest value, floats as they are, alpha left out. Throws UserError where the file is missing, no
// image, or holds several or none of these.
using ImageDecoder = std::function<InputArrayPtr(const std::string& path)>;

// For the whole process; before anything is read.
void set_image_decoder(ImageDecoder decoder);
// Throws UserError as the decoder does, and where none was set.
InputArrayPtr decode_image(const std::string& path);

}  // namespace noiseloom
