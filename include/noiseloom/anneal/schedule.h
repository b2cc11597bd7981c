// How far a run of the swap optimiser has come, how hot it is, and why it ends: functions of the sweep and of R (and,
// with stop.time, of the seconds so far), never of ranks or threads.
//
//   stop.iterations    one round of that many iterations
//   stop.time          one round that ends when the seconds are used up; the temperature follows the seconds
//   stop.score         rounds of 100, 200, 400, ... iterations (in whole sweeps), each cooled from the start; ends at
//                      the first R that is low enough, or where no further round would reach it (see ended_by)
//   stop.improvement   the same rounds; ends when the longer half of a round has lowered R by less than the given
//                      fraction for every hundred iterations that it took
//
// Temperatures fall over a round: T = start (end / start)^(fraction^exponent). Rounds of slices that do not act on
// each other spend their last part in the cold (cooling.h).
#pragma once

#include <cstdint>
#include <string>

#include "noiseloom/anneal/spec.h"

namespace noiseloom {

// Where a sweep lies in its round.
struct Moment {
  std::int64_t round = 0;
  std::int64_t sweep_in_round = 0;
  std::int64_t round_length = 0;  // in sweeps; 0: not known (stop.time)
  double fraction = 0;            // of the round, 0 at its first sweep, 1 at its last

  bool ends_round() const { return round_length > 0 && sweep_in_round + 1 == round_length; }
};

// Why a run ended, as /state of a run file has it.
namespace ended {
inline constexpr const char* by_iterations = "iterations";
inline constexpr const char* by_time = "time";
inline constexpr const char* by_score = "score";
inline constexpr const char* by_improvement = "improvement";
inline constexpr const char* out_of_reach = "score-out-of-reach";  // stop.score was not reached and would not be
inline constexpr const char* nothing_to_swap = "nothing-to-swap";  // no swap can change R
}  // namespace ended

// The same for a person, after "stopped by".
std::string ended_text(const std::string& reason);

class Schedule {
 public:
  // A sweep visits every slice once and makes `iterations_per_sweep` iterations (the last may make fewer).
  Schedule(const StopSpec& stop, std::int64_t iterations_per_sweep);

  const StopSpec& stop() const { return stop_; }
  std::int64_t iterations_per_sweep() const { return per_sweep_; }
  // Iterations that are done when `sweep` begins.
  std::int64_t iterations_before(std::int64_t sweep) const;
  // The moment at which `sweep` begins. The seconds since the run began, and those at which its sweeps did, count for
  // stop.time only.
  Moment moment(std::int64_t sweep, double elapsed_s, double begun_s = 0) const;
  // Iterations of the round of a moment; 0 with stop.time.
  std::int64_t iterations_of_round(const Moment& moment) const;

  // Why the run ends after the sweep that began at `moment` and left the error at `relative_error`; empty where it goes
  // on. `round_score`: R at the end of the round before. stop.time ends elsewhere, as only a clock knows.
  //
  // stop.score: a round of twice the iterations was seen to gain about four fifths of what the round before it gained
  // (scalars 64x64x16, 100 to 6,400 iterations: 8.2, 6.2, 5.0, 3.7, 3.1, 2.2 %). So all further rounds together gain
  // about four times what the last one did; where six times that would not do, the score is out of reach.
  std::string ended_by(const Moment& moment, double relative_error, double round_score) const;

 private:
  StopSpec stop_;
  std::int64_t per_sweep_;
  std::int64_t first_round_;  // in sweeps
};

// How far the logarithm of the temperature has come of a run that joins the schedule at `join`, when `fraction` of its
// own is over: from `join` to 1, evenly.
double joined_fraction(double join, double fraction);

// fraction^exponent: how far the logarithm of the temperature has come when that fraction of the schedule is over.
// 0 <= fraction <= 1, exponent > 0; bit-stable.
double cooled(double fraction, double exponent);

// start > 0, end > 0; bit-stable.
double temperature_at(double start, double end, double fraction);

// How often the method `fast` looks whether its fraction should grow, in a round of that many sweeps: once in a
// hundredth of it, as its authors' program does, and never sooner than those hundred sweeps of its ten thousand.
std::int64_t sweeps_per_fraction(std::int64_t round_length);

// Whether R is evaluated after the sweep that began at `moment`: `scores_per_round` times (at least 1) or after every
// sweep, evenly spaced, the last time at the round's end. Not for stop.time, whose rounds have no length.
bool score_due(const Moment& moment, std::int64_t scores_per_round);
// The same where the end is not known, or may be moved: after `sweeps` sweeps, if they are a multiple of `interval`, or
// of an eighth of the power of two below them where that is more.
bool score_due_without_end(std::int64_t sweeps, std::int64_t interval);

}  // namespace noiseloom
