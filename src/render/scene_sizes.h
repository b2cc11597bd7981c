// How much there is to do in a scene.
#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>

#include "noiseloom/render/scene.h"
#include "render/effects.h"

namespace noiseloom::render {

inline std::int64_t pixels_of(const Scene& scene) { return std::int64_t{scene.width} * scene.height; }

inline std::int64_t channels_of_all(const Scene& scene) {
  std::int64_t channels = 0;
  for (const Effect effect : effects_of(scene)) channels += calls_of(effect).channels(scene);
  return channels;
}

inline int most_channels_of(const Scene& scene) {
  int most = 0;
  for (const Effect effect : effects_of(scene)) most = std::max(most, calls_of(effect).channels(scene));
  return most;
}

// Of all filters over space, for a pixel.
inline std::int64_t taps_of_all(const Scene& scene) {
  std::int64_t taps = 0;
  for (const SpaceFilterSpec& filter : scene.space) {
    const std::int64_t across = std::ssize(taps_of(filter));
    taps += filter.edges.empty() ? 2 * across : across * across;
  }
  return taps;
}

inline std::int64_t bytes_of_image(const Scene& scene) { return 4 * pixels_of(scene) * most_channels_of(scene); }

inline std::int64_t times_of(const Scene& scene) { return 1 + static_cast<std::int64_t>(scene.time.kernels.size()); }

}  // namespace noiseloom::render
