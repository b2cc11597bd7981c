// The picks that follow from a list of candidates, exact and without the field.
//
// While values only rise (vac_field.h), every pixel that can have a key <= limit later has one now. So the candidates
// found by one scan are all that the picks up to that limit depend on: a pick raises the candidates in its footprint,
// and the next pick is the least candidate left. Any process that has the candidates gets the same picks; fields are
// brought up to date afterwards, in any order.
//
// The least of a neighbourhood is picked, whatever happens elsewhere: nothing can raise it before. So a selector can
// pick among candidates of its own with others around, which other threads pick among, or nobody yet. A candidate in
// whose footprint another's lies that may come first waits, and so do those behind it in its own footprint; what waits
// is picked later by one selector for all (vac_selection.h), or found again (vac_windows.h). The order is that of the
// keys, so nothing is lost by picking apart.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "construct/bins/vac_group_bins.h"
#include "construct/fields/vac_field.h"

namespace noiseloom {

// Picks ascend by this. For clusters equal keys go by descending position.
struct VacPick {
  std::uint64_t key;
  std::uint32_t order;  // index among the candidates, complemented for clusters
  std::uint32_t index(VacView view) const { return order ^ static_cast<std::uint32_t>(view); }
  friend bool operator<(const VacPick& a, const VacPick& b) {
    return (a.key < b.key) | ((a.key == b.key) & (a.order < b.order));
  }
};

// Aligned, as each thread writes to one.
class alignas(64) VacSelector {
 public:
  // With `in_slices`, candidates of one slice are always own ones of the same selector; without, they may be of
  // windows.
  VacSelector(const VacSpec& spec, const VacKernel& kernel, bool in_slices = true);

  // A new batch: `candidates` are all pixels of the texture (or the window that `spec` describes) with key <= limit,
  // ascending in position, and stay where
  // they are while picks are taken; [first, last) of them are this selector's own.
  void begin(VacView view, std::span<const VacCandidate> candidates, std::size_t first, std::size_t last,
             std::uint64_t limit);
  // Picks all but what waits for candidates that are not its own.
  void pick();
  // In their order.
  const std::vector<VacPick>& picks() const { return picks_; }
  // Those that wait, under their present keys; after raise_waiting() they ascend in position.
  const std::vector<VacPick>& waiting() const { return waiting_; }
  // Raises those by what was picked among others' candidates: all of that comes before, as those who picked it would
  // have waited for these otherwise. is_picked(index).
  template <class IsPicked>
  void raise_waiting(const IsPicked& is_picked) {
    std::ranges::sort(waiting_, {}, [&](const VacPick& pick) { return pick.index(view_); });
    for (VacPick& pick : waiting_) raise(pick, first_, first_ + energy_.size(), is_picked);
  }
  // The same for one that waits in another selector, whose own candidates are [first, last).
  template <class IsPicked>
  void raise(VacPick& waiting, std::size_t first, std::size_t last, const IsPicked& is_picked) {
    hits_.clear();
    across_.find(at_[waiting.index(view_)], hits_);
    for (const VacGroupBins::Hit& hit : hits_) {
      if ((hit.index < first || hit.index >= last) && is_picked(hit.index)) {
        waiting.key += std::uint64_t{hit.weight} << 32;
      }
    }
  }

 private:
  struct Later {  // for a heap with the least at the front
    bool operator()(const VacPick& a, const VacPick& b) const { return b < a; }
  };
  static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
  std::uint32_t order(std::uint32_t k) const { return (first_ + k) ^ static_cast<std::uint32_t>(view_); }
  void locate();
  void put(std::uint32_t k);
  void open_next_bucket();
  bool wait_or_raise(std::uint32_t k, std::uint64_t key);

  VacLayout layout_;
  VacGroupBins among_own_;  // for groups whose footprints meet none of others
  VacGroupBins across_;     // for the other groups: of all candidates
  VacView view_ = VacView::voids;
  std::uint64_t limit_ = 0;
  std::span<const VacCandidate> candidates_;
  std::uint32_t first_ = 0;         // own
  std::vector<VacBins::Coord> at_;  // of all
  std::vector<std::uint32_t> energy_;
  std::vector<VacPick> picks_;
  std::vector<VacPick> waiting_;
  std::vector<bool> is_behind_;  // one that waits
  std::vector<VacGroupBins::Hit> hits_;

  // Buckets of equal width in energy, each a list through next_; the one that is being emptied is the heap.
  std::vector<std::uint32_t> head_;
  std::vector<std::uint32_t> next_;
  std::vector<VacPick> heap_;
  std::uint32_t least_ = 0;
  int shift_ = 0;
  std::uint32_t current_ = 0;
};

}  // namespace noiseloom
