// Passes that make what is seen: volumes, surfaces, kernels, skies.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "noiseloom/render/noise.h"
#include "noiseloom/render/passes.h"
#include "noiseloom/render/scene.h"

namespace noiseloom::render {

inline constexpr const char* applies = "";

std::string off_without_volume(const Scene& scene);
std::string off_without_surfaces(const Scene& scene);
// Filters whose weights are those of fixed edges.
bool has_fixed_edges(const Scene& scene);

void trace_columns(Shared& shared);
void trace_hits(Shared& shared);
void weigh_edges(Shared& shared);

Counts work_of_columns(const Scene& scene, std::span<const Noise> noises);
Counts work_of_hits(const Scene& scene, std::span<const Noise> noises);
std::int64_t bytes_of_noises(const Scene& scene, std::span<const Noise> noises);
std::int64_t bytes_of_grid(const Scene& scene, std::span<const Noise> noises);
std::int64_t bytes_of_columns(const Scene& scene, std::span<const Noise> noises);
std::int64_t bytes_of_weights(const Scene& scene, std::span<const Noise> noises);

}  // namespace noiseloom::render
