// One of these for every effect, each in the file of its effect.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "render/jobs/effects.h"

namespace noiseloom::render {

extern const EffectCalls integrand_calls;
extern const EffectCalls dither_calls;
extern const EffectCalls transparency_calls;
extern const EffectCalls free_flight_calls;
extern const EffectCalls ray_march_calls;
extern const EffectCalls occlusion_calls;
extern const EffectCalls shadow_calls;
extern const EffectCalls sky_calls;
extern const EffectCalls convolution_calls;
extern const EffectCalls sparse_calls;

// The passes that make what they need.
void make_kernel_pass(Shared& shared);
void make_importance_pass(Shared& shared);
void make_sky_pass(Shared& shared);
std::int64_t bytes_of_kernel(const Scene& scene, std::span<const Noise> noises);
std::int64_t bytes_of_sky(const Scene& scene, std::span<const Noise> noises);
std::string off_without_turning_sky(const Scene& scene);
void make_sky_truths(Shared& shared);
Counts work_of_sky_truths(const Scene& scene, std::span<const Noise> noises);
std::int64_t bytes_of_sky_truths(const Scene& scene, std::span<const Noise> noises);

}  // namespace noiseloom::render
