// The optimiser of one texture over ranks and threads: sweeps of steps, one colour class a step.
//
// After every step the state is complete: permutations of the own slices and EngineState are all that is needed to go
// on, on any number of ranks and threads, to the same bytes (except with stop.time, which follows the clock).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "noiseloom/anneal/feature_map.h"
#include "noiseloom/anneal/schedule.h"
#include "noiseloom/anneal/slice_mover.h"
#include "noiseloom/core/parallel.h"
#include "noiseloom/dist/halo_exchange.h"
#include "noiseloom/problem/spec.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {

struct HistoryRow {
  double sweep = 0;           // sweeps done
  double iterations = 0;      // iterations done; a sweep makes several of them
  double temperature = 0;     // of the last sweep (anneal), or gamma (fast)
  double acceptance = 0;      // swaps per candidate in it
  double relative_error = 0;  // R now
  double seconds = 0;         // since the run began, over all its parts
};

struct EngineState {
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
  std::string finished;  // why the run is over: "iterations", "time", "score", "improvement"; empty while it is not
  std::vector<HistoryRow> history;
};

// The last sweep: what a person sees between two scores.
struct SweepFigures {
  double temperature = 0;  // or gamma
  double acceptance = 0;
  double relative_error = 0;  // R at the last score, moved on by the energy of the swaps since
};

class Engine {
 public:
  // All arguments must outlive the engine. Decides nothing yet. *Collective*
  Engine(const ProblemSpec& problem, const OptimizerSpec& optimizer, const SampleSource& source,
         const Communicator& communicator, ThreadPool& pool);
  ~Engine();

  // Places the stratified samples at random and scores them. *Collective*
  void start();
  // Goes on from a saved state. `permutation` gives any slice that this rank owns or is coupled with. *Collective*
  void restore(const EngineState& state, const std::function<std::vector<std::uint32_t>(SliceIndex)>& permutation);
  // Slices whose permutation restore() will ask for: own, then needed.
  std::vector<SliceIndex> slices_held() const;

  bool finished() const;
  const std::string& finished_by() const;  // the stop rule that ended it; empty while it has not
  // Moves one colour class; at the end of a sweep scores and decides whether to go on. `seconds`: since the run began;
  // only rank 0's value counts. *Collective*
  void step(double seconds);
  // Completes outstanding messages; before saving or stopping. *Collective*
  void settle();

  // The state to save; counts summed over ranks. *Collective*
  EngineState state();
  const std::vector<HistoryRow>& history() const;
  const SweepFigures& last_sweep() const;
  double temperature() const;
  std::int64_t sweep() const;
  std::int64_t iterations() const;  // done so far
  std::int64_t iterations_per_sweep() const;
  Moment moment() const;
  double relative_error();  // exact, now. *Collective*

  const Partition& partition() const;
  const HaloPlan& halo() const;
  std::int64_t num_classes() const;
  bool couples_slices() const;
  std::int64_t bytes_sent() const;       // by this rank
  std::int64_t messages_sent() const;    // by this rank
  std::int64_t candidates_done() const;  // by this rank since it was made

  // Of an own slice: ids by cell, and samples interleaved [y][x][channel].
  const std::vector<std::uint32_t>& permutation(SliceIndex slice) const;
  std::vector<float> samples(SliceIndex slice) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace noiseloom
