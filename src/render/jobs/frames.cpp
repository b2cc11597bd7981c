#include "render/jobs/frames.h"

#include <algorithm>

#include "render/jobs/seeds.h"

namespace noiseloom::render {

bool is_measured(const Scene& scene, std::int64_t frame) {
  if (frame == scene.frames - 1 || scene.puts_out("curves")) return true;
  return std::any_of(scene.expects.begin(), scene.expects.end(),
                     [&](const ExpectSpec& expect) { return expect.frame == frame + 1; });
}

bool is_rendered(const Scene& scene, std::int64_t frame) {
  return !scene.time.kernels.empty() || has_seeds(scene) || is_measured(scene, frame);
}

std::int64_t num_measured(const Scene& scene) {
  std::int64_t count = 0;
  for (std::int64_t frame = 0; frame < scene.frames; ++frame) count += is_measured(scene, frame) ? 1 : 0;
  return count;
}

std::int64_t num_rendered(const Scene& scene) {
  return scene.time.kernels.empty() && !has_seeds(scene) ? num_measured(scene) : scene.frames;
}

}  // namespace noiseloom::render
