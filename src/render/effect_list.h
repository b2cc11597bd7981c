// One of these for every effect, each in the file of its effect.
#pragma once

#include "render/effects.h"

namespace noiseloom::render {

extern const EffectCalls integrand_calls;
extern const EffectCalls dither_calls;
extern const EffectCalls transparency_calls;
extern const EffectCalls free_flight_calls;
extern const EffectCalls ray_march_calls;
extern const EffectCalls occlusion_calls;
extern const EffectCalls shadow_calls;

}  // namespace noiseloom::render
