#include "construct/bins/vac_selector.h"

#include <algorithm>
#include <bit>

namespace noiseloom {

VacSelector::VacSelector(const VacSpec& spec, const VacKernel& kernel, bool in_slices)
    : layout_(spec, 0, spec.extents.num_slices()),
      among_own_(layout_, kernel, in_slices ? VacGroupBins::Groups::in_slices : VacGroupBins::Groups::none),
      across_(layout_, kernel, in_slices ? VacGroupBins::Groups::across_slices : VacGroupBins::Groups::all) {}

// Files an own candidate that is not picked under its present key, or forgets it where that is past the limit.
void VacSelector::put(std::uint32_t k) {
  const VacCandidate now{0, energy_[k], candidates_[first_ + k].hash};
  if (now.key() > limit_) return;
  const std::uint32_t bucket = (energy_[k] - least_) >> shift_;
  if (bucket <= current_) {
    heap_.push_back({now.key(), order(k)});
    std::push_heap(heap_.begin(), heap_.end(), Later());
  } else {
    next_[k] = head_[bucket];
    head_[bucket] = k;
  }
}

// Refills the heap from the first bucket that has candidates; leaves it empty when there is none.
void VacSelector::open_next_bucket() {
  while (heap_.empty() && current_ + 1 < head_.size()) {
    ++current_;
    for (std::uint32_t k = head_[current_]; k != none;) {
      const std::uint32_t after = next_[k];
      put(k);
      k = after;
    }
  }
}

// Where all candidates lie.
void VacSelector::locate() {
  // What is the same for a whole slice is found out once for it.
  const auto cells = static_cast<std::uint64_t>(layout_.cells);
  const std::int64_t width = layout_.size[0];
  const double per_cell = 1 / static_cast<double>(width);
  std::uint64_t slice_begin = 0;
  std::uint64_t slice_end = 0;
  VacBins::Coord of_slice{};
  at_.resize(candidates_.size());
  for (std::size_t i = 0; i < at_.size(); ++i) {
    const std::uint64_t position = candidates_[i].position;
    if (position >= slice_end) {
      slice_begin = position / cells * cells;
      slice_end = slice_begin + cells;
      const VacLayout::Coord at = layout_.coord(slice_begin);
      std::transform(at.begin(), at.end(), of_slice.begin(),
                     [](std::int64_t c) { return static_cast<std::int32_t>(c); });
    }
    // Rows by a product, which is faster than a division and may be one row off.
    const auto cell = static_cast<std::int64_t>(position - slice_begin);
    auto y = static_cast<std::int64_t>(static_cast<double>(cell) * per_cell);
    y -= y * width > cell ? 1 : 0;
    y += cell - y * width >= width ? 1 : 0;
    at_[i] = of_slice;
    at_[i][1] = static_cast<std::int32_t>(y);
    at_[i][0] = static_cast<std::int32_t>(cell - y * width);
  }
}

void VacSelector::begin(VacView view, std::span<const VacCandidate> candidates, std::size_t first, std::size_t last,
                        std::uint64_t limit) {
  const std::size_t n = last - first;
  view_ = view;
  limit_ = limit;
  candidates_ = candidates;
  first_ = static_cast<std::uint32_t>(first);
  picks_.clear();
  waiting_.clear();
  heap_.clear();
  head_.clear();
  current_ = 0;
  locate();
  among_own_.assign(std::span<const VacBins::Coord>(at_).subspan(first, n));
  across_.assign(at_);
  energy_.resize(n);
  next_.resize(n);
  if (n == 0) return;
  least_ = std::numeric_limits<std::uint32_t>::max();
  for (std::size_t k = 0; k < n; ++k) {
    energy_[k] = candidates[first + k].energy;
    least_ = std::min(least_, energy_[k]);
  }
  const std::uint32_t range = static_cast<std::uint32_t>(limit >> 32) - least_;
  shift_ = std::max(0, static_cast<int>(std::bit_width(range)) - static_cast<int>(std::bit_width(n)));
  head_.assign(std::size_t{range >> shift_} + 1, none);
  for (std::uint32_t k = 0; k < n; ++k) put(k);
}

// Has own candidate k, the least that is left, raise those around it; unless it has to wait, when they have to wait for
// it.
bool VacSelector::wait_or_raise(std::uint32_t k, std::uint64_t key) {
  const VacBins::Coord& at = at_[first_ + k];
  const auto is_own = [&](std::uint32_t i) { return i - first_ < energy_.size(); };
  hits_.clear();
  across_.find(at, hits_);
  const bool waits = is_behind_[k] || std::ranges::any_of(hits_, [&](const VacGroupBins::Hit& hit) {
                       return !is_own(hit.index) && candidates_[hit.index].key() <= key;
                     });
  if (!waits) among_own_.raise(at, energy_);
  for (const VacGroupBins::Hit& hit : hits_) {
    if (!is_own(hit.index)) continue;
    if (waits) {
      is_behind_[hit.index - first_] = true;
    } else {
      energy_[hit.index - first_] += hit.weight;
    }
  }
  if (waits) {
    hits_.clear();
    among_own_.find(at, hits_);
    for (const VacGroupBins::Hit& hit : hits_) is_behind_[hit.index] = true;
  }
  return waits;
}

void VacSelector::pick() {
  const bool alone = energy_.size() == candidates_.size();
  if (!alone) is_behind_.assign(energy_.size(), false);
  while (true) {
    if (heap_.empty()) open_next_bucket();
    if (heap_.empty()) break;
    std::pop_heap(heap_.begin(), heap_.end(), Later());
    const VacPick least = heap_.back();
    heap_.pop_back();
    const std::uint32_t k = least.index(view_) - first_;
    if (static_cast<std::uint32_t>(least.key >> 32) != energy_[k]) {  // raised since it was filed
      put(k);
    } else if (alone) {
      picks_.push_back(least);
      among_own_.raise(at_[k], energy_);
      across_.raise(at_[k], energy_);
    } else if (wait_or_raise(k, least.key)) {
      waiting_.push_back(least);
    } else {
      picks_.push_back(least);
    }
  }
}

}  // namespace noiseloom
