#include "anneal/deltas/background.h"

#include <algorithm>
#include <cmath>

#include "anneal/deltas/background_simd.h"

namespace noiseloom {
namespace {

constexpr double separable_within = 1e-6;

}  // namespace

Background::Filter make_plane_filter(std::span<const PlaneTap> taps, const FieldLayout& layout, double within) {
  const auto width = static_cast<std::size_t>(2 * layout.reach_x + 1);
  const auto height = static_cast<std::size_t>(2 * layout.reach_y + 1);
  std::vector<double> table(width * height);
  Background::Filter filter;
  // Taps beyond the reach were cut off.
  for (const PlaneTap& tap : taps) {
    if (std::abs(tap.dx) > layout.reach_x || std::abs(tap.dy) > layout.reach_y) continue;
    table[static_cast<std::size_t>(tap.dy + layout.reach_y) * width +
          static_cast<std::size_t>(tap.dx + layout.reach_x)] = tap.weight;
    filter.taps.push_back(tap);
  }
  const auto centre_x = static_cast<std::size_t>(layout.reach_x);
  const auto centre_y = static_cast<std::size_t>(layout.reach_y);
  const double zero = table[centre_y * width + centre_x];
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      const double product = table[y * width + centre_x] * table[centre_y * width + x];
      if (std::abs(product - table[y * width + x] * zero) > within * zero * zero) return filter;
    }
  }
  filter.taps.clear();
  for (std::size_t x = 0; x < width; ++x) filter.along_x.push_back(static_cast<float>(table[centre_y * width + x]));
  for (std::size_t y = 0; y < height; ++y) {
    filter.along_y.push_back(static_cast<float>(table[y * width + centre_x] / zero));
  }
  return filter;
}

std::vector<std::pair<Extents::SliceCoord, double>> weights_along(const Footprint& footprint) {
  // Slices that weigh less than this share of the own one are left out: a long ring of frames would otherwise cost in
  // proportion to its length, for far less than what the features miss. R and exact taps keep them.
  constexpr double negligible = 1e-4;
  std::vector<std::pair<Extents::SliceCoord, double>> weights;
  const auto& along = footprint.factors()->along;
  for (const SliceTaps& slice : footprint.slices().subspan(1)) {
    const auto factor =
        std::find_if(along.begin(), along.end(), [&](const auto& entry) { return entry.first == slice.offset; });
    NOISELOOM_CHECK(factor != along.end());
    if (std::abs(factor->second) >= negligible * std::abs(along.front().second)) weights.push_back(*factor);
  }
  return weights;
}

std::vector<float> padded_mixing(const FeatureMap& map, std::int64_t num_lanes) {
  const auto lanes = static_cast<std::size_t>(num_lanes);
  std::vector<float> mixing(lanes * lanes);
  const auto count = static_cast<std::size_t>(map.num_features());
  for (std::size_t m = 0; m < count; ++m) {
    for (std::size_t n = 0; n < count; ++n) {
      mixing[m * lanes + n] = static_cast<float>(map.mixing()[m * count + n]);
    }
  }
  return mixing;
}

std::int64_t padded_lanes(const FeatureMap& map) {
  constexpr auto block = std::int64_t{block_lanes};
  return (map.num_features() + block - 1) / block * block;
}

std::vector<WeightedField> SlicesAround::fields(SliceIndex slice, Corner corner, const FieldOf& others) {
  std::vector<WeightedField> around;
  if (!window_.whole()) windows_.resize(weights_.size(), SliceField(window_));
  for (std::size_t k = 0; k < weights_.size(); ++k) {
    const SliceField& other = others(footprint_.extents().slice_at(slice, weights_[k].first));
    if (!window_.whole()) windows_[k].copy_window(other, corner);
    around.push_back({window_.whole() ? &other : &windows_[k], weights_[k].second});
  }
  return around;
}

Background::Background(const Footprint& footprint, const FeatureMap& map, WindowSize window)
    : map_(map),
      layout_(footprint, map.channels(), window),
      num_lanes_(padded_lanes(map)),
      around_(footprint, layout_),
      filter_(make_plane_filter(footprint.factors()->plane, layout_, separable_within)),
      mixing_(padded_mixing(map, num_lanes_)),
      sums_(static_cast<std::size_t>(layout_.plane_size * map.num_features())),
      scratch_(sums_.size()),
      cells_(static_cast<std::size_t>(2 * num_lanes_ * layout_.width * layout_.height) / block_lanes) {
  for (const auto& [offset, weight] : weights_along(footprint)) around_.add(offset, weight);
}

void Background::bind(SliceIndex slice, Corner corner, const SliceField& own, const FieldOf& others) {
  const int count = map_.num_features();
  const int lanes = static_cast<int>(num_lanes_);
  const WeightedField self[] = {{&own, 1}};
  sum_features(map_, layout_, self, sums_.data());
  gather_cells(layout_, nullptr, lanes, count, sums_.data(), 2 * num_lanes_, values_of(cells_));

  sum_features(map_, layout_, around_.fields(slice, corner, others), sums_.data());
  fill_borders(layout_, count, sums_.data());
  const float* filtered = filter_planes(filter_, layout_, count, sums_.data(), scratch_.data());
  gather_cells(layout_, mixing_.data(), lanes, count, filtered, 2 * num_lanes_, values_of(cells_) + num_lanes_);
}

void Background::swap(CellPair pair) {
  float* const cells = values_of(cells_);
  float* const i = cells + std::int64_t{pair.i} * 2 * num_lanes_;
  std::swap_ranges(i, i + num_lanes_, cells + std::int64_t{pair.j} * 2 * num_lanes_);
}

}  // namespace noiseloom
