// How fast this machine is at what a config asks for: measured for about a third of a second on a texture that is small
// but has the config's own samples, filter and precision.
#pragma once

#include <array>
#include <vector>

#include "noiseloom/anneal/slice_field.h"
#include "noiseloom/config/config.h"
#include "noiseloom/run/plan.h"
#include "noiseloom/samples/sample_space.h"
#include "run/plans/plan_filter.h"

namespace noiseloom {

// Swaps per candidate, averaged over a run that cools down.
inline constexpr double typical_acceptance = 0.15;

// The parts of a run that are judged with the same number of features, about: its first three quarters, the fifth after
// them, the last twentieth.
inline constexpr std::array<double, 3> moments_of_run = {0.0, 0.8, 1.0};
inline constexpr std::array<double, 3> share_of_moment = {0.75, 0.2, 0.05};

// Seconds on one thread.
struct PlanSpeed {
  double candidate = 0;  // judged, and swapped as often as on average
  double bind = 0;       // taking up a cell of a tile, once a visit
  double score_tap = 0;  // R: a cell and a tap
  double pair = 0;       // mean distance: two samples; in one dimension: one sample
  double sample = 0;     // making a stratified sample
  std::vector<PlanFeatures> features;
};

// `channels`, `distance`: of the samples (a file's are found in it).
PlanSpeed measure_speed(const RunConfig& config, const FilterOutline& judged, WindowSize tile, int channels,
                        DistanceKind distance);

}  // namespace noiseloom
