// What a run of the swap optimiser is, beside the permutations of its slices: all that a run file has to hold for the
// run to go on, and its history.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace noiseloom {

// One evaluation of R.
struct HistoryRow {
  double sweep = 0;           // sweeps done; the last one of a run with stop.time may be cut short
  double iterations = 0;      // iterations done; a sweep makes several of them, one that is cut short fewer
  double temperature = 0;     // of the last sweep (anneal), or gamma (fast)
  double acceptance = 0;      // swaps per candidate in it
  double relative_error = 0;  // R now
  double seconds = 0;         // since the run began, over all its parts
};

struct SwapState {
  std::int64_t sweep = 0;     // sweeps done
  std::int64_t step = 0;      // steps done in the present sweep
  std::int64_t accepted = 0;  // in the present sweep, over all ranks
  std::int64_t candidates = 0;
  double temperature = 0;     // of the present sweep
  double elapsed_s = 0;       // at its begin (stop.time)
  double fraction = 0;        // fast: gamma
  double mean_magnitude = 0;  // anneal: mean |dE| at the start, the unit of temperature
  double mean_distance = 0;   // m of the score
  double round_score = 0;     // R at the end of the round before
  // R when it was last evaluated, and where the run was then. The history holds what the schedule asks for, and is the
  // same for a run that was stopped; this is also R at a stop.
  double relative_error = 0;
  std::int64_t iterations = 0;  // done, up to the end of the last sweep
  std::int64_t scored_iterations = 0;
  std::int64_t scored_step = 0;
  // Of a run that began with a given arrangement (start_from); zeros where it began with a random one.
  std::int64_t is_given = 0;    // 1: it did
  double begun_s = 0;           // when, in seconds of the run
  double join = 0;              // where in its schedule (schedule.h, joined_fraction)
  std::int64_t is_cold = 0;     // 1: it keeps to the cold (join_cold)
  double given_error = 0;       // R of that arrangement
  std::int64_t given_kept = 0;  // 1: the run is over and came to no lower R, so that it is back at that arrangement
  std::string finished;         // why the run is over (schedule.h, `ended`); empty while it is not
  std::vector<HistoryRow> history;

  // Whether `relative_error` is R of the texture as it is now.
  bool score_is_current() const { return scored_iterations == iterations && scored_step == step; }
};

}  // namespace noiseloom
