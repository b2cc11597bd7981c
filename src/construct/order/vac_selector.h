// The picks that follow from a list of candidates, exact and without the field.
//
// While values only rise (vac_field.h), every pixel that can have a key <= limit later has one now. So the candidates
// found by one scan are all that the picks up to that limit depend on: a pick raises the candidates in its footprint,
// and the next pick is the least candidate left. Any process that has the candidates gets the same picks; fields are
// brought up to date afterwards, in any order.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "construct/order/vac_bins.h"
#include "construct/order/vac_plane_bins.h"

namespace noiseloom {

class VacSelector {
 public:
  VacSelector(const VacSpec& spec, const VacKernel& kernel);

  // A new batch: `candidates` are all pixels of the texture with key <= limit, ascending in position, and stay where
  // they are while picks are taken.
  void begin(VacView view, std::span<const VacCandidate> candidates, std::uint64_t limit);
  // The next picks, until none is left below the limit or `most` are taken; for clusters equal keys go by descending
  // position. How many they are; calls may follow each other.
  std::size_t take(std::size_t most);
  // How many of its batch were picked before candidate i; none where it has not been.
  static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
  std::uint32_t number(std::size_t i) const { return number_[i]; }

 private:
  struct Entry {
    std::uint64_t key;
    std::uint32_t order;                                     // index of the candidate, complemented for clusters
    friend bool operator<(const Entry& a, const Entry& b) {  // for a heap with the least at the front
      return a.key != b.key ? a.key > b.key : a.order > b.order;
    }
  };
  void put(std::uint32_t i);
  void open_next_bucket();

  VacLayout layout_;
  std::vector<VacPlaneBins> plane_bins_;  // of the groups that they suit
  std::vector<VacBins> bins_;             // of the other groups
  std::vector<VacBins::Coord> at_;
  std::vector<std::uint32_t> energy_;
  std::vector<std::uint32_t> number_;
  std::uint32_t num_picked_ = 0;

  // Buckets of equal width in energy, each a list through next_; the one that is being emptied is the heap.
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
