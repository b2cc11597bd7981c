// How the errors of a row of frames are spread over frequencies of the picture and of time.
#pragma once

#include "noiseloom/image/texture_file.h"
#include "noiseloom/render/result.h"

namespace noiseloom::render {

// Of errors, a slice for each frame. `later_half`: of an average, whose first frames would hide what it comes to.
ErrorSpectrum error_spectrum(const Texture& errors, bool later_half);

}  // namespace noiseloom::render
