// How much there is to do in a scene.
#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>

#include "noiseloom/render/scene.h"
#include "render/jobs/effects.h"
#include "render/pictures/a_trous.h"

namespace noiseloom::render {

inline std::int64_t pixels_of(const Scene& scene) { return std::int64_t{scene.width} * scene.height; }

// Planes of a picture of the effect: its channels, twice where the truth changes with the frame (job.h).
inline std::int64_t planes_of(const Scene& scene, Effect effect) {
  return calls_of(effect).channels(scene) * (truth_changes_with_frame(scene, effect) ? 2 : 1);
}

inline std::int64_t channels_of_all(const Scene& scene) {
  std::int64_t channels = 0;
  for (const Effect effect : effects_of(scene)) channels += calls_of(effect).channels(scene);
  return channels;
}

inline std::int64_t planes_of_all(const Scene& scene) {
  std::int64_t planes = 0;
  for (const Effect effect : effects_of(scene)) planes += planes_of(scene, effect);
  return planes;
}

inline bool is_linear(const SpaceFilterSpec& filter) { return filter.kernel != SpaceKernel::a_trous; }

inline bool is_guided_by_variance(const Scene& scene) {
  return std::any_of(scene.space.begin(), scene.space.end(), [](const auto& filter) { return !is_linear(filter); });
}

// Of a linear filter over space, for a pixel of each plane.
inline std::int64_t taps_of_filter(const SpaceFilterSpec& filter) {
  const std::int64_t across = std::ssize(taps_of(filter));
  return filter.edges.empty() ? 2 * across : across * across;
}
// Of all filters over space, over a picture of so many planes.
inline void count_taps(const Scene& scene, std::int64_t planes, std::int64_t pictures, Counts& counts) {
  for (const SpaceFilterSpec& filter : scene.space) {
    const bool linear = is_linear(filter);
    count_of(counts, linear ? Work::taps : Work::guided_taps) +=
        pixels_of(scene) * pictures * (linear ? taps_of_filter(filter) * planes : a_trous_taps(filter));
  }
}

// A picture of the effect that has most planes.
inline std::int64_t bytes_of_image(const Scene& scene) {
  std::int64_t most = 0;
  for (const Effect effect : effects_of(scene)) most = std::max(most, planes_of(scene, effect));
  return 4 * pixels_of(scene) * most;
}

inline std::int64_t times_of(const Scene& scene) { return 1 + static_cast<std::int64_t>(scene.time.kernels.size()); }

}  // namespace noiseloom::render
