// The parts of SwapOptimizer: what it is made of (swap_optimizer.cpp), how a step moves one class of slices
// (class_step.cpp), and what is evaluated and decided at the end of a sweep (sweep_end.cpp).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "anneal/float_score.h"
#include "anneal/held_slices.h"
#include "anneal/sweep_movers.h"
#include "noiseloom/anneal/swap_optimizer.h"
#include "noiseloom/anneal/tile_grid.h"
#include "noiseloom/problem/value_kernel.h"

namespace noiseloom {

struct SwapOptimizer::Impl {
  Impl(const ProblemSpec& p, const OptimizerSpec& o, const SampleSource& s, const Communicator& c, ThreadPool& t);

  const ProblemSpec& problem;
  const OptimizerSpec& optimizer;
  const SampleSource& source;
  const Communicator& communicator;
  ThreadPool& pool;

  // Fixed for the run.
  Footprint score_footprint;   // of R: the whole filter
  Footprint energy_footprint;  // of the energy: less what optimizer.cutoff leaves out
  ValueKernel kernel;
  FieldLayout layout;                            // of a whole slice
  std::vector<std::vector<SliceIndex>> classes;  // the slices that move together, step by step
  TileGrid tiles;
  bool members_are_coupled;  // whether slices of one class act on each other
  SweepMovers movers;
  Schedule schedule;
  HeldSlices slices;
  std::optional<FloatScore> float_score;  // where it is exact enough

  // The permutations of own slices that the run began with, where it was given them.
  IndexedVector<LocalSlice, Permutation> given;

  // What a step changes, beside the slices.
  SwapState state;
  SweepFigures figures;
  std::int64_t own_accepted = 0;  // by this rank in the present sweep
  std::int64_t own_candidates = 0;
  std::int64_t candidates_done = 0;
  bool score_is_exact = true;      // whether R was last evaluated in double
  double exact_score_took_s = -1;  // negative: not known
  double quick_score_took_s = -1;  // of one in float, where that is possible
  double last_score_s = 0;         // when R was last evaluated, in seconds since the run began

  // swap_optimizer.cpp
  double mean_magnitude();
  void score_start(double seconds);
  void keep_given(const PermutationOf& permutation);
  Moment moment() const { return schedule.moment(state.sweep, state.elapsed_s, state.begun_s); }

  // class_step.cpp
  // Where in its schedule a sweep is, or in the cold that every round ends with.
  struct Heat {
    bool cold;
    double fraction;
  };
  Heat heat() const;
  double temperature(const Heat& heat) const;
  void prepare_movers();
  void begin_sweep(double seconds);
  void move(const std::vector<SliceIndex>& moving);
  VisitResult visit(SliceIndex slice, int tile, int worker);
  bool depends_on_others_swaps(SliceIndex slice) const;
  void publish(std::vector<SliceSwaps>& moved, std::vector<VisitResult>& results);

  // sweep_end.cpp
  enum class Exactness { quick, exact };
  void score(Exactness wanted, double seconds);
  double quick_score_s() const { return float_score ? quick_score_took_s : exact_score_took_s; }
  bool is_out_of_time(double seconds) const;
  void end_sweep(double seconds);
  std::int64_t iterations_at(std::int64_t sweep, std::int64_t step) const;
  bool score_is_wanted(double seconds) const;
  bool row_is_planned(const Schedule& rounds, const Moment& moment) const;
  void adapt_fraction(std::int64_t accepted, const Moment& moment);
  void add_row(double seconds);
  void keep_the_better();
};

}  // namespace noiseloom
