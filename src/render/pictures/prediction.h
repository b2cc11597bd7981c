// What the score of a texture promises: its error over that of white noise after the filters of a stage, sqrt(R)
// (problem/score.h), for an integral that is alike in neighbouring pixels and frames.
#pragma once

#include <optional>
#include <vector>

#include "noiseloom/core/parallel.h"
#include "noiseloom/render/noise.h"
#include "noiseloom/render/scene.h"

namespace noiseloom::render {

// For each stage; nothing where there is no texture, or a filter over time and a texture of no or several slice axes.
// An average over time is taken as it is after many frames; of several numbers in a value, the distance between values
// is meant, and edges are left out. Throws UserError where all values of the texture are equal.
std::vector<std::optional<double>> predicted_ratios(const Noise& noise, const Scene& scene,
                                                    const std::vector<Stage>& stages, ThreadPool& pool);

}  // namespace noiseloom::render
