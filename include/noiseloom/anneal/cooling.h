// How annealing cools, as it was measured to be best for the kind of filter and samples: temperatures and what goes
// with them. Pure functions of config and footprint, never of ranks, threads or clocks.
#pragma once

#include "noiseloom/anneal/slice_mover.h"
#include "noiseloom/anneal/spec.h"
#include "noiseloom/problem/footprint.h"
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

// Step size and temperature belong together: where the logarithm of the temperature has fallen by `fraction`. Partners
// draw nearer as it cools.
StepRange step_range(DistanceKind kind, int channels, double fraction);

}  // namespace noiseloom
