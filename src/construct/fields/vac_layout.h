// How the pixels of a texture lie in the words of a field of void and cluster.
#pragma once

#include <array>
#include <cstdint>

#include "construct/fields/vac_kernel.h"

namespace noiseloom {

// A pixel: position = cell + cells * slice.
struct VacPlace {
  std::int64_t cell;
  std::int64_t slice;
};

// How positions map to words. All axes; slices [slice_begin, slice_end) are present.
struct VacLayout {
  static constexpr std::int64_t line_words = 16;  // of a cache line
  static constexpr std::int64_t leaf_cells = 64;
  VacLayout(const VacSpec& spec, std::int32_t begin, std::int32_t end);

  int num_axes;
  std::array<std::int64_t, Extents::max_axes> size;
  std::array<bool, Extents::max_axes> toroidal;
  std::array<std::int64_t, Extents::max_axes> slice_step;  // what a step along a slice axis adds to the slice
  std::int64_t cells;                                      // per slice
  std::int64_t num_slices;
  std::int64_t slice_begin;
  std::int64_t slice_end;
  std::int64_t slice_words;  // between the starts of two slices
  std::int64_t leaves;       // per slice

  using Coord = std::array<std::int64_t, Extents::max_axes>;
  Coord coord(std::uint64_t position) const;
  VacPlace place(std::uint64_t position) const {
    const auto p = static_cast<std::int64_t>(position);
    return {p % cells, p / cells};
  }
  // Adds `offset` on `axis`; false where that leaves a non-toroidal axis. |offset| <= size.
  bool move(std::int64_t& c, int axis, std::int64_t offset) const {
    const std::int64_t n = size[static_cast<std::size_t>(axis)];
    c += offset;
    if (c >= 0 && c < n) return true;
    c += c < 0 ? n : -n;
    return toroidal[static_cast<std::size_t>(axis)];
  }
  // Positions [first_position(), end_position()) are present.
  std::uint64_t first_position() const { return static_cast<std::uint64_t>(slice_begin * cells); }
  std::uint64_t end_position() const { return static_cast<std::uint64_t>(slice_end * cells); }
  bool has_slice(std::int64_t slice) const { return slice >= slice_begin && slice < slice_end; }
};

}  // namespace noiseloom
