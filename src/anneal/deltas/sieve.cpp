#include "anneal/deltas/sieve.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "anneal/fields/tap_plan.h"

namespace noiseloom {
namespace {

// Of a plane that is nearly a product of its rows and columns (a cut-off took its corners); features miss more.
constexpr double nearly_separable_within = 3e-4;

double weight_at(std::span<const PlaneTap> taps, std::int32_t dx, std::int32_t dy) {
  const auto tap = std::find_if(taps.begin(), taps.end(), [&](const PlaneTap& t) { return t.dx == dx && t.dy == dy; });
  return tap == taps.end() ? 0 : tap->weight;
}

// The weight that makes a product of rows and columns of a plane whose centre is not among its taps: of a sum, F(0)
// holds more than the plane's own.
double centre_of(std::span<const PlaneTap> taps, double weight_zero) {
  const double corner = weight_at(taps, 1, 1);
  const double centre = corner != 0 ? weight_at(taps, 1, 0) * weight_at(taps, 0, 1) / corner : 0;
  return centre > 0 && centre < 2 * weight_zero ? centre : weight_zero;
}

}  // namespace

double Sieve::least_weight_told(std::span<const PlaneTap> taps) {
  if (taps.empty()) return 0;
  std::vector<double> weights;
  for (const PlaneTap& tap : taps) weights.push_back(std::abs(tap.weight));
  std::sort(weights.begin(), weights.end());
  double left = most_untold * std::accumulate(weights.begin(), weights.end(), 0.0);
  for (const double weight : weights) {
    left -= weight;
    if (left < 0 || weight >= least_change_told * weights.back()) return weight;
  }
  return weights.back();
}

bool Sieve::serves(const Footprint& footprint) {
  return footprint.factors().has_value() || same_pixels_only(footprint.slices().subspan(1));
}

Sieve::Sieve(const Footprint& footprint, const FeatureMap& map, WindowSize window)
    : map_(map),
      layout_(footprint, map.channels(), window),
      num_lanes_(padded_lanes(map)),
      others_by_planes_(footprint.factors().has_value()),
      around_(footprint, layout_),
      mixing_(padded_mixing(map, num_lanes_)),
      sums_(static_cast<std::size_t>(layout_.plane_size * map.num_features())),
      scratch_(sums_.size()),
      features_(static_cast<std::size_t>(num_lanes_ * layout_.width * layout_.height) / block_lanes),
      pulls_(features_.size()),
      change_(static_cast<std::size_t>(num_lanes_) / block_lanes) {
  NOISELOOM_CHECK(serves(footprint) && num_lanes_ <= most_mixed_lanes);
  plan_own(footprint);
  plan_others(footprint);
  if (!others_by_planes_ && !around_.empty()) stack_.resize(sums_.size());
}

void Sieve::plan_own(const Footprint& footprint) {
  std::vector<PlaneTap> taps = footprint.slices()[0].taps;
  const double least = least_weight_told(taps);
  for (const PlaneTap& tap : taps) {
    if (std::abs(tap.weight) < least) continue;
    const bool goes_on = !rows_.empty() && rows_.back().dy == tap.dy && rows_.back().dx + rows_.back().count == tap.dx;
    if (!goes_on) rows_.push_back({tap.dx, tap.dy, std::ssize(weights_), 0});
    ++rows_.back().count;
    weights_.push_back(static_cast<float>(tap.weight));
  }
  const double centre = centre_of(taps, footprint.weight_zero());
  centre_ = static_cast<float>(centre);
  taps.push_back({0, 0, centre});
  filter_ = make_plane_filter(taps, layout_, nearly_separable_within);
}

void Sieve::plan_others(const Footprint& footprint) {
  if (others_by_planes_) {
    const double own = footprint.factors()->along.front().second;
    for (const auto& [offset, weight] : weights_along(footprint)) {
      around_.add(offset, weight / own);
    }
    return;
  }
  for (const SliceTaps& slice : footprint.slices().subspan(1)) {
    around_.add(slice.offset, slice.taps[0].weight);
  }
}

void Sieve::bind(SliceIndex slice, Corner corner, const SliceField& own, const FieldOf& others) {
  const int count = map_.num_features();
  const int lanes = static_cast<int>(num_lanes_);
  const WeightedField self[] = {{&own, 1}};
  sum_features(map_, layout_, self, sums_.data());
  gather_cells(layout_, nullptr, lanes, count, sums_.data(), num_lanes_, values_of(features_));

  std::vector<WeightedField> around = around_.fields(slice, corner, others);
  if (others_by_planes_ && !around.empty()) {
    around.push_back(self[0]);
    sum_features(map_, layout_, around, sums_.data());
  } else if (!around.empty()) {
    sum_features(map_, layout_, around, stack_.data());
  }
  fill_borders(layout_, count, sums_.data());
  const bool in_place = filter_planes(filter_, layout_, count, sums_.data(), scratch_.data()) == sums_.data();
  float* const filtered = in_place ? sums_.data() : scratch_.data();
  for (std::size_t k = 0; k < stack_.size(); ++k) filtered[k] += stack_[k];
  gather_cells(layout_, nullptr, lanes, count, filtered, num_lanes_, values_of(pulls_));
  // The filter's centre is the cell itself, whose sample does not act on itself.
  mix_cells(mixing_.data(), num_lanes_, layout_.width * layout_.height, values_of(features_), -centre_,
            values_of(pulls_));
}

void Sieve::estimate(std::span<const CellPair> pairs, float* out) const {
  estimate_swaps(values_of(features_), values_of(pulls_), num_lanes_, pairs, out);
}

void Sieve::swap(CellPair pair) {
  float* const i = values_of(features_) + std::int64_t{pair.i} * num_lanes_;
  float* const j = values_of(features_) + std::int64_t{pair.j} * num_lanes_;
  mix_difference(mixing_.data(), num_lanes_, j, i, values_of(change_));
  std::swap_ranges(i, i + num_lanes_, j);
  add_at(pair.i, 1);
  add_at(pair.j, -1);
}

void Sieve::add_at(Cell cell, float sign) {
  const std::int64_t y = layout_.divider.y(cell);
  add_footprint({rows_, weights_.data()}, layout_, cell - y * layout_.width, y, values_of(change_), sign, num_lanes_,
                values_of(pulls_));
}

}  // namespace noiseloom
