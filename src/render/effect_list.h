// One of these for every effect, each in the file of its effect.
#pragma once

#include "render/effects.h"

namespace noiseloom::render {

extern const EffectCalls integrand_calls;
extern const EffectCalls dither_calls;
extern const EffectCalls transparency_calls;

}  // namespace noiseloom::render
