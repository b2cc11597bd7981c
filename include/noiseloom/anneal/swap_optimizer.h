// The optimiser by swaps, of one texture, over ranks and threads: the methods `anneal` and `fast`.
//
// A run is a sequence of sweeps; a sweep visits every slice once. It is made of steps, each of which moves the slices
// of one colour class (problem/colour_classes.h) at the same time: every slice against a frozen copy of all others.
// After a step the ranks tell each other what has changed.
//
// After every step the state is complete: the permutations of the own slices and SwapState are all that is needed to go
// on, on any number of ranks and threads, to the same bytes (except with stop.time, which follows the clock).
//
// R is evaluated where the schedule asks for it, which makes the rows of the history, and also where somebody wants to
// know (score_now). What is shown in between is R as last evaluated, and where that was: it is never guessed.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "noiseloom/anneal/schedule.h"
#include "noiseloom/anneal/spec.h"
#include "noiseloom/anneal/swap_state.h"
#include "noiseloom/core/parallel.h"
#include "noiseloom/dist/communicator.h"
#include "noiseloom/dist/halo_plan.h"
#include "noiseloom/problem/spec.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {

// The numbers of the algorithms by swaps. A config gives the same bytes as long as they stay: whoever changes what an
// unchanged config gives raises the number in the same commit (tests/program/pinned_samples_test.py notices). A run
// file keeps it, and a run of another number is not gone on with.
//   2: rounds of stop.score and stop.improvement count iterations, not sweeps; few taps of the same pixel have no
//   features
//   3, anneal alone: vectors and directions are estimated before they are judged, visited for longer, and have more
//   features between slices
//   4, anneal alone: these have more features where other slices count much, not elsewhere
//   5, anneal alone: rounds of slices that do not act on each other end in the cold
//   6, anneal alone: features are fitted to peaks and to far samples alike, and lists of users span their bulk too
//   7, anneal alone: the strata over time that it begins with are made otherwise (construct/time_strata.h)
//   8, anneal alone: a good arrangement of scalars is annealed to a lower temperature, and from a lower one
//   9, anneal alone: the temperature falls by an exponent of its own for each kind of filter; visits of what is
//   estimated are twice as long; estimates leave out small taps of what was swapped
//   10, anneal alone: taps below 0.001 are left out where the config does not say
//   10 and 3: a sum's groups are cut each by its own largest tap
inline constexpr std::int64_t anneal_algorithm = 10;
inline constexpr std::int64_t fast_algorithm = 3;

// Of a slice: the id of the sample of every cell.
using PermutationOf = std::function<Permutation(SliceIndex)>;

// Of the last sweep.
struct SweepFigures {
  double temperature = 0;  // or gamma
  double acceptance = 0;   // swaps per candidate
};

class SwapOptimizer {
 public:
  // All arguments must outlive the optimiser. Decides nothing yet. *Collective*
  SwapOptimizer(const ProblemSpec& problem, const OptimizerSpec& optimizer, const SampleSource& source,
                const Communicator& communicator, ThreadPool& pool);
  ~SwapOptimizer();

  // Places the stratified samples at random and scores them. Where no swap can change R, the run is over (unless it
  // stops by iterations). *Collective*
  void start();
  // Begins with a given arrangement, which annealing goes on from and which the run comes back to if that does not
  // lower R. `permutation` gives any slice that this rank owns or is coupled with. With stop.time, `seconds` of the run
  // are over. *Collective*
  void start_from(const PermutationOf& permutation, double seconds);
  // After start_from: annealing begins where that from a random arrangement is when this fraction of it is over, [0,
  // 1]; at its start unless this is called. *Collective*
  void join_schedule(double fraction, double seconds);
  // After start_from, instead: annealing that keeps to temperatures at which nothing melts (cooling.h,
  // cold_range), for an arrangement that it could not make.
  void join_cold(double seconds);
  // Goes on from a saved state. `permutation` gives any slice that this rank owns or is coupled with. *Collective*
  // `given`: what an own slice began with, where SwapState::is_given.
  void restore(const SwapState& state, const PermutationOf& permutation, const PermutationOf& given = {});
  // Slices whose permutation restore() will ask for: own, then needed.
  std::vector<SliceIndex> slices_held() const;

  Method method() const;
  bool finished() const;
  const std::string& finished_by() const;  // why it is over (schedule.h, `ended`); empty while it is not
  // Moves one colour class; at the end of a sweep scores and decides whether to go on. `seconds`: since the run began;
  // only rank 0's value counts, and only for stop.time and for how often R is evaluated to be shown. *Collective*
  void step(double seconds);
  // Completes outstanding messages; before saving or stopping. *Collective*
  void settle();
  // Evaluates R unless that was done since the last step. Leaves the history alone. *Collective*
  void score_now();
  // Whether score_now() takes less than that, as far as is known. The same on every rank. *Collective*
  bool scores_within(double seconds) const;

  // The state to save; counts summed over ranks. *Collective*
  SwapState state();
  const std::vector<HistoryRow>& history() const;
  const SweepFigures& last_sweep() const;
  double join() const;
  bool is_cold() const;
  bool kept_given() const;                       // R was not below that of the given arrangement, which is back
  double last_score() const;                     // R when it was last evaluated,
  std::int64_t last_score_at_iteration() const;  // after how many iterations that was,
  bool last_score_is_current() const;            // and whether nothing has moved since
  double temperature() const;
  std::int64_t sweep() const;
  std::int64_t iterations() const;  // done so far
  std::int64_t iterations_per_sweep() const;
  std::int64_t iterations_per_sweep(bool cold) const;  // of a run that keeps to the cold, or of one that does not
  Moment moment() const;
  // Whether the schedule asks for a row of the history after so many sweeps, at least 1, that are not the run's end.
  // Not for stop.time. `cold`: as above.
  bool row_is_planned_after(std::int64_t sweeps, bool cold) const;
  double relative_error();  // score_now(), then last_score(). *Collective*

  const Distribution& distribution() const;
  const HaloPlan& halo() const;
  std::int64_t num_classes() const;
  bool couples_slices() const;
  std::int64_t bytes_sent() const;       // by this rank
  std::int64_t messages_sent() const;    // by this rank
  std::int64_t candidates_done() const;  // by this rank since it was made

  // Where the run began with a given arrangement: that of an own slice.
  bool has_given() const;
  const Permutation& given_permutation(SliceIndex slice) const;
  // Of an own slice: ids by cell, and samples interleaved [y][x][channel].
  const Permutation& permutation(SliceIndex slice) const;
  std::vector<float> samples(SliceIndex slice) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace noiseloom
