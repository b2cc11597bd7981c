// What the rest of the program knows of effects, and how they read noises.
#include "render/jobs/effects.h"

#include "noiseloom/core/error.h"
#include "render/jobs/effect_list.h"

namespace noiseloom::render {

const EffectCalls& calls_of(Effect effect) {
  switch (effect) {
    case Effect::integrand:
      return integrand_calls;
    case Effect::dither:
      return dither_calls;
    case Effect::transparency:
      return transparency_calls;
    case Effect::free_flight:
      return free_flight_calls;
    case Effect::ray_march:
      return ray_march_calls;
    case Effect::occlusion:
      return occlusion_calls;
    case Effect::shadow:
      return shadow_calls;
    case Effect::sky:
      return sky_calls;
    case Effect::convolution:
      return convolution_calls;
    case Effect::sparse:
      break;
  }
  return sparse_calls;
}

int if_numbers(int numbers, const Noise& noise) { return noise.numbers_in_value() > 0 ? numbers : 0; }

std::int64_t values_of_pixel(const Noise& noise, int numbers) {
  return (numbers + noise.channels - 1) / noise.channels;
}

Work work_of_rays(const Scene& scene) { return scene.object.is_mesh() ? Work::mesh_rays : Work::rays; }

Work work_of_reading(const Noise& noise) {
  const NoiseKind kind = noise.spec.kind;
  return has_texture(kind) ? Work::texture_values : Work::computed_values;
}

}  // namespace noiseloom::render
