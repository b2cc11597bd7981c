// How far a run has come, how hot it is, and when it ends: a function of the sweep (and, for stop.time, of the seconds
// so far).
//
// iterations: one round of that many sweeps. time: one round that ends when the seconds are used up; the temperature
// follows the seconds. score, improvement: rounds of 100, 200, 400, ... sweeps, each cooled from the start; `score`
// ends at the first R that is low enough, `improvement` when a round lowers the R of the round before by less than the
// given fraction. Temperatures fall geometrically: T = start (end / start)^fraction.
#pragma once

#include <cstdint>

#include "noiseloom/anneal/spec.h"

namespace noiseloom {

struct Moment {
  std::int64_t round = 0;
  std::int64_t sweep_in_round = 0;
  std::int64_t round_length = 0;  // 0: not known (stop.time)
  double fraction = 0;            // of the round, 0 at its first sweep, 1 at its last

  bool ends_round() const { return round_length > 0 && sweep_in_round + 1 == round_length; }
};

// The moment at which `sweep` begins. `elapsed_s` counts for stop.time only.
Moment moment_of(const StopSpec& stop, std::int64_t sweep, double elapsed_s);

// start > 0, end > 0; bit-stable.
double temperature_at(double start, double end, double fraction);

// Whether R is evaluated after the sweep that began at `moment`: about `scores_per_round` times, and at the round's
// end.
bool score_due(const Moment& moment, std::int64_t scores_per_round);

}  // namespace noiseloom
