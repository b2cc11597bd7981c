#include "construct/bins/vac_bins.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace noiseloom {

VacBins::VacBins(const VacLayout& layout, const VacGroupKernel& group) : edges_(group.edges) {
  std::vector<int> indices{group.axis0};
  indices.insert(indices.end(), group.others.begin(), group.others.end());
  for (const int index : indices) {
    const auto a = static_cast<std::size_t>(index);
    axes_.push_back({a, narrow<std::int32_t>(layout.size[a]), layout.toroidal[a], 0, 0, 0, 0, 0, 0});
  }
  for (const VacRow& row : group.rows) {
    axes_[0].lo = std::max(axes_[0].lo, row.lo);
    axes_[0].hi = std::max(axes_[0].hi, row.hi);
    for (std::size_t i = 1; i < axes_.size(); ++i) {
      axes_[i].lo = std::max(axes_[i].lo, -row.offset[i - 1]);
      axes_[i].hi = std::max(axes_[i].hi, row.offset[i - 1]);
    }
  }
  std::int64_t num_bins = 1;
  std::int64_t num_weights = 1;
  for (Axis& axis : axes_) {
    const auto reach = static_cast<std::uint32_t>(std::max(axis.lo, axis.hi)) + 1;
    axis.shift = static_cast<int>(std::bit_width(reach - 1)) + (axes_.size() == 1 ? 2 : 0);
    axis.num_bins = ((axis.size - 1) >> axis.shift) + 1;
    axis.bin_stride = num_bins;
    axis.weight_stride = num_weights;
    num_bins *= axis.num_bins;
    num_weights *= axis.lo + axis.hi + 1;
  }
  for (int index = 0; index < layout.num_axes; ++index) {
    if (std::find(indices.begin(), indices.end(), index) != indices.end()) continue;
    fixed_stride_.push_back({static_cast<std::size_t>(index), num_bins});
    num_bins *= layout.size[static_cast<std::size_t>(index)];
  }
  weights_.assign(static_cast<std::size_t>(num_weights), 0);
  for (const VacRow& row : group.rows) {
    std::int64_t at = axes_[0].lo - row.lo;
    for (std::size_t i = 1; i < axes_.size(); ++i) at += (row.offset[i - 1] + axes_[i].lo) * axes_[i].weight_stride;
    std::copy_n(group.weights.begin() + static_cast<std::ptrdiff_t>(row.first), row.lo + row.hi + 1,
                weights_.begin() + at);
  }
}

std::int64_t VacBins::bin(const Coord& at) const {
  std::int64_t result = 0;
  for (const auto& [axis, stride] : fixed_stride_) result += at[axis] * stride;
  for (const Axis& axis : axes_) result += (at[axis.index] >> axis.shift) * axis.bin_stride;
  return result;
}

void VacBins::assign(std::span<const Coord> at) {
  const int slots_log2 = static_cast<int>(std::bit_width(at.size())) + 2;
  slot_shift_ = 64 - slots_log2;
  heads_.assign(std::size_t{1} << slots_log2, none);
  at_ = at;
  bin_.resize(at.size());
  next_.resize(at.size());
  for (std::uint32_t i = 0; i < at.size(); ++i) {
    bin_[i] = bin(at[i]);
    next_[i] = std::exchange(heads_[slot(bin_[i])], i);
  }
}

// The bins along one axis that the footprint of coordinate c meets, each once, times their stride.
std::size_t VacBins::bins_met(const Axis& axis, std::int32_t c, std::array<std::int64_t, max_bins_met>& bins) const {
  std::int32_t first = c - axis.lo;
  std::int32_t last = c + axis.hi;
  if (!axis.toroidal) {
    first = std::max(first, 0);
    last = std::min(last, axis.size - 1);
  } else if (last - first + (2 << axis.shift) >= axis.size) {  // might come round to its first bin: take all (4 or 5)
    first = 0;
    last = axis.size - 1;
  } else {
    if (first < 0) first += axis.size;
    if (last >= axis.size) last -= axis.size;
  }
  std::size_t count = 0;
  const std::int32_t end = last >> axis.shift;
  for (std::int32_t b = first >> axis.shift;; b = b + 1 == axis.num_bins ? 0 : b + 1) {
    bins[count++] = b * axis.bin_stride;
    if (b == end) return count;
  }
}

}  // namespace noiseloom
