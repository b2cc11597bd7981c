// Passes behind the estimate: filters over time and space.
#pragma once

#include <cstdint>
#include <span>

#include "noiseloom/render/noise.h"
#include "noiseloom/render/passes.h"
#include "noiseloom/render/scene.h"
#include "render/jobs/job.h"

namespace noiseloom::render {

void average(Job& job);
// The same where each pixel has a history of its own: found again where it was seen a frame before, if it was.
void average_histories(Job& job);
void trace_moving_hits(Job& job);
bool has_histories(const Scene& scene);
void filter(Job& job);

// What a frame weighs in an average of `length` frames, itself included.
double weight_of_frame(const TimeFilterSpec& time, const std::string& kernel, std::int64_t length);

// The image after a filter over space of the scene that is linear.
Image filtered(const Shared& shared, std::string_view pass, const Image& image, std::size_t filter, Rows rows);
// Of the job's frame after a filter over time, the frame alone first.
const Image& over_time(const Job& job, std::size_t time);

Counts work_of_averages(const Scene& scene, std::span<const Noise> noises);
Counts work_of_histories(const Scene& scene, std::span<const Noise> noises);
Counts work_of_filters(const Scene& scene, std::span<const Noise> noises);
std::int64_t bytes_of_averages(const Scene& scene, std::span<const Noise> noises);
std::int64_t bytes_of_filtered(const Scene& scene, std::span<const Noise> noises);

}  // namespace noiseloom::render
