#include "noiseloom/accuracy/accuracy_ladder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "noiseloom/anneal/swap_choices.h"
#include "noiseloom/image/encoding.h"
#include "noiseloom/problem/footprint.h"
#include "noiseloom/problem/value_kernel.h"

namespace noiseloom {
namespace {

constexpr std::int64_t first_anneal = 25;    // then twice as many
constexpr std::int64_t first_fast = 10;      // then 30, 100, 300, ...
constexpr std::int64_t first_after = 100;    // of annealing after construction; then four times as many
constexpr std::int64_t least_top = 25'600;   // these lines reach at least this far,
constexpr std::int64_t beyond_default = 16;  // and this far beyond the config

// Measured with quick.toml: exact taps of other slices against a background, and double against vectors of floats.
constexpr double cost_of_a_tap = 0.5;
constexpr double double_cost = 4;
constexpr double cheap_knob = 2;        // knobs up to this cost share an iteration count, those above another
constexpr double share_of_budget = 30;  // a knob takes about this part of the budget
constexpr std::size_t runs_to_tell_start_up = 3;
// What is the iterations' share of a run's seconds at the least: with few runs of the line, and with enough of them.
constexpr double least_share = 0.5;
constexpr double least_share_known = 0.1;

std::vector<std::int64_t> line_iterations(Method method, std::int64_t own) {
  const std::int64_t top = std::max(least_top, own > 0 ? beyond_default * own : 0);
  std::vector<std::int64_t> line;
  if (method == Method::anneal) {
    for (std::int64_t n = first_anneal; n <= top; n *= 2) line.push_back(n);
  } else if (method == Method::construct) {
    for (std::int64_t n = first_after; n <= top; n *= 4) line.push_back(n);
  } else {
    for (std::int64_t n = first_fast; n <= top; n *= 10) {
      line.push_back(n);
      if (3 * n <= top) line.push_back(3 * n);
    }
  }
  return line;
}

constexpr std::pair<Method, const char*> method_names[] = {{Method::anneal, "anneal"},
                                                           {Method::fast, "fast"},
                                                           {Method::construct, "construct"},
                                                           {Method::void_and_cluster, "void-and-cluster"}};

// A method without iterations.
AccuracyPoint method_point(Method method) { return {method, "method", method_name(method), 0, false}; }

// The line of one method; on the config's own, the default stands among the others (first, where it has no count).
// Construction stands alone first, and then with so many iterations of annealing after it.
std::vector<AccuracyPoint> base_line(Method method, const RunConfig& config) {
  const OptimizerSpec& optimizer = config.optimizer;
  const bool own = method == optimizer.method;
  if (method == Method::void_and_cluster) return {own ? AccuracyPoint{method, "", "", 0, true} : method_point(method)};
  const std::int64_t default_iterations = optimizer.method == Method::void_and_cluster ? 0 : optimizer.stop.iterations;
  std::vector<AccuracyPoint> line;
  if (own) line.push_back({method, "", "", default_iterations, true});
  if (method == Method::construct && !(own && optimizer.stop.is_none())) line.push_back(method_point(method));
  for (const std::int64_t n : line_iterations(method, default_iterations))
    if (!own || n != default_iterations) line.push_back({method, "iterations", std::to_string(n), n, false});
  std::stable_sort(line.begin(), line.end(),
                   [](const AccuracyPoint& a, const AccuracyPoint& b) { return a.iterations < b.iterations; });
  return line;
}

const AccuracyKnob* find_knob(const AccuracyLadder& ladder, const AccuracyPoint& point) {
  const auto found = std::find_if(ladder.knobs.begin(), ladder.knobs.end(), [&](const AccuracyKnob& knob) {
    return knob.setting == point.setting && knob.value == point.value;
  });
  return found == ladder.knobs.end() ? nullptr : &*found;
}

bool is_done(const std::vector<TimedPoint>& done, const AccuracyPoint& point) {
  return std::any_of(done.begin(), done.end(), [&](const TimedPoint& run) { return run.point == point; });
}

// `single_share`: what is taken for iterations of the only run of a line.
std::optional<double> base_seconds(Method method, std::int64_t iterations, const std::vector<TimedPoint>& done,
                                   double single_share) {
  std::vector<std::pair<double, double>> runs;  // iterations, seconds
  for (const TimedPoint& run : done)
    if (run.point.method == method && run.point.iterations > 0 && !run.point.is_knob())
      runs.emplace_back(run.point.iterations, run.seconds);
  if (runs.empty()) return std::nullopt;
  std::sort(runs.begin(), runs.end());
  const double n = static_cast<double>(iterations);
  auto above = std::find_if(runs.begin(), runs.end(), [&](const auto& run) { return run.first > n; });
  if (above == runs.begin()) return above->second;  // fewer iterations than any run: at most as long
  const auto& [n2, s2] = *(above - 1);
  double slope = single_share * s2 / n2;
  if (above - runs.begin() >= 2) {
    const auto& [n1, s1] = *(above - 2);
    slope = (s2 - s1) / (n2 - n1);
  }
  const bool start_up_known = above - runs.begin() >= static_cast<std::ptrdiff_t>(runs_to_tell_start_up);
  slope = std::max(slope, (start_up_known ? least_share_known : least_share) * s2 / n2);
  return s2 + slope * (n - n2);
}

// The cost that decides a knob's iteration count: that of the dearest of its class.
double class_cost(const AccuracyLadder& ladder, const AccuracyKnob& knob) {
  if (knob.cost <= cheap_knob) return 1;
  double cost = knob.cost;
  for (const AccuracyKnob& other : ladder.knobs) cost = std::max(cost, other.cost);
  return cost;
}

// Places knobs on the line of the config's method, for one call of next_step.
class KnobPlacer {
 public:
  KnobPlacer(const AccuracyLadder& ladder, const std::vector<TimedPoint>& done, double left_s, double budget_s)
      : ladder_(ladder), done_(done), left_s_(left_s), share_s_(budget_s / share_of_budget) {}

  // Nothing while the line may still come nearer to the knob's share of the budget, or has no run at all.
  std::optional<std::int64_t> iterations(const AccuracyKnob& knob) const {
    if (const auto fixed = fixed_by_earlier(knob)) return fixed;
    const double cost = class_cost(ladder_, knob);
    const std::vector<TimedPoint> line = own_line();
    for (const AccuracyPoint& point : ladder_.lines) {
      if (point.method != ladder_.method || point.iterations == 0 || is_done(done_, point)) continue;
      const auto seconds = predicted_seconds(ladder_, point, done_);
      const bool may_be_start_up = line.size() < runs_to_tell_start_up;
      if (!seconds || (*seconds <= left_s_ && (may_be_start_up || *seconds * cost <= share_s_))) return std::nullopt;
      break;
    }
    std::optional<std::int64_t> least;
    std::optional<std::int64_t> largest;
    for (const TimedPoint& run : line) {
      if (!least || run.point.iterations < *least) least = run.point.iterations;
      if (run.seconds * cost <= share_s_ && (!largest || run.point.iterations > *largest))
        largest = run.point.iterations;
    }
    return largest ? largest : least;
  }

 private:
  // The runs of the config's method with nothing else changed.
  std::vector<TimedPoint> own_line() const {
    std::vector<TimedPoint> line;
    for (const TimedPoint& run : done_)
      if (run.point.method == ladder_.method && run.point.iterations > 0 && !run.point.is_knob()) line.push_back(run);
    return line;
  }

  std::optional<std::int64_t> fixed_by_earlier(const AccuracyKnob& knob) const {
    for (const TimedPoint& run : done_) {
      const AccuracyKnob* const other = run.point.is_knob() ? find_knob(ladder_, run.point) : nullptr;
      if (other != nullptr && class_cost(ladder_, *other) == class_cost(ladder_, knob)) return run.point.iterations;
    }
    return std::nullopt;
  }

  const AccuracyLadder& ladder_;
  const std::vector<TimedPoint>& done_;
  double left_s_;
  double share_s_;
};

bool knob_done(const std::vector<TimedPoint>& done, const AccuracyKnob& knob) {
  return std::any_of(done.begin(), done.end(), [&](const TimedPoint& run) {
    return run.point.setting == knob.setting && run.point.value == knob.value;
  });
}

// Whether the last two points of a line each have a larger R than the one before.
bool line_worsens(Method method, const std::vector<TimedPoint>& done) {
  std::vector<std::pair<std::int64_t, double>> line;  // iterations, R
  for (const TimedPoint& run : done)
    if (run.point.method == method) line.emplace_back(run.point.iterations, run.relative_error);
  std::sort(line.begin(), line.end());
  const std::size_t n = line.size();
  return n >= 3 && line[n - 3].second < line[n - 2].second && line[n - 2].second < line[n - 1].second;
}

std::vector<AccuracyPoint> pending_points(const AccuracyLadder& ladder, const std::vector<TimedPoint>& done,
                                          const std::vector<LeftOut>& failed, const KnobPlacer& placer) {
  std::vector<AccuracyPoint> pending;
  for (const AccuracyPoint& point : ladder.lines)
    if (!is_done(done, point)) pending.push_back(point);
  for (const AccuracyKnob& knob : ladder.knobs) {
    if (knob_done(done, knob)) continue;
    if (const auto iterations = placer.iterations(knob))
      pending.push_back({ladder.method, knob.setting, knob.value, *iterations, false});
  }
  std::erase_if(pending, [&](const AccuracyPoint& point) {
    return std::any_of(failed.begin(), failed.end(), [&](const LeftOut& left) { return left.point == point; });
  });
  return pending;
}

std::vector<LeftOut> all_left_out(const AccuracyLadder& ladder, const std::vector<TimedPoint>& done,
                                  const std::vector<LeftOut>& failed, const std::vector<AccuracyPoint>& pending,
                                  double left_s) {
  std::vector<LeftOut> left_out = failed;
  for (const AccuracyPoint& point : pending) {
    const auto seconds = predicted_seconds(ladder, point, done);
    left_out.push_back({point,
                        seconds ? fmt::format("expected to take {}; {} of the budget were left", seconds_text(*seconds),
                                              seconds_text(std::max(left_s, 0.0)))
                                : "no run says how long it would take",
                        false});
  }
  for (const AccuracyKnob& knob : ladder.knobs) {
    const auto same = [&](const AccuracyPoint& p) { return p.setting == knob.setting && p.value == knob.value; };
    const bool told =
        std::any_of(left_out.begin(), left_out.end(), [&](const LeftOut& left) { return same(left.point); });
    if (!told && !knob_done(done, knob))
      left_out.push_back(
          {{ladder.method, knob.setting, knob.value, 0, false}, "there is no run to compare it with", false});
  }
  return left_out;
}

// A default that stops by its score, say: nobody knows when, so it comes when all else is done.
bool is_tried_last(const AccuracyLadder& ladder, const AccuracyPoint& point) {
  return point.is_default && point.iterations == 0 && point.method != Method::void_and_cluster &&
         !ladder.stop.is_none();
}

}  // namespace

std::string method_name(Method method) {
  return std::find_if(std::begin(method_names), std::end(method_names),
                      [&](const auto& row) { return row.first == method; })
      ->second;
}

std::optional<Method> method_of_name(const std::string& name) {
  for (const auto& [method, its_name] : method_names)
    if (its_name == name) return method;
  return std::nullopt;
}

bool has_iterations(Method method) { return method == Method::anneal || method == Method::fast; }

const AccuracyPoint& AccuracyLadder::default_point() const {
  return *std::find_if(lines.begin(), lines.end(), [](const AccuracyPoint& point) { return point.is_default; });
}

std::string point_name(const AccuracyPoint& point) {
  std::string name = point.is_default ? "default" : method_name(point.method);
  if (point.iterations > 0) name += fmt::format("-{}", point.iterations);
  if (point.is_knob()) name += fmt::format("-{}-{}", point.setting, point.value);
  return name;
}

std::string describe_point(const AccuracyPoint& point) {
  std::string text = method_name(point.method);
  if (point.iterations > 0) {
    text += fmt::format(", {}{} iteration{}", point.method == Method::construct ? "then " : "", point.iterations,
                        point.iterations == 1 ? "" : "s");
  }
  if (point.setting == "background_features")
    text += ", background features " + point.value;
  else if (point.is_knob())
    text += fmt::format(", {} {}", point.setting, point.value);
  return text;
}

LadderTraits ladder_traits(const RunConfig& config, const SampleSource& source) {
  LadderTraits traits;
  traits.constructs = scale_of(config.problem.samples, source.channels()).has_value();
  OptimizerSpec optimizer = config.optimizer;
  if (optimizer.background_features == 0) optimizer.background_features = OptimizerSpec{}.background_features;
  const Footprint footprint(config.problem.extents, config.problem.filter, energy_cutoff(optimizer));
  const ValueKernel kernel = make_value_kernel(config.problem, source.channels(), source.distance());
  if (!features_between_slices(optimizer, footprint, kernel, source, optimizer.background_features)) return traits;
  const auto own_taps = std::max<std::size_t>(footprint.slices().front().taps.size(), 1);
  traits.background = true;
  traits.exact_cost =
      std::max(1.0, cost_of_a_tap * static_cast<double>(footprint.num_taps()) / static_cast<double>(own_taps));
  return traits;
}

AccuracyLadder accuracy_ladder(const RunConfig& config, const LadderTraits& traits, int runs) {
  const OptimizerSpec& optimizer = config.optimizer;
  AccuracyLadder ladder{optimizer.method, optimizer.stop, runs, base_line(optimizer.method, config), {}, {}};
  for (const Method method : {Method::anneal, Method::fast, Method::construct}) {
    if (method == ladder.method || (method == Method::construct && !traits.constructs)) continue;
    const std::vector<AccuracyPoint> line = base_line(method, config);
    ladder.lines.insert(ladder.lines.end(), line.begin(), line.end());
    if (ladder.method == Method::void_and_cluster && !config.order.bounded.empty())
      leave_out(ladder, method, "makes textures that wrap around, while this config has axes that do not");
  }
  if (!has_iterations(ladder.method)) return ladder;
  for (const double cutoff : {0.0, 0.001, 0.01, 0.05})
    if (cutoff != energy_cutoff(optimizer)) ladder.knobs.push_back({"cutoff", shortest_number(cutoff), 1});
  const double exact = optimizer.background_features == 0 ? 1 : traits.exact_cost;
  if (traits.background && optimizer.precision == Precision::float32)
    for (const int count : {0, 4, 8, 16, 32})
      if (count != optimizer.background_features)
        ladder.knobs.push_back({"background_features", std::to_string(count),
                                count == 0    ? exact
                                : count == 32 ? 1.5
                                              : 1});
  const bool is_double = optimizer.precision == Precision::float64;
  ladder.knobs.push_back({"precision", is_double ? "float" : "double", is_double ? 1 : double_cost * exact});
  return ladder;
}

void leave_out(AccuracyLadder& ladder, Method method, const std::string& reason) {
  std::erase_if(ladder.lines, [&](const AccuracyPoint& point) { return point.method == method; });
  ladder.incomparable.push_back({method_point(method), reason, true});
}

std::optional<double> predicted_seconds(const AccuracyLadder& ladder, const AccuracyPoint& point,
                                        const std::vector<TimedPoint>& done) {
  if (point.iterations == 0) {
    if (!is_tried_last(ladder, point) || ladder.stop.time_s <= 0) return std::nullopt;
    return ladder.runs * (ladder.stop.time_s * 1.05 + 0.5);  // start-up and the last sweep
  }
  // Of the other method, whose iterations may be far dearer, a single run promises nothing.
  const auto base = base_seconds(point.method, point.iterations, done, point.method == ladder.method ? least_share : 1);
  const AccuracyKnob* const knob = find_knob(ladder, point);
  return base && knob != nullptr ? *base * knob->cost : base;
}

LadderStep next_step(const AccuracyLadder& ladder, const std::vector<TimedPoint>& done,
                     const std::vector<LeftOut>& not_again, double left_s, double budget_s) {
  std::vector<LeftOut> failed = ladder.incomparable;
  failed.insert(failed.end(), not_again.begin(), not_again.end());
  for (const AccuracyPoint& point : ladder.lines)
    if (point.method != ladder.method && !is_done(done, point) && line_worsens(point.method, done))
      failed.push_back({point, "more iterations made R worse twice in a row", true});
  const KnobPlacer placer(ladder, done, left_s, budget_s);
  const std::vector<AccuracyPoint> pending = pending_points(ladder, done, failed, placer);
  double kept_s = 0;
  for (const AccuracyPoint& point : pending)
    if (const auto seconds = predicted_seconds(ladder, point, done); point.is_default && seconds && *seconds <= left_s)
      kept_s = *seconds;
  const AccuracyPoint* cheapest = nullptr;
  double cheapest_s = 0;
  const AccuracyPoint* unknown = nullptr;
  for (const AccuracyPoint& point : pending) {
    const auto seconds = predicted_seconds(ladder, point, done);
    if (!seconds) {
      // The first of a line is how its speed is found.
      if (unknown == nullptr || (is_tried_last(ladder, *unknown) && !is_tried_last(ladder, point))) unknown = &point;
    } else if (*seconds + (point.is_default ? 0 : kept_s) <= left_s && (cheapest == nullptr || *seconds < cheapest_s)) {
      cheapest = &point;
      cheapest_s = *seconds;
    }
  }
  const bool may_try = unknown != nullptr && left_s - kept_s > 0;
  if (may_try && (!is_tried_last(ladder, *unknown) || cheapest == nullptr)) return {*unknown, {}};
  if (cheapest != nullptr) return {*cheapest, {}};
  return {std::nullopt, all_left_out(ladder, done, failed, pending, left_s)};
}

bool is_on_ladder(const AccuracyLadder& ladder, const AccuracyPoint& point) {
  if (!point.is_knob()) return std::find(ladder.lines.begin(), ladder.lines.end(), point) != ladder.lines.end();
  const bool on_line = std::any_of(ladder.lines.begin(), ladder.lines.end(), [&](const AccuracyPoint& base) {
    return base.method == point.method && base.iterations == point.iterations && point.iterations > 0;
  });
  return on_line && point.method == ladder.method && !point.is_default && find_knob(ladder, point) != nullptr;
}

std::string seconds_text(double seconds) {
  if (seconds < 9.995) return fmt::format("{:.2f} s", seconds);
  if (seconds < 99.95) return fmt::format("{:.1f} s", seconds);
  const auto whole = static_cast<std::int64_t>(std::llround(seconds));
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
}

}  // namespace noiseloom
