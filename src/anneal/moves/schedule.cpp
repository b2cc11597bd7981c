#include "noiseloom/anneal/schedule.h"

#include <algorithm>
#include <bit>

#include "noiseloom/core/math.h"

namespace noiseloom {
namespace {

constexpr std::int64_t first_round_iterations = 100;
// Where rounds are long enough for their gains to follow a rule.
constexpr std::int64_t rounds_before_giving_up = 3;
constexpr double most_gains = 6;

// ln(target / R) in units of what the last round gained: how many rounds as good as that one are still needed.
bool is_out_of_reach(double target, double relative_error, double round_score) {
  if (relative_error >= round_score) return true;
  const double gain = math::log(round_score / relative_error);
  return math::log(relative_error / target) > most_gains * gain;
}

}  // namespace

std::string ended_text(const std::string& reason) {
  if (reason == ended::out_of_reach) return "stop.score, which is out of reach: longer rounds lower R too little";
  if (reason == ended::nothing_to_swap) return "having nothing to do: no swap can change R";
  return "stop." + reason;
}

Schedule::Schedule(const StopSpec& stop, std::int64_t iterations_per_sweep)
    : stop_(stop),
      per_sweep_(iterations_per_sweep),
      first_round_(((stop.iterations > 0 ? stop.iterations : first_round_iterations) + iterations_per_sweep - 1) /
                   iterations_per_sweep) {}

std::int64_t Schedule::iterations_before(std::int64_t sweep) const {
  const std::int64_t iterations = sweep * per_sweep_;
  return stop_.iterations > 0 ? std::min(iterations, stop_.iterations) : iterations;
}

Moment Schedule::moment(std::int64_t sweep, double elapsed_s, double begun_s) const {
  Moment moment;
  moment.sweep_in_round = sweep;
  if (stop_.time_s > 0) {
    const double time_s = stop_.time_s - begun_s;
    moment.fraction = time_s > 0 ? std::clamp((elapsed_s - begun_s) / time_s, 0.0, 1.0) : 1;
    return moment;
  }
  moment.round_length = first_round_;
  if (stop_.iterations <= 0) {
    while (moment.sweep_in_round >= moment.round_length) {
      moment.sweep_in_round -= moment.round_length;
      moment.round_length *= 2;
      ++moment.round;
    }
  }
  const double last = static_cast<double>(std::max<std::int64_t>(moment.round_length - 1, 1));
  moment.fraction = moment.round_length == 1 ? 1 : static_cast<double>(moment.sweep_in_round) / last;
  return moment;
}

std::int64_t Schedule::iterations_of_round(const Moment& moment) const { return moment.round_length * per_sweep_; }

std::string Schedule::ended_by(const Moment& moment, double relative_error, double round_score) const {
  if (stop_.iterations > 0) return moment.ends_round() ? ended::by_iterations : "";
  if (stop_.score > 0) {
    if (relative_error <= stop_.score) return ended::by_score;
    const bool may_give_up = moment.ends_round() && moment.round >= rounds_before_giving_up;
    return may_give_up && is_out_of_reach(stop_.score, relative_error, round_score) ? ended::out_of_reach : "";
  }
  if (stop_.improvement > 0 && moment.ends_round() && moment.round > 0) {
    const double hundreds = static_cast<double>(iterations_of_round(moment)) / 2 / 100;
    if (relative_error > (1 - stop_.improvement * hundreds) * round_score) return ended::by_improvement;
  }
  return "";
}

double joined_fraction(double join, double fraction) { return join + (1 - join) * fraction; }

double cooled(double fraction, double exponent) {
  return fraction <= 0 || exponent == 1 ? fraction : math::exp(exponent * math::log(fraction));
}

double temperature_at(double start, double end, double fraction) {
  return start * math::exp(fraction * math::log(end / start));
}

std::int64_t sweeps_per_fraction(std::int64_t round_length) {
  constexpr std::int64_t least = 100;
  return std::max(least, round_length / 100);
}

bool score_due(const Moment& moment, std::int64_t scores_per_round) {
  const std::int64_t scores = std::min(scores_per_round, moment.round_length);
  const std::int64_t before = moment.sweep_in_round * scores / moment.round_length;
  return (moment.sweep_in_round + 1) * scores / moment.round_length > before;
}

bool score_due_without_end(std::int64_t sweeps, std::int64_t interval) {
  const auto power = static_cast<std::int64_t>(std::bit_floor(static_cast<std::uint64_t>(sweeps)));
  return sweeps % std::max(interval, power / 8) == 0;
}

}  // namespace noiseloom
