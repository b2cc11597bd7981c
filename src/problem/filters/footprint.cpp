#include "noiseloom/problem/footprint.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "noiseloom/core/compensated_sum.h"
#include "problem/filters/overlap.h"

namespace noiseloom {
namespace {

Overlap nothing_coupled() { return {{}, {{{}, 1.0}}}; }

Overlap product(std::span<const Overlap> overlaps) {
  Overlap result = nothing_coupled();
  for (const Overlap& overlap : overlaps) result = multiply(result, overlap);
  return result;
}

std::vector<Overlap> product_overlaps(const Extents& extents, const FilterSpec& filter) {
  std::vector<Overlap> overlaps;
  for (const GroupSpec& group : filter.groups) {
    for (Overlap& overlap : group_overlaps(extents, group)) overlaps.push_back(std::move(overlap));
  }
  return overlaps;
}

bool is_zero(const Offset& offset) {
  return std::all_of(offset.begin(), offset.end(), [](std::int32_t d) { return d == 0; });
}

// Drops taps below cutoff * F(0).
void cut(std::vector<OverlapTap>& taps, double cutoff) {
  const auto zero = std::find_if(taps.begin(), taps.end(), [](const OverlapTap& tap) { return is_zero(tap.offset); });
  if (zero == taps.end()) return;
  const double least = cutoff * zero->weight;
  std::erase_if(taps, [&](const OverlapTap& tap) { return !is_zero(tap.offset) && std::abs(tap.weight) < least; });
}

using Reach = std::array<std::int32_t, Extents::max_axes>;

Reach reach_of(std::span<const OverlapTap> taps) {
  Reach reach{};
  for (const OverlapTap& tap : taps) {
    for (std::size_t axis = 0; axis < reach.size(); ++axis) {
      reach[axis] = std::max(reach[axis], std::abs(tap.offset[axis]));
    }
  }
  return reach;
}

// `reach`: that of all taps, those included that are dropped.
std::vector<OverlapTap> sum_taps(const Extents& extents, const FilterSpec& filter, double cutoff, Reach& reach) {
  const bool all_equal =
      std::all_of(filter.groups.begin(), filter.groups.end(), [](const GroupSpec& group) { return group.weight == 0; });
  std::vector<OverlapTap> taps;
  for (const GroupSpec& group : filter.groups) {
    const double weight = all_equal ? 1.0 / static_cast<double>(filter.groups.size()) : group.weight;
    NOISELOOM_CHECK(weight >= 0);
    std::vector<OverlapTap> own = product(group_overlaps(extents, group)).taps;
    const Reach own_reach = reach_of(own);
    std::transform(reach.begin(), reach.end(), own_reach.begin(), reach.begin(),
                   [](std::int32_t a, std::int32_t b) { return std::max(a, b); });
    cut(own, cutoff);
    for (OverlapTap tap : own) {
      tap.weight *= weight;
      taps.push_back(tap);
    }
  }
  return taps;
}

Extents::SliceCoord slice_part(const Offset& offset) {
  Extents::SliceCoord coord{};
  std::copy(offset.begin() + 2, offset.end(), coord.begin());
  return coord;
}

std::vector<PlaneTap> plane_taps(std::span<const OverlapTap> taps) {
  std::vector<PlaneTap> plane;
  for (const OverlapTap& tap : taps) plane.push_back({tap.offset[0], tap.offset[1], tap.weight});
  return plane;
}

// Set where no overlap couples an axis of the plane with a slice axis.
std::optional<Footprint::Factors> product_factors(std::span<const Overlap> overlaps) {
  std::vector<Overlap> plane;
  std::vector<Overlap> along;
  for (const Overlap& overlap : overlaps) {
    const auto in_plane = std::count_if(overlap.axes.begin(), overlap.axes.end(), [](int axis) { return axis < 2; });
    if (in_plane != 0 && in_plane != std::ssize(overlap.axes)) return std::nullopt;
    (in_plane != 0 ? plane : along).push_back(overlap);
  }
  Footprint::Factors factors{plane_taps(ordered(product(plane).taps)), {}};
  for (const OverlapTap& tap : ordered(product(along).taps)) {
    factors.along.emplace_back(slice_part(tap.offset), tap.weight);
  }
  return factors;
}

bool couples_slices(std::span<const OverlapTap> taps) {
  return !taps.empty() && slice_part(taps.back().offset) != Extents::SliceCoord{};
}

}  // namespace

Footprint::Footprint(const Extents& extents, const FilterSpec& filter, double cutoff) : extents_(extents) {
  NOISELOOM_CHECK(!filter.groups.empty());
  NOISELOOM_CHECK(cutoff >= 0);
  std::vector<OverlapTap> taps;
  if (filter.combine == Combine::product) {
    const std::vector<Overlap> overlaps = product_overlaps(extents, filter);
    taps = ordered(product(overlaps).taps);
    factors_ = product_factors(overlaps);
    reach_ = reach_of(taps);
  } else {
    taps = ordered(sum_taps(extents, filter, cutoff, reach_));
  }
  if (!factors_ && !noiseloom::couples_slices(taps)) {
    factors_ = Factors{plane_taps(taps), {{Extents::SliceCoord{}, 1.0}}};
  }
  if (filter.combine == Combine::product) cut(taps, cutoff);

  const auto zero = std::find_if(taps.begin(), taps.end(), [](const OverlapTap& tap) { return is_zero(tap.offset); });
  if (zero == taps.end() || !std::isfinite(zero->weight)) {
    throw UserError("filter", "the taps of its tables are so small or so large that F(0) is zero or infinite");
  }
  weight_zero_ = zero->weight;
  slices_.push_back({Extents::SliceCoord{}, {}});
  CompensatedSum sum;
  sum.add(weight_zero_);
  for (const OverlapTap& tap : taps) {
    if (is_zero(tap.offset)) continue;
    const Extents::SliceCoord slice = slice_part(tap.offset);
    if (slices_.back().offset != slice) slices_.push_back({slice, {}});
    slices_.back().taps.push_back({tap.offset[0], tap.offset[1], tap.weight});
    ++num_taps_;
    sum.add(tap.weight);
  }
  weight_sum_ = sum.value();
}

}  // namespace noiseloom
