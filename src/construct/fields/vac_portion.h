// Picks on their way into the fields: some that follow each other in the order.
#pragma once

#include <cstdint>
#include <vector>

#include "construct/fields/vac_layout.h"

namespace noiseloom {

struct VacPortion {
  std::vector<std::uint64_t> positions;  // ascending
  std::vector<std::uint32_t> numbers;    // of each that is ours: how many of its batch were picked before it

  // Where there are as many as slices, fields take them slice by slice, and find here what follows from the positions.
  void divide(const VacLayout& layout);
  bool is_divided() const { return !slice_begins.empty(); }
  std::vector<std::uint32_t> cells;         // of each: its place in its slice
  std::vector<std::uint32_t> slices;        // and that slice
  std::vector<std::uint32_t> slice_begins;  // of each slice of the texture: its first one; then how many there are
  std::size_t begin_of(std::int64_t slice) const { return slice_begins[static_cast<std::size_t>(slice)]; }
};

}  // namespace noiseloom
