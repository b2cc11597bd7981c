// Passes behind the estimate: filters over time and space, errors, pictures.
#pragma once

#include <cstdint>
#include <span>

#include "noiseloom/render/noise.h"
#include "noiseloom/render/passes.h"
#include "noiseloom/render/scene.h"
#include "render/job.h"

namespace noiseloom::render {

void average(Job& job);
// The same where each pixel has a history of its own: found again where it was seen a frame before, if it was.
void average_histories(Job& job);
void trace_moving_hits(Job& job);
bool has_histories(const Scene& scene);
void filter(Job& job);
void measure(Job& job);
void keep(Job& job);

// The image after a filter over space of the scene.
Image filtered(const Shared& shared, std::string_view pass, const Image& image, std::size_t filter);

Counts work_of_averages(const Scene& scene, std::span<const Noise> noises);
Counts work_of_histories(const Scene& scene, std::span<const Noise> noises);
Counts work_of_filters(const Scene& scene, std::span<const Noise> noises);
Counts work_of_errors(const Scene& scene, std::span<const Noise> noises);
std::int64_t bytes_of_averages(const Scene& scene, std::span<const Noise> noises);
std::int64_t bytes_of_filtered(const Scene& scene, std::span<const Noise> noises);
std::int64_t bytes_of_errors(const Scene& scene, std::span<const Noise> noises);
std::int64_t bytes_of_pictures(const Scene& scene, std::span<const Noise> noises);

}  // namespace noiseloom::render
