#include "noiseloom/anneal/swap_choices.h"

#include <algorithm>

#include "anneal/deltas/sieve.h"
#include "noiseloom/anneal/cooling.h"
#include "noiseloom/problem/colour_classes.h"

namespace noiseloom {

PartnerDraw partners_for(DistanceKind kind, int channels, WindowSize tile, double fraction, int num_strata) {
  return {tile.width * tile.height, step_range(kind, channels, fraction), kind == DistanceKind::circle, num_strata};
}

double energy_cutoff(const OptimizerSpec& optimizer) {
  if (optimizer.cutoff >= 0) return optimizer.cutoff;
  return optimizer.method == Method::fast ? 0 : 1e-3;
}

std::vector<std::vector<SliceIndex>> classes_for(Method method, const Footprint& footprint) {
  if (method == Method::anneal) return colour_classes(footprint);
  const IndexRange<SliceIndex> all = footprint.extents().slices();
  return {std::vector<SliceIndex>(all.begin(), all.end())};
}

// Strata are runs of the ids of a whole slice.
TileGrid tiles_for(const OptimizerSpec& optimizer, const Footprint& footprint,
                   const std::vector<std::vector<SliceIndex>>& classes) {
  return optimizer.method == Method::anneal && optimizer.strata == 1 ? TileGrid(footprint, std::ssize(classes.front()))
                                                                     : TileGrid(footprint);
}

// To take a slice up costs about as much as half an iteration, with a background as much as two, and with a sieve as
// much as four, as iterations are cheaper; but the temperature should not fall in too few steps.
std::int64_t visit_length(const OptimizerSpec& optimizer, std::int64_t num_cells, bool with_background,
                          bool with_sieve) {
  if (optimizer.method != Method::anneal) return 1;
  constexpr std::int64_t steps = 24;
  const std::int64_t longest = with_sieve ? 64 : with_background ? 16 : 8;
  if (optimizer.stop.iterations > 0) return std::clamp<std::int64_t>(optimizer.stop.iterations / steps, 1, longest);
  // The first rounds are short; and the clock is read between sweeps.
  if (!with_sieve) return longest / 2;
  if (optimizer.stop.time_s <= 0) return longest / 4;
  constexpr double candidate_s = 0.08e-6;  // about, on one thread
  const double iteration_s = candidate_s / 2 * static_cast<double>(num_cells);
  const double affordable = std::min(optimizer.stop.time_s / iteration_s / (2 * steps), static_cast<double>(longest));
  return std::max<std::int64_t>(longest / 16, static_cast<std::int64_t>(affordable));
}

std::int64_t cold_visit_length(const OptimizerSpec& optimizer, std::int64_t num_cells, bool with_background,
                               bool with_sieve) {
  if (!with_background) return visit_length(optimizer, num_cells, with_background, with_sieve);
  const std::int64_t longest = with_sieve ? 64 : 32;
  return optimizer.stop.iterations == 0 ? longest : std::clamp<std::int64_t>(optimizer.stop.iterations / 8, 1, longest);
}

bool wants_features(const OptimizerSpec& optimizer, bool has_factors, std::int64_t num_taps, std::int64_t own_taps) {
  // Where the plane has no taps, a few hundred of the same pixel cost no more than features, and miss nothing.
  constexpr std::int64_t cheap_stack = 256;
  const bool cost_much = own_taps == 0 ? num_taps > cheap_stack : num_taps >= 3 * own_taps;
  return optimizer.method == Method::anneal && optimizer.precision != Precision::float64 && has_factors && cost_much;
}

std::optional<FeatureMap> features_between_slices(const OptimizerSpec& optimizer, const Footprint& footprint,
                                                  const ValueKernel& kernel, const SampleSource& source, int count) {
  const auto own_taps = std::ssize(footprint.slices()[0].taps);
  if (count == 0 || !wants_features(optimizer, footprint.factors().has_value(), footprint.num_taps(), own_taps)) {
    return std::nullopt;
  }
  return FeatureMap(kernel, count, source.list(SliceIndex(0)));
}

int num_features(const OptimizerSpec& optimizer, double fraction, bool many) {
  constexpr int most = 64;
  const int times = fraction < 0.75 ? (many ? 4 : 1) : fraction < 0.95 && !many ? 4 : most;
  return std::max(optimizer.background_features, std::min(most, times * optimizer.background_features));
}

// Measured on 32x32x32, with 8 features and with 32 until the last quarter: gauss 1 over time (1.5 here, by
// this sum) 4 % lower R, ema 0.1 0.1 (0.1) the same R for a tenth more time.
bool wants_many_features(const Footprint& footprint, bool with_sieve) {
  if (!with_sieve || !footprint.factors()) return false;
  const auto& along = footprint.factors()->along;
  double squares = 0;
  for (const auto& [offset, weight] : along) squares += weight * weight;
  const double own = along.front().second * along.front().second;
  return squares - own > 0.5 * own;
}

namespace {

// Nanoseconds of a tap: measured, of R for one of a cell and of a candidate for each; the exponential of the stbn
// kernel adds to the latter.
struct TapCost {
  double scored;
  double scored_in_float;
  double judged;
};
TapCost tap_cost(DistanceKind kind) {
  switch (kind) {
    case DistanceKind::angle:
      return {4, 0.35, 1};
    case DistanceKind::euclidean:
      return {0.5, 0.12, 0.3};
    case DistanceKind::axis:
      return {0.8, 0.2, 0.5};
    case DistanceKind::chebyshev:
    case DistanceKind::cosine:
      return {0.3, 0.08, 0.2};
    default:
      return {0.15, 0.05, 0.1};
  }
}
constexpr double stbn_cost = 1.2;

}  // namespace

bool wants_sieve(const OptimizerSpec& optimizer, const ValueKernel& kernel, bool is_served, std::int64_t own_taps) {
  if (optimizer.method != Method::anneal || optimizer.precision == Precision::float64) return false;
  if (!is_served || optimizer.sieve_features == 0) return false;
  // Measured: scalars and circles lose 2 to 6 % of R at equal time, 3x3 boxes of vectors gain nothing.
  const bool one_number = kernel.distance == DistanceKind::absolute || kernel.distance == DistanceKind::circle;
  if (one_number && kernel.kind == ValueKernelKind::distance) return false;
  constexpr double worth_estimating = 8;
  const double cost = tap_cost(kernel.distance).judged + (kernel.kind == ValueKernelKind::stbn ? stbn_cost : 0);
  return cost * static_cast<double>(own_taps) > worth_estimating;
}

std::optional<FeatureMap> features_of_sieve(const OptimizerSpec& optimizer, const Footprint& footprint,
                                            const ValueKernel& kernel, const SampleSource& source) {
  const auto own_taps = std::ssize(footprint.slices()[0].taps);
  if (!wants_sieve(optimizer, kernel, Sieve::serves(footprint), own_taps)) return std::nullopt;
  return FeatureMap(kernel, optimizer.sieve_features, source.list(SliceIndex(0)));
}

double iterations_per_score(DistanceKind kind, std::int64_t scored_taps, bool in_float, std::int64_t judged_taps) {
  const TapCost cost = tap_cost(kind);
  constexpr double candidate = 100;
  const auto taps = static_cast<double>(judged_taps);
  const double score = (in_float ? cost.scored_in_float : cost.scored) * static_cast<double>(scored_taps) / 2;
  return score / ((candidate + 2 * cost.judged * taps) / 2);
}

namespace {
constexpr double share_of_rows = 1.0 / 40;
}

std::int64_t scores_per_round(double iterations_per_score, std::int64_t iterations) {
  constexpr double few_points = 8;  // which a curve needs, so that they may cost more
  constexpr double share_of_few = 1.0 / 20;
  const double worth = static_cast<double>(iterations) / iterations_per_score;  // as many evaluations cost the round
  const double most = std::clamp(share_of_rows * worth, few_points, 50.0);
  return static_cast<std::int64_t>(std::clamp(share_of_few * worth, 1.0, most));
}

std::int64_t score_interval(double iterations_per_score) {
  return static_cast<std::int64_t>(std::clamp(iterations_per_score / share_of_rows, 1.0, 0x1p40));
}

}  // namespace noiseloom
