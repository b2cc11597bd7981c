#include "construct/order/vac_selector.h"

#include <algorithm>
#include <bit>

namespace noiseloom {

VacSelector::VacSelector(const VacSpec& spec, const VacKernel& kernel) : layout_(spec, 0, spec.extents.num_slices()) {
  for (const VacGroupKernel& group : kernel.groups()) {
    if (VacPlaneBins::suit(layout_, group)) {
      plane_bins_.emplace_back(layout_, group);
    } else {
      bins_.emplace_back(layout_, group);
    }
  }
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

void VacSelector::begin(VacView view, std::span<const VacCandidate> candidates, std::uint64_t limit) {
  const std::size_t n = candidates.size();
  candidates_ = candidates;
  num_picked_ = 0;
  heap_.clear();
  head_.clear();
  current_ = 0;
  if (n == 0) return;
  limit_ = limit;
  mirror_ = static_cast<std::uint32_t>(view);
  at_.resize(n);
  energy_.resize(n);
  next_.resize(n);
  number_.assign(n, none);
  least_ = std::numeric_limits<std::uint32_t>::max();
  // Divisions are most of this loop, so those that are the same for a whole slice are done once for it.
  const auto cells = static_cast<std::uint64_t>(layout_.cells);
  const auto width = static_cast<std::uint64_t>(layout_.size[0]);
  std::uint64_t slice_begin = 0;
  std::uint64_t slice_end = 0;
  VacBins::Coord of_slice{};
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint64_t position = candidates[i].position;
    if (position >= slice_end) {
      slice_begin = position / cells * cells;
      slice_end = slice_begin + cells;
      const VacLayout::Coord at = layout_.coord(slice_begin);
      std::transform(at.begin(), at.end(), of_slice.begin(),
                     [](std::int64_t c) { return static_cast<std::int32_t>(c); });
    }
    const std::uint64_t cell = position - slice_begin;
    at_[i] = of_slice;
    at_[i][1] = static_cast<std::int32_t>(cell / width);
    at_[i][0] = static_cast<std::int32_t>(cell % width);
    energy_[i] = candidates[i].energy;
    least_ = std::min(least_, energy_[i]);
  }
  for (VacBins& bins : bins_) bins.assign(at_);
  for (VacPlaneBins& bins : plane_bins_) bins.assign(at_);
  const std::uint32_t range = static_cast<std::uint32_t>(limit >> 32) - least_;
  shift_ = std::max(0, static_cast<int>(std::bit_width(range)) - static_cast<int>(std::bit_width(n)));
  head_.assign(std::size_t{range >> shift_} + 1, none);
  for (std::uint32_t i = 0; i < n; ++i) put(i);
}

std::size_t VacSelector::take(std::size_t most) {
  const std::uint32_t before = num_picked_;
  while (num_picked_ - before < most) {
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
    number_[i] = num_picked_++;
    for (const VacPlaneBins& bins : plane_bins_) bins.raise(at_[i], energy_);
    for (const VacBins& bins : bins_) {
      bins.visit(at_[i], [&](std::uint32_t j, std::uint32_t weight) { energy_[j] += weight; });
    }
  }
  return num_picked_ - before;
}

}  // namespace noiseloom
