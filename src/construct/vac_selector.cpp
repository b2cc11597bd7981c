#include "construct/vac_selector.h"

#include <algorithm>
#include <bit>

namespace noiseloom {

VacSelector::VacSelector(const VacSpec& spec, const VacKernel& kernel, std::int32_t begin, std::int32_t end)
    : layout_(spec, 0, spec.extents.num_slices()),
      begin_(static_cast<std::uint64_t>(layout_.cells * begin)),
      end_(static_cast<std::uint64_t>(layout_.cells * end)) {
  for (const VacGroupKernel& group : kernel.groups()) {
    if (VacPlaneBins::suit(layout_, group)) {
      plane_bins_.emplace_back(layout_, group);
    } else {
      bins_.emplace_back(layout_, group);
    }
  }
}

VacBins::Coord VacSelector::coord(std::uint64_t position) const {
  const VacLayout::Coord at = layout_.coord(position);
  VacBins::Coord result;
  std::transform(at.begin(), at.end(), result.begin(), [](std::int64_t c) { return static_cast<std::int32_t>(c); });
  return result;
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

// All candidates that are not picked, anew.
void VacSelector::file_all() {
  std::fill(head_.begin(), head_.end(), none);
  heap_.clear();
  current_ = 0;
  for (std::uint32_t i = 0; i < candidates_.size(); ++i) {
    if (!picked(i)) put(i);
  }
}

void VacSelector::begin(VacView view, std::span<const VacCandidate> candidates, std::uint64_t limit) {
  const std::size_t n = candidates.size();
  view_ = view;
  candidates_ = candidates;
  limit_ = limit;
  mirror_ = static_cast<std::uint32_t>(view);
  picks_.clear();
  num_settled_ = 0;
  at_.resize(n);
  energy_.resize(n);
  next_.resize(n);
  picked_.assign(n, 0);
  least_ = static_cast<std::uint32_t>(limit >> 32);
  for (std::size_t i = 0; i < n; ++i) {
    at_[i] = coord(candidates[i].position);
    energy_[i] = candidates[i].energy;
    least_ = std::min(least_, energy_[i]);
  }
  for (VacBins& bins : bins_) bins.assign(at_);
  for (VacPlaneBins& bins : plane_bins_) bins.assign(at_);
  const std::uint32_t range = static_cast<std::uint32_t>(limit >> 32) - least_;
  shift_ = std::max(0, static_cast<int>(std::bit_width(range)) - static_cast<int>(std::bit_width(n)));
  head_.resize(std::size_t{range >> shift_} + 1);
  file_all();
}

void VacSelector::raise_around(std::uint32_t i) {
  for (const VacPlaneBins& bins : plane_bins_) bins.raise(at_[i], energy_);
  for (const VacBins& bins : bins_) {
    bins.visit(at_[i], [&](std::uint32_t j, std::uint32_t weight) { energy_[j] += weight; });
  }
}

// What a pick in a slice of others does here.
void VacSelector::raise_across(const VacOffer& of_others) {
  const VacBins::Coord at = coord(position_of(view_, of_others));
  for (const VacPlaneBins& bins : plane_bins_) {
    if (bins.crosses_slices()) bins.raise(at, energy_);
  }
  for (const VacBins& bins : bins_) {
    if (!bins.crosses_slices()) continue;
    bins.visit(at, [&](std::uint32_t j, std::uint32_t weight) { energy_[j] += weight; });
  }
}

void VacSelector::pick(std::size_t wanted_open) {
  while (num_open() < wanted_open) {
    if (heap_.empty()) open_next_bucket();
    if (heap_.empty()) return;
    std::pop_heap(heap_.begin(), heap_.end());
    const Entry entry = heap_.back();
    heap_.pop_back();
    const std::uint32_t i = entry.order ^ mirror_;
    if (static_cast<std::uint32_t>(entry.key >> 32) != energy_[i]) {  // raised since it was filed
      put(i);
      continue;
    }
    picked_[i] = 1;
    picks_.push_back({vac_offer(view_, entry.key, candidates_[i].position), i, energy_[i]});
    raise_around(i);
  }
}

VacOffer VacSelector::hear(std::span<const VacOffer> picks) {
  for (std::size_t k = num_settled_; k < picks_.size(); ++k) picks_[k].energy = energy_[picks_[k].index];
  VacOffer fallen;
  std::size_t own = num_settled_;
  const auto look_up_to = [&](const VacOffer& bound) {
    for (; own < picks_.size() && picks_[own].offer < bound; ++own) {
      const Pick& pick = picks_[own];
      if (energy_[pick.index] != pick.energy) fallen = std::min(fallen, pick.offer);
    }
  };
  for (const VacOffer& pick : picks) {
    if (has(pick)) continue;
    look_up_to(pick);
    raise_across(pick);
  }
  look_up_to({});
  return fallen;
}

// Undoes what `raise` does.
template <class Raise>
void VacSelector::lower(const Raise& raise) {
  const auto complement = [&] {
    for (std::uint32_t& energy : energy_) energy = ~energy;
  };
  complement();
  raise();
  complement();
}

void VacSelector::settle(std::span<const VacOffer> picks, std::size_t num_settled, const VacOffer& fallen) {
  const auto settled = picks.first(num_settled);
  const auto forgotten = picks.subspan(num_settled);
  num_settled_ += static_cast<std::size_t>(
      std::count_if(settled.begin(), settled.end(), [&](const VacOffer& pick) { return has(pick); }));
  const bool forgets =
      std::any_of(forgotten.begin(), forgotten.end(), [&](const VacOffer& pick) { return !has(pick); });
  const bool takes_back = !picks_.empty() && picks_.back().offer >= fallen;
  if (!forgets && !takes_back) return;
  lower([&] {
    for (const VacOffer& pick : forgotten) {
      if (!has(pick)) raise_across(pick);
    }
    for (; num_open() > 0 && picks_.back().offer >= fallen; picks_.pop_back()) {
      picked_[picks_.back().index] = 0;
      raise_around(picks_.back().index);
    }
  });
  file_all();
}

void VacSelector::take_back_open() {
  if (num_open() == 0) return;
  lower([&] {
    for (; num_open() > 0; picks_.pop_back()) {
      picked_[picks_.back().index] = 0;
      raise_around(picks_.back().index);
    }
  });
}

}  // namespace noiseloom
