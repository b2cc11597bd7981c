// What the optimiser by swaps chooses from the problem, but for how it cools (cooling.h): pure functions of config and
// footprint, never of ranks, threads or clocks.
#pragma once

#include <optional>
#include <vector>

#include "noiseloom/anneal/feature_map.h"
#include "noiseloom/anneal/slice_mover.h"
#include "noiseloom/anneal/spec.h"
#include "noiseloom/anneal/tile_grid.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {

// Partners for as many samples as a tile has.
PartnerDraw partners_for(DistanceKind kind, int channels, WindowSize tile, double fraction, int num_strata = 1);

// Of the footprint that the energy is of. What is not given is 1e-3: after as long, circles, directions and blue noise
// have R lower by 1 to 11 % than with every tap, and none of what was tried a higher one beyond its scatter
// (tests/bench/README.md). The paper's method judges by every tap.
double energy_cutoff(const OptimizerSpec& optimizer);

// The slices that move together: colour classes (anneal), or all of them (fast).
std::vector<std::vector<SliceIndex>> classes_for(Method method, const Footprint& footprint);
TileGrid tiles_for(const OptimizerSpec& optimizer, const Footprint& footprint,
                   const std::vector<std::vector<SliceIndex>>& classes);

// Whether slices act on each other through features, from what is known of the footprint.
bool wants_features(const OptimizerSpec& optimizer, bool has_factors, std::int64_t num_taps, std::int64_t own_taps);
// The features through which slices that are coupled by a product act on each other, `count` of them at most; nothing
// where all taps are taken (other filters, double precision, a count of 0, or so few taps between slices that features
// would cost more).
std::optional<FeatureMap> features_between_slices(const OptimizerSpec& optimizer, const Footprint& footprint,
                                                  const ValueKernel& kernel, const SampleSource& source, int count);
// How many features stand for the other slices where the logarithm of the temperature has fallen by `fraction`: as many
// as the config says, four times as many in the last quarter of the fall, which is cold enough for what the first ones
// miss to count, and all that there can be in the last twentieth and in the cold. `many`: four times as many from the
// start, and all in the last quarter.
int num_features(const OptimizerSpec& optimizer, double fraction, bool many);
// Whether other slices count so much, and a sieve makes features so cheap, that many of them pay.
bool wants_many_features(const Footprint& footprint, bool with_sieve);
// Whether candidates are estimated before they are judged, from what is known of the footprint: whether a Sieve serves
// it, and whether its taps cost so much that estimates pay.
bool wants_sieve(const OptimizerSpec& optimizer, const ValueKernel& kernel, bool is_served, std::int64_t own_taps);
// The features that estimates are made with; nothing where candidates are all judged.
std::optional<FeatureMap> features_of_sieve(const OptimizerSpec& optimizer, const Footprint& footprint,
                                            const ValueKernel& kernel, const SampleSource& source);
// Iterations that one visit of a slice makes, of a texture of so many cells.
std::int64_t visit_length(const OptimizerSpec& optimizer, std::int64_t num_cells, bool with_background,
                          bool with_sieve);
// The same in the cold (cooling.h). Features are what limits R there: with 16 of them swaps that seem to lower the
// energy raise it, and 128x128x64 of gauss 1.3435 x ema stays where it is. To take a slice up with all of them costs as
// much as tens of iterations.
std::int64_t cold_visit_length(const OptimizerSpec& optimizer, std::int64_t num_cells, bool with_background,
                               bool with_sieve);

// How many iterations take as long as one evaluation of R, from counts of taps: of those of R, which is found in float
// or in double, and of those that a candidate is judged with. No measurement, so that the history is the same
// everywhere.
double iterations_per_score(DistanceKind kind, std::int64_t scored_taps, bool in_float, std::int64_t judged_taps);
// How often R is evaluated in a round of that many iterations: 50 times, or as often as costs a fortieth of it; but up
// to 8 times where that costs no more than a twentieth, and at least once.
std::int64_t scores_per_round(double iterations_per_score, std::int64_t iterations);
// The iterations between two evaluations that cost a fortieth of them; at least 1.
std::int64_t score_interval(double iterations_per_score);

}  // namespace noiseloom
