// What `accuracy` runs: a ladder of settings around a config, and which rung is next within a budget of seconds.
//
// A base line for each method that makes the same kind of texture: of rising iterations where the method has some (of
// construction: none, and then those of annealing after it), else of one point. And knobs: settings that are changed
// one at a time on the line of the config's own method, at an iteration count of that line, so that every knob has a
// run to be compared with. The ladder depends on the config alone; which of it fits depends on the machine and the
// budget.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "noiseloom/config/config.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {

// What is run once for each seed. `setting` is what differs from the config: "" nothing, "method" (to one without
// iterations), "iterations" (and perhaps the method), or a knob: "cutoff", "background_features", "precision" (and the
// iterations). `value` is that setting's, as a config spells it.
struct AccuracyPoint {
  Method method = Method::anneal;
  std::string setting;
  std::string value;
  std::int64_t iterations = 0;  // 0: the method has none, or the config stops by another rule; construct: after it
  bool is_default = false;      // the config as it is

  bool is_knob() const { return !setting.empty() && setting != "iterations" && setting != "method"; }
  friend bool operator==(const AccuracyPoint&, const AccuracyPoint&) = default;
};

// "anneal-200", "anneal-200-cutoff-0.01", "construct", "default-200"; unique in a ladder.
std::string point_name(const AccuracyPoint& point);
// For people: "anneal, 200 iterations, cutoff 0.01".
std::string describe_point(const AccuracyPoint& point);
std::string method_name(Method method);
std::optional<Method> method_of_name(const std::string& name);
bool has_iterations(Method method);

// A setting to change, without an iteration count yet. `cost`: seconds over those of the base line's run, guessed.
struct AccuracyKnob {
  std::string setting;
  std::string value;
  double cost = 1;
};

// A point that does not run, and why, as a sentence without full stop. Final: it would not either if there was more
// time.
struct LeftOut {
  AccuracyPoint point;
  std::string reason;
  bool is_final = false;
};

struct AccuracyLadder {
  Method method = Method::anneal;    // the config's
  StopSpec stop;                     // the config's
  int runs = 1;                      // of each point
  std::vector<AccuracyPoint> lines;  // the config's own first, each by rising iterations; one point is the default
  std::vector<AccuracyKnob> knobs;
  std::vector<LeftOut> incomparable;  // methods, each as one point, and why they stay out

  const AccuracyPoint& default_point() const;
};

// What the ladder must know of a problem beside its settings.
struct LadderTraits {
  bool constructs = false;  // whether construct takes the samples
  bool background = false;  // the rank of the background changes something
  double exact_cost = 1;    // seconds of an iteration without it over those with it, guessed from counts of taps
};
LadderTraits ladder_traits(const RunConfig& config, const SampleSource& source);

AccuracyLadder accuracy_ladder(const RunConfig& config, const LadderTraits& traits, int runs = 1);
// Takes a method off the ladder.
void leave_out(AccuracyLadder& ladder, Method method, const std::string& reason);

// A point that is done: its seconds are those of the processes of all its runs, its R is their mean.
struct TimedPoint {
  AccuracyPoint point;
  double seconds = 0;
  double relative_error = 1;
};

// Seconds of a point from those that are done: a straight line through the two runs of the same method with the nearest
// fewer iterations, times the knob's cost. Until three runs of a line tell its start-up, that is taken to be a half at
// most; of a single run of the method that the config does not use, nothing. No value where no run says anything.
std::optional<double> predicted_seconds(const AccuracyLadder& ladder, const AccuracyPoint& point,
                                        const std::vector<TimedPoint>& done);

struct LadderStep {
  std::optional<AccuracyPoint> next;  // none: the ladder ends here
  std::vector<LeftOut> left_out;      // then: all that has not run
};

// The cheapest point that is expected to fit into `left_s` seconds of a budget of `budget_s`; while the default has not
// run and would fit, its seconds are kept for it. A knob waits until its line has reached the iterations at which it
// takes about 1/30 of the budget; a knob that has run (in an earlier part) fixes that count. The line of a method that
// the config does not use ends where more iterations have made R worse twice in a row. Those in `not_again` do not run
// and keep their reasons.
LadderStep next_step(const AccuracyLadder& ladder, const std::vector<TimedPoint>& done,
                     const std::vector<LeftOut>& not_again, double left_s, double budget_s);

// Whether the point is one that this ladder can ask for.
bool is_on_ladder(const AccuracyLadder& ladder, const AccuracyPoint& point);

// Seconds as a person reads them: "0.42 s", "12.3 s", "4 min 10 s", "2 h 5 min".
std::string seconds_text(double seconds);

}  // namespace noiseloom
