#include "noiseloom/anneal/cooling.h"

#include <algorithm>

#include "anneal/fields/tap_plan.h"
#include "noiseloom/anneal/schedule.h"
#include "noiseloom/anneal/swap_choices.h"
#include "noiseloom/core/math.h"

namespace noiseloom {
namespace {

// Measured for the lowest R after 640 to 4,000 iterations, on 128x128 with boxes and gausses and on 32x32x32 with an
// EMA. Against a range that stays as it is, R of scalars and circles falls by 2 to 9 %, of vectors and directions by 1
// to 3 %; a factor of two either way costs a few thousandths.
struct StepSchedule {
  StepRange start;
  StepRange end;
};
StepSchedule step_schedule(DistanceKind kind, int channels) {
  switch (kind) {
    case DistanceKind::absolute:
      return {{16, 2}, {256, 32}};
    case DistanceKind::circle:
      return {{64, 2}, {1024, 32}};
    default:
      return channels <= 2 ? StepSchedule{{64, 2}, {1024, 4}} : StepSchedule{{256, 2}, {4096, 4}};
  }
}

}  // namespace

bool has_given_temperature(const OptimizerSpec& optimizer) {
  return optimizer.temperature_start > 0 || optimizer.temperature_end > 0;
}

bool acts_by_same_pixels(const Footprint& footprint) {
  return footprint.slices().size() > 1 && same_pixels_only(footprint.slices().subspan(1));
}

TemperatureRange temperature_range(const OptimizerSpec& optimizer, const Footprint& footprint, double join) {
  const bool cooler = join == 0 && acts_by_same_pixels(footprint) && !has_given_temperature(optimizer);
  const double start = cooler ? 0.06 : 0.11;
  return {optimizer.temperature_start > 0 ? optimizer.temperature_start : start,
          optimizer.temperature_end > 0 ? optimizer.temperature_end : 8e-4};
}

double cooling_exponent(const OptimizerSpec& optimizer, const Footprint& footprint, bool with_sieve, double join) {
  if (join > 0 || has_given_temperature(optimizer)) return 1;
  const double by_iterations = acts_by_same_pixels(footprint)               ? 2.75
                               : wants_many_features(footprint, with_sieve) ? 0.8
                                                                            : 1;
  return optimizer.stop.time_s > 0 ? 1.3 * by_iterations : by_iterations;
}

TemperatureRange joined_range(const TemperatureRange& whole, double join) {
  return {temperature_at(whole.start, whole.end, join), std::min(whole.end, 3e-4)};
}

bool ends_colder(DistanceKind kind, int channels, bool couples_slices) {
  return kind == DistanceKind::absolute && channels == 1 && !couples_slices;
}

TemperatureRange cold_range() { return {1e-4, 1e-5}; }

double cooling_share(const OptimizerSpec& optimizer, bool couples_slices) {
  return has_given_temperature(optimizer) || couples_slices ? 1 : 0.97;
}

double cold_step_fraction(double fraction) { return 2 * fraction; }

StepRange step_range(DistanceKind kind, int channels, double fraction) {
  const auto [start, end] = step_schedule(kind, channels);
  const auto between = [fraction](double from, double to) { return from * math::exp(fraction * math::log(to / from)); };
  return {between(start.near, end.near), std::max(2.0, between(start.far, end.far))};
}

}  // namespace noiseloom
