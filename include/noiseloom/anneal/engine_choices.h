// What the engine chooses from the problem: pure functions of config and footprint, never of ranks, threads or clocks.
#pragma once

#include <optional>
#include <vector>

#include "noiseloom/anneal/feature_map.h"
#include "noiseloom/anneal/slice_mover.h"
#include "noiseloom/anneal/spec.h"
#include "noiseloom/anneal/tile_grid.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {

// The start and end temperature of the anneal, in units of the mean |dE| at the start.
struct TemperatureRange {
  double start;
  double end;
};
TemperatureRange temperature_range(const OptimizerSpec& optimizer);

// Step size and temperature belong together: where a round is `fraction` through. Partners draw nearer as it cools.
StepRange step_range(DistanceKind kind, int channels, double fraction);
// Partners for as many samples as a tile has.
PartnerDraw partners_for(DistanceKind kind, int channels, WindowSize tile, double fraction);

// The slices that move together: colour classes (anneal), or all of them (fast).
std::vector<std::vector<SliceIndex>> classes_for(Method method, const Footprint& footprint);
TileGrid tiles_for(Method method, const Footprint& footprint, const std::vector<std::vector<SliceIndex>>& classes);

// The low-rank background of slices that are coupled by a product; nothing where taps are exact (other filters, double
// precision, rank 0, or so few taps between slices that features would cost more).
std::optional<FeatureMap> features_between_slices(const OptimizerSpec& optimizer, const Footprint& footprint,
                                                  const ValueKernel& kernel, const SampleSource& source, int rank);
// The rank of the background where a round is `fraction` through: the one of the config, four times as many features
// in the last quarter, which is cold enough for what the first ones miss to count, and all that there can be in the
// last twentieth.
int background_rank(const OptimizerSpec& optimizer, double fraction);
// Iterations that one visit of a slice makes.
std::int64_t visit_length(const OptimizerSpec& optimizer, bool with_background);
// The schedule in sweeps of `per_sweep` iterations each (the last may be shorter).
StopSpec in_sweeps(StopSpec stop, std::int64_t per_sweep);

// How often R is evaluated in a round of that many iterations: 50 times, or as often as costs a thirtieth of it, at
// least once. From counts of taps, so that the history is the same everywhere. `judged` is the footprint that
// candidates are judged with, `scored` that of R.
std::int64_t scores_per_round(DistanceKind kind, const Footprint& scored, const Footprint& judged, bool with_background,
                              std::int64_t iterations);

}  // namespace noiseloom
