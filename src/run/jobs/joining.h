// Where annealing joins its schedule when it begins with a given arrangement: hot enough to lead somewhere, and not so
// hot that it melts what it was given into something that it cannot make again in the work that it has.
#pragma once

#include <functional>
#include <optional>

#include "noiseloom/config/config.h"
#include "noiseloom/core/parallel.h"
#include "noiseloom/dist/communicator.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {

// What annealing has to do, and what it was given.
struct JoiningQuestion {
  double given_error = 1;                                   // R of the arrangement
  double left_s = 0;                                        // stop.time: for so long
  int workers = 1;                                          // stop.time: threads that move slices, of all ranks
  std::function<bool()> is_stopped = [] { return false; };  // looked at between two steps of a trial
};
// What find_joining throws where it is stopped.
struct TrialsStopped {};

struct Joining {
  double expected_ratio = 1;  // R that annealing from a random arrangement would come to, over that of the given one
  bool cold = false;          // join_cold
  double fraction = 0;        // else join_schedule
};

// By trials on a small texture of the same filter, which every rank makes for itself, to the same result (but for
// stop.time): a twentieth of the work of one thread, as far as that is between about a hundred and two thousand
// iterations of the small texture and takes seconds; with stop.time, a tenth of what is left.
Joining find_joining(const RunConfig& config, const SampleSource& source, const JoiningQuestion& question,
                     ThreadPool& pool);

// The same on all ranks; nothing where a signal asked one of them to stop. *Collective*
std::optional<Joining> agree_on_joining(const RunConfig& config, const SampleSource& source, double given_error,
                                        double left_s, const Communicator& communicator, ThreadPool& pool);
// Whether trials have a say. Where the user says with which temperature it begins, the schedule is the user's.
bool needs_joining(const OptimizerSpec& optimizer);

// Of that small texture.
Extents extents_of_trials(const RunConfig& config);
// What trials take of the work of a run.
constexpr double share_of_trials = 0.05;

// The rule alone. Measured on 128x128 with box 3, box 5, gauss 0.7, gauss 1.0, binomial 2 and binomial 3, constructed
// and then annealed for 100 to 30,000 iterations from each tenth of the schedule, and on 64x64x32 with an EMA
// (tests/bench/README.md). Trials foretell too much: 128x128, 46,000 iterations: 0.98 for binomial 3, where 1.03 comes
// of it, 0.90 for binomial 2 and 0.92 for gauss 0.7, where 0.97 does.
Joining joining_of(double expected_ratio);

// Of a circle that was constructed no trial tells anything: single slices fall into order late (64x64, gauss 0.7, 100
// to 25,600 iterations, four times as many at a time: ln R falls by 0.31 0.41 0.67 0.72), and to join the schedule was
// best or nearly so for all of box 3, box 5, gauss 0.7, gauss 1.0, binomial 2 and binomial 3 in 1,000 and in 8,000
// iterations. In 100 there is no gain.
Joining joining_of_circle(double iterations);

// What R falls to in `iterations`, where it came to `error_of_quarter` in a quarter of `tried` iterations and to
// `error` in all of them: every four times as many gain three quarters of what the four times before gained.
double extrapolated_error(double error_of_quarter, double error, double tried, double iterations);

}  // namespace noiseloom
