// The page of a rendering: what noises are worth in a scene, in sentences, pictures, curves and tables.
#pragma once

#include <string>
#include <vector>

#include "noiseloom/files/output_files.h"
#include "noiseloom/render/result.h"
#include "noiseloom/report/report.h"

namespace noiseloom {

// What a person would say of an effect: how many times fewer samples each noise needs than white noise, and than the
// noise that comes next, for the same error after a stage. Errors of averages fall as 1 / sqrt(samples), so that this
// is the square of how errors compare.
std::string sample_sentence(const render::Result& result, std::size_t effect, std::size_t stage);

// Adds to `output`, in `folder`: report.html, and page/*.png, the pictures that it shows. `scene_text`: the scene as a
// file would have it.
void add_render_report(const render::Scene& scene, const render::Result& result,
                       const std::vector<render::ExpectationResult>& expectations, const std::string& scene_text,
                       const ReportOrigin& origin, const std::string& folder, OutputFiles& output);

}  // namespace noiseloom
