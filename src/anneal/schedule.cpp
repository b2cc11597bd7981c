#include "noiseloom/anneal/schedule.h"

#include <algorithm>

#include "noiseloom/core/math.h"

namespace noiseloom {
namespace {

constexpr std::int64_t first_round = 100;

}  // namespace

Moment moment_of(const StopSpec& stop, std::int64_t sweep, double elapsed_s) {
  Moment moment;
  if (stop.time_s > 0) {
    moment.sweep_in_round = sweep;
    moment.fraction = std::clamp(elapsed_s / stop.time_s, 0.0, 1.0);
    return moment;
  }
  moment.round_length = stop.iterations > 0 ? stop.iterations : first_round;
  moment.sweep_in_round = sweep;
  if (stop.iterations <= 0) {
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

double temperature_at(double start, double end, double fraction) {
  return start * math::exp(fraction * math::log(end / start));
}

bool score_due(const Moment& moment, std::int64_t scores_per_round) {
  if (moment.ends_round()) return true;
  const std::int64_t every = std::max<std::int64_t>(1, moment.round_length / scores_per_round);
  return moment.sweep_in_round % every == every - 1;
}

}  // namespace noiseloom
