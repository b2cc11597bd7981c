// What a rendering leaves in its folder.
#pragma once

#include <string>
#include <vector>

#include "noiseloom/files/output_files.h"
#include "noiseloom/render/result.h"

namespace noiseloom::render {

// Adds to `output`, in `folder`:
//   results.csv              errors of the last frame
//   curves.csv               of every frame, with the output "curves"
//   spectra.csv              of the error, with the output "spectra"
//   plan.json                passes: on or off, why, and their work as predicted and as counted
//   pictures/EFFECT_truth.png, EFFECT_NOISE_STAGE.png, EFFECT_NOISE_STAGE_error.png    with the output "images"
// Errors are shown around mid grey; for all noises of an effect and a stage, white and black are four times the largest
// root mean square among them.
void add_outputs(const Scene& scene, const Result& result, const std::string& folder, OutputFiles& output);

}  // namespace noiseloom::render
