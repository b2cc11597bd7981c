#include "optimize/vac_selector.h"

#include <algorithm>
#include <bit>

namespace noiseloom {

VacSelector::Bins::Bins(const VacLayout& layout, const VacGroupKernel& group) {
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
  head_.assign(static_cast<std::size_t>(num_bins), none);
  weights_.assign(static_cast<std::size_t>(num_weights), 0);
  for (const VacRow& row : group.rows) {
    std::int64_t at = axes_[0].lo - row.lo;
    for (std::size_t i = 1; i < axes_.size(); ++i) at += (row.offset[i - 1] + axes_[i].lo) * axes_[i].weight_stride;
    std::copy_n(group.weights.begin() + static_cast<std::ptrdiff_t>(row.first), row.lo + row.hi + 1,
                weights_.begin() + at);
  }
}

std::int64_t VacSelector::Bins::bin(const Coord& at) const {
  std::int64_t result = 0;
  for (const auto& [axis, stride] : fixed_stride_) result += at[axis] * stride;
  for (const Axis& axis : axes_) result += (at[axis.index] >> axis.shift) * axis.bin_stride;
  return result;
}

void VacSelector::Bins::enter(const std::vector<Coord>& at) {
  next_.resize(at.size());
  for (std::size_t i = 0; i < at.size(); ++i) {
    std::uint32_t& head = head_[static_cast<std::size_t>(bin(at[i]))];
    next_[i] = head;
    head = static_cast<std::uint32_t>(i);
  }
}

void VacSelector::Bins::leave(const std::vector<Coord>& at) {
  for (const Coord& c : at) head_[static_cast<std::size_t>(bin(c))] = none;
}

// The bins along one axis that the footprint of coordinate c meets, each once, times their stride.
std::size_t VacSelector::Bins::bins_met(const Axis& axis, std::int32_t c,
                                        std::array<std::int64_t, max_bins_met>& bins) const {
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

std::uint32_t VacSelector::Bins::weight(const Coord& from, const Coord& to) const {
  std::int64_t index = 0;
  for (const Axis& axis : axes_) {
    std::int32_t d = to[axis.index] - from[axis.index];
    if (axis.toroidal) d += d > axis.hi ? -axis.size : d < -axis.lo ? axis.size : 0;
    if (d < -axis.lo || d > axis.hi) return 0;
    index += (d + axis.lo) * axis.weight_stride;
  }
  return weights_[static_cast<std::size_t>(index)];
}

void VacSelector::Bins::raise(const std::vector<Coord>& at, std::size_t i, std::vector<std::uint32_t>& energy) const {
  const Coord& from = at[i];
  std::array<std::array<std::int64_t, max_bins_met>, Extents::max_axes> bins;
  std::array<std::size_t, Extents::max_axes> count;
  std::array<std::size_t, Extents::max_axes> step{};
  std::int64_t base = 0;
  for (const auto& [axis, stride] : fixed_stride_) base += from[axis] * stride;
  for (std::size_t a = 0; a < axes_.size(); ++a) count[a] = bins_met(axes_[a], from[axes_[a].index], bins[a]);
  while (true) {
    std::int64_t outer = base;
    for (std::size_t a = 1; a < axes_.size(); ++a) outer += bins[a][step[a]];
    for (std::size_t b = 0; b < count[0]; ++b) {
      for (std::uint32_t j = head_[static_cast<std::size_t>(outer + bins[0][b])]; j != none; j = next_[j]) {
        energy[j] += weight(from, at[j]);
      }
    }
    std::size_t a = 1;
    while (a < axes_.size() && ++step[a] == count[a]) step[a++] = 0;
    if (a >= axes_.size()) return;
  }
}

VacSelector::VacSelector(const VacSpec& spec, const VacKernel& kernel) : layout_(spec, 0, spec.extents.num_slices()) {
  for (const VacGroupKernel& group : kernel.groups()) bins_.emplace_back(layout_, group);
}

// Files a candidate that is not picked under its present key, or forgets it where that is past the limit.
void VacSelector::put(std::uint32_t i) {
  const VacCandidate now{0, energy_[i], candidates_[i].hash};
  if (now.key() > limit_) return;
  const std::uint32_t bucket = (energy_[i] - least_) >> shift_;
  if (bucket <= current_) {
    heap_.push_back({now.key(), i ^ mirror_});
    std::push_heap(heap_.begin(), heap_.end());
  } else {
    next_[i] = head_[bucket];
    head_[bucket] = i;
  }
}

// Refills the heap from the first bucket that has candidates; leaves it empty when there is none.
void VacSelector::open_next_bucket() {
  while (heap_.empty() && current_ + 1 < head_.size()) {
    ++current_;
    for (std::uint32_t i = head_[current_]; i != none;) {
      const std::uint32_t after = next_[i];
      put(i);
      i = after;
    }
  }
}

void VacSelector::select(VacView view, std::span<const VacCandidate> candidates, std::uint64_t limit,
                         std::size_t max_picks, std::vector<std::uint32_t>& picks) {
  picks.clear();
  const std::size_t n = candidates.size();
  if (n == 0) return;
  candidates_ = candidates;
  limit_ = limit;
  mirror_ = static_cast<std::uint32_t>(view);
  at_.resize(n);
  energy_.resize(n);
  next_.resize(n);
  picked_.assign(n, 0);
  least_ = std::numeric_limits<std::uint32_t>::max();
  for (std::size_t i = 0; i < n; ++i) {
    const VacLayout::Coord at = layout_.coord(candidates[i].position);
    std::transform(at.begin(), at.end(), at_[i].begin(), [](std::int64_t c) { return static_cast<std::int32_t>(c); });
    energy_[i] = candidates[i].energy;
    least_ = std::min(least_, energy_[i]);
  }
  for (Bins& bins : bins_) bins.enter(at_);
  const std::uint32_t range = static_cast<std::uint32_t>(limit >> 32) - least_;
  shift_ = std::max(0, static_cast<int>(std::bit_width(range)) - static_cast<int>(std::bit_width(n)));
  head_.assign(std::size_t{range >> shift_} + 1, none);
  heap_.clear();
  current_ = 0;
  for (std::uint32_t i = 0; i < n; ++i) put(i);
  while (picks.size() < max_picks) {
    if (heap_.empty()) open_next_bucket();
    if (heap_.empty()) break;
    std::pop_heap(heap_.begin(), heap_.end());
    const Entry entry = heap_.back();
    heap_.pop_back();
    const std::uint32_t i = entry.order ^ mirror_;
    if (static_cast<std::uint32_t>(entry.key >> 32) != energy_[i]) {  // raised since it was filed
      put(i);
      continue;
    }
    picked_[i] = 1;
    picks.push_back(i);
    for (const Bins& bins : bins_) bins.raise(at_, i, energy_);
  }
  for (Bins& bins : bins_) bins.leave(at_);
}

}  // namespace noiseloom
