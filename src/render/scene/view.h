// What the frames of a scene in which the view moves show of an object together.
#pragma once

#include <array>
#include <cstdint>

#include "noiseloom/render/scene.h"

namespace noiseloom::render {

// By how many pixels the view moves over the object in a frame, to the right and downward.
std::array<int, 2> view_step(const Scene& scene);

// The part of a picture's side, and of where it lies in the first frame, that all frames show together.
struct ViewSpan {
  std::int64_t before = 0;
  std::int64_t size = 0;
};
std::array<ViewSpan, 2> window_of(const Scene& scene);

// Pixels of a mesh that all frames show together.
std::int64_t pixels_of_shares(const Scene& scene);

}  // namespace noiseloom::render
