// What the optimiser by swaps chooses from the problem: pure functions of config and footprint, never of ranks, threads
// or clocks.
#pragma once

#include <optional>
#include <vector>

#include "noiseloom/anneal/feature_map.h"
#include "noiseloom/anneal/slice_mover.h"
#include "noiseloom/anneal/spec.h"
#include "noiseloom/anneal/tile_grid.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {

// Whether the config gives a temperature. Then it falls geometrically, and no measurement of ours has a say in it.
bool has_given_temperature(const OptimizerSpec& optimizer);

// The start and end temperature of the anneal, in units of the mean |dE| at the start.
struct TemperatureRange {
  double start;
  double end;
};
// Filters whose slices act on each other by the same pixel alone, as sums do, begin at 0.06, others at 0.11; where the
// config gives one of the two, the other is 0.11 or 8e-4. A run that joins the schedule (`join` > 0) does so in the
// range from 0.11 and with an exponent of 1, as where to join it was measured so. `footprint` is that of the energy.
TemperatureRange temperature_range(const OptimizerSpec& optimizer, const Footprint& footprint, double join = 0);
// T = start (end / start)^(f^exponent), where a round is f through (cooled(), schedule.h). Above 1 the round dwells
// where it is hot. Sums want that (2.75), and products whose slices count much for each other the contrary (0.8): see
// "How fast it cools" in tests/bench/README.md. With stop.time f is of seconds, of which iterations take more when it
// is hot and much is swapped, so the exponent is 1.3 times as high.
double cooling_exponent(const OptimizerSpec& optimizer, const Footprint& footprint, bool with_sieve, double join = 0);
// Whether there are other slices that act on a slice, and each by the same pixel alone.
bool acts_by_same_pixels(const Footprint& footprint);
// That range from `join` on for a run that joins the schedule there, if it is one that ends colder. Scalars do, whose
// arrangement is a good one, where slices do not act on each other: a construction of 128x128 under binomial 3,
// annealed from 0.02 for 46,000 iterations, has R 0.1073, 0.1070 and 0.1070 with an end of 8e-4, 5e-4 and 2.5e-4
// (0.1089 before). Circles of 8,000 iterations: box 5 0.4 % lower, gauss 0.7 6 % higher, so theirs stays.
TemperatureRange joined_range(const TemperatureRange& whole, double join);
bool ends_colder(DistanceKind kind, int channels, bool couples_slices);
// For an arrangement that would melt at the end of that range (join_cold). Tried on constructions: 32x32x32 of gauss
// 1.3435 x ema and of box 5 x ema for 200 iterations, 128x128 of gauss 1.0 for 400 and of box 5 for 200. From 1e-4 on
// nothing changes; twenty times that loses most of the gain.
TemperatureRange cold_range();
// The share of a round in which the temperature falls over that range; what is left is spent in the cold. Measured on
// single slices of 64x64 and 128x128, 1,000 to 20,000 iterations, with 3 % of them in the cold: R of scalars under box
// 5 and box 3 is 3.0 and 1.4 % lower, of vector2 for spatiotemporal blue noise 1.0, and of the others, from directions
// and circles to binomials, by 0 to 0.6 %. Where slices act on each other nothing is gained, so there it is all of the
// round; and so where the config gives the range.
double cooling_share(const OptimizerSpec& optimizer, bool couples_slices);
// Where step_range is then, when that fraction of the run is over. R with 0.7 all the time: 0.04621, 0.07486, 0.08823,
// 0.07607; with 1.3: 0.04570, 0.07500, 0.08780, 0.07608; from 0 to 2: 0.04568, 0.07480, 0.08771, 0.07599.
double cold_step_fraction(double fraction);
// Features are what limits R in the cold: with 16 of them swaps that seem to lower the energy raise it, and 128x128x64
// of gauss 1.3435 x ema stays where it is. To take a slice up with all of them costs as much as tens of iterations.
std::int64_t cold_visit_length(const OptimizerSpec& optimizer, std::int64_t num_cells, bool with_background,
                               bool with_sieve);

// Step size and temperature belong together: where the logarithm of the temperature has fallen by `fraction`. Partners
// draw nearer as it cools.
StepRange step_range(DistanceKind kind, int channels, double fraction);
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
