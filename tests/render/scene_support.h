// Scenes in text, and noises in memory, for tests.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "noiseloom/core/extents.h"
#include "noiseloom/core/parallel.h"
#include "noiseloom/render/result.h"

namespace noiseloom::render {

inline Scene scene_of(const std::string& text) { return parse_scene(text, "test.toml", ""); }

// A texture of n = width * height * slices scalars, the value (k + 1/2) / n at a place that a permutation of the cells
// gives: every value once, in no plain order.
inline Noise mask(int width, int height, int slices, const std::string& name = "mask") {
  Texture texture = make_texture(Extents({width, height, slices}), 1);
  const std::size_t n = texture.values.size();
  for (std::size_t i = 0; i < n; ++i)
    texture.values[i] = static_cast<float>((static_cast<double>(i * 7919 % n) + 0.5) / static_cast<double>(n));
  NoiseSpec spec{.kind = NoiseKind::file, .name = name};
  const Extents extents = texture.extents;
  return {.spec = spec, .texture = std::make_shared<const Texture>(std::move(texture)), .extents = extents};
}

inline std::vector<Noise> noises_of(const Scene& scene) {
  std::vector<Noise> noises;
  for (const NoiseSpec& spec : scene.noises)
    noises.push_back(has_texture(spec.kind) ? mask(13, 11, 5, spec.name) : open_noise(spec, "", nullptr));
  return noises;
}

inline Result rendered(const Scene& scene, int threads = 2) {
  ThreadPool pool(threads);
  return render(scene, noises_of(scene), pool);
}
inline Result rendered(const std::string& text, int threads = 2) { return rendered(scene_of(text), threads); }

}  // namespace noiseloom::render
