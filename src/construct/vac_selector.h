// The picks that follow from a list of candidates, exact and without the field.
//
// While values only rise (vac_field.h), every pixel that can have a key <= limit later has one now. So the candidates
// found by one scan are all that the picks up to that limit depend on: a pick raises the candidates in its footprint,
// and the next pick is the least candidate left. Fields are brought up to date afterwards, in any order.
//
// A selector has the candidates of its own slices and picks as if there were no others. Such picks are open until the
// picks of other slices up to them are known: where one of these raises an open pick that comes later, that pick and
// all own ones after it are taken back (vac_selection.h).
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "construct/vac_bins.h"
#include "construct/vac_exchange.h"
#include "construct/vac_plane_bins.h"

namespace noiseloom {

class VacSelector {
 public:
  // Of slices [begin, end).
  VacSelector(const VacSpec& spec, const VacKernel& kernel, std::int32_t begin, std::int32_t end);

  // Takes up other candidates: all pixels of its slices with key <= limit, ascending in position; they must stay where
  // they are until the next call. For clusters equal keys go by descending position.
  void begin(VacView view, std::span<const VacCandidate> candidates, std::uint64_t limit);
  // Picks on until so many picks are open, or no candidate is left below the limit.
  void pick(std::size_t wanted_open);

  std::size_t num_open() const { return picks_.size() - num_settled_; }
  const VacOffer& open(std::size_t k) const { return picks_[num_settled_ + k].offer; }

  // Takes in the picks of others among `picks`, which are in order. The first own open pick that does not stand because
  // of them, by default none.
  VacOffer hear(std::span<const VacOffer> picks);
  // After hear(picks): the first `num_settled` of them stand; those of others after these are forgotten, and own open
  // ones from `fallen` on are taken back.
  void settle(std::span<const VacOffer> picks, std::size_t num_settled, const VacOffer& fallen);
  // The same where nobody else has slices.
  void settle_all() { num_settled_ = picks_.size(); }
  void take_back_open();

  // Once no pick is open: whether candidate i was picked, and the value of one that was not.
  bool picked(std::size_t i) const { return picked_[i] != 0; }
  std::uint32_t energy(std::size_t i) const { return energy_[i]; }

 private:
  static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

  struct Entry {
    std::uint64_t key;
    std::uint32_t order;                                     // index of the candidate, complemented for clusters
    friend bool operator<(const Entry& a, const Entry& b) {  // for a heap with the least at the front
      return a.key != b.key ? a.key > b.key : a.order > b.order;
    }
  };
  struct Pick {
    VacOffer offer;
    std::uint32_t index;
    std::uint32_t energy;  // before the picks of others were heard
  };
  bool has(const VacOffer& offer) const {
    const std::uint64_t position = position_of(view_, offer);
    return position >= begin_ && position < end_;
  }
  VacBins::Coord coord(std::uint64_t position) const;
  void file_all();
  void put(std::uint32_t i);
  void open_next_bucket();
  void raise_around(std::uint32_t i);
  void raise_across(const VacOffer& of_others);
  template <class Raise>
  void lower(const Raise& raise);

  VacLayout layout_;
  std::uint64_t begin_;
  std::uint64_t end_;
  std::vector<VacPlaneBins> plane_bins_;  // of the groups that they suit
  std::vector<VacBins> bins_;             // of the other groups
  std::vector<VacBins::Coord> at_;
  std::vector<std::uint32_t> energy_;
  std::vector<std::uint8_t> picked_;
  std::vector<Pick> picks_;
  std::size_t num_settled_ = 0;

  // Buckets of equal width in energy, each a list through next_; the one that is being emptied is the heap.
  VacView view_ = VacView::voids;
  std::span<const VacCandidate> candidates_;
  std::vector<std::uint32_t> head_;
  std::vector<std::uint32_t> next_;
  std::vector<Entry> heap_;
  std::uint64_t limit_ = 0;
  std::uint32_t least_ = 0;
  int shift_ = 0;
  std::uint32_t current_ = 0;
  std::uint32_t mirror_ = 0;
};

}  // namespace noiseloom
