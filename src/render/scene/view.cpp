#include "render/scene/view.h"

#include <cmath>
#include <cstdlib>

namespace noiseloom::render {
namespace {

ViewSpan span_of(int size, int step, int frames) {
  const std::int64_t way = std::int64_t{step} * (frames - 1);
  return {way < 0 ? -way : 0, size + std::abs(way)};
}

}  // namespace

std::array<int, 2> view_step(const Scene& scene) {
  const auto part = [&](std::size_t axis) {
    return static_cast<int>(std::lround(scene.motion.camera[axis] - scene.motion.sphere[axis]));
  };
  return {part(0), part(1)};
}

std::array<ViewSpan, 2> window_of(const Scene& scene) {
  if (!scene.motion.on) return {ViewSpan{0, scene.width}, ViewSpan{0, scene.height}};
  const std::array<int, 2> step = view_step(scene);
  return {span_of(scene.width, step[0], scene.frames), span_of(scene.height, step[1], scene.frames)};
}

std::int64_t pixels_of_shares(const Scene& scene) {
  const std::array<ViewSpan, 2> window = window_of(scene);
  return window[0].size * window[1].size;
}

}  // namespace noiseloom::render
