#include "noiseloom/anneal/engine_choices.h"

#include <algorithm>
#include <numeric>

#include "noiseloom/core/math.h"

#include "noiseloom/anneal/colour_classes.h"

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

TemperatureRange temperature_range(const OptimizerSpec& optimizer) {
  return {optimizer.temperature_start > 0 ? optimizer.temperature_start : 0.11,
          optimizer.temperature_end > 0 ? optimizer.temperature_end : 8e-4};
}

StepRange step_range(DistanceKind kind, int channels, double fraction) {
  const auto [start, end] = step_schedule(kind, channels);
  const auto between = [fraction](double from, double to) { return from * math::exp(fraction * math::log(to / from)); };
  return {between(start.near, end.near), std::max(2.0, between(start.far, end.far))};
}

PartnerDraw partners_for(DistanceKind kind, int channels, WindowSize tile, double fraction) {
  return {tile.width * tile.height, step_range(kind, channels, fraction), kind == DistanceKind::circle};
}

std::vector<std::vector<SliceIndex>> classes_for(Method method, const Footprint& footprint) {
  if (method == Method::anneal) return colour_classes(footprint);
  std::vector<SliceIndex> all(static_cast<std::size_t>(footprint.extents().num_slices()));
  std::iota(all.begin(), all.end(), 0);
  return {all};
}

TileGrid tiles_for(Method method, const Footprint& footprint, const std::vector<std::vector<SliceIndex>>& classes) {
  return method == Method::anneal ? TileGrid(footprint, std::ssize(classes.front())) : TileGrid(footprint);
}

// To take a slice up costs about as much as half an iteration, and with a background as much as two; but the
// temperature should not fall in too few steps.
std::int64_t visit_length(const OptimizerSpec& optimizer, bool with_background) {
  if (optimizer.method != Method::anneal) return 1;
  const std::int64_t longest = with_background ? 16 : 8;
  if (optimizer.stop.iterations == 0) return longest / 2;  // the clock is read between sweeps
  return std::clamp<std::int64_t>(optimizer.stop.iterations / 24, 1, longest);
}

StopSpec in_sweeps(StopSpec stop, std::int64_t per_sweep) {
  stop.iterations = (stop.iterations + per_sweep - 1) / per_sweep;
  return stop;
}

std::optional<FeatureMap> features_between_slices(const OptimizerSpec& optimizer, const Footprint& footprint,
                                                  const ValueKernel& kernel, const SampleSource& source, int rank) {
  const auto own_taps = std::ssize(footprint.slices()[0].taps);
  if (optimizer.method != Method::anneal || optimizer.precision == Precision::dual || rank == 0 ||
      !footprint.factors() || footprint.num_taps() < 3 * own_taps) {
    return std::nullopt;
  }
  return FeatureMap(kernel, rank, source.list(0));
}

int background_rank(const OptimizerSpec& optimizer, double fraction) {
  constexpr int most = 64;
  const int times = fraction < 0.75 ? 1 : fraction < 0.95 ? 4 : most;
  return std::max(optimizer.background_rank, std::min(most, times * optimizer.background_rank));
}

std::int64_t scores_per_round(DistanceKind kind, const Footprint& scored, const Footprint& judged, bool with_background,
                              std::int64_t iterations) {
  // Nanoseconds, measured: of R for a tap of a cell, and of a candidate without and for each tap.
  const double scored_tap = kind == DistanceKind::angle ? 4 : kind == DistanceKind::euclidean ? 0.5 : 0.15;
  const double judged_tap = kind == DistanceKind::angle ? 1 : kind == DistanceKind::euclidean ? 0.3 : 0.1;
  const auto own_taps = static_cast<double>(judged.slices()[0].taps.size());
  const double taps = with_background ? own_taps : static_cast<double>(judged.num_taps());
  const double score = scored_tap * static_cast<double>(scored.num_taps()) / 2;
  const double iteration = (30 + 2 * judged_tap * taps) / 2;
  return std::clamp<std::int64_t>(static_cast<std::int64_t>(static_cast<double>(iterations) * iteration / score / 30),
                                  1, 50);
}

}  // namespace noiseloom
