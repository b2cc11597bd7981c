// Which frames of a scene are worth anything.
#pragma once

#include <cstdint>

#include "noiseloom/render/scene.h"

namespace noiseloom::render {

// Errors are measured there (frames count from 0): everywhere for curves, else in the last frame and where an
// expectation asks for them.
bool is_measured(const Scene& scene, std::int64_t frame);
// Measured, or part of an average that is, or what seeds are moved by.
bool is_rendered(const Scene& scene, std::int64_t frame);
std::int64_t num_measured(const Scene& scene);
std::int64_t num_rendered(const Scene& scene);

}  // namespace noiseloom::render
