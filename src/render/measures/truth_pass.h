// The pass that makes the truth of every effect, before and after every filter over space, and its bias.
#pragma once

#include <cstdint>
#include <span>

#include "noiseloom/render/passes.h"

namespace noiseloom::render {

void make_truth(Shared& shared);
Counts work_of_truth(const Scene& scene, std::span<const Noise> noises);
std::int64_t bytes_of_truth(const Scene& scene, std::span<const Noise> noises);

}  // namespace noiseloom::render
