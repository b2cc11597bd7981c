// Candidates by the tile that they lie in of the planes of a group of two axes. Those of neighbouring tiles of a row
// lie one behind the other and are looked at by vectors, which costs less than finding out which are near.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "construct/fields/vac_layout.h"

namespace noiseloom {

class VacPlaneBins {
 public:
  using Coord = std::array<std::int32_t, Extents::max_axes>;
  static bool suit(const VacLayout& layout, const VacGroupKernel& group);
  VacPlaneBins(const VacLayout& layout, const VacGroupKernel& group);

  // Replaces all candidates.
  void assign(std::span<const Coord> at);
  // Adds the group's weights to the energies of the candidates around `from`.
  void raise(const Coord& from, std::span<std::uint32_t> energies) const;
  // Appends those of them whose weight is not zero.
  struct Hit {
    std::uint32_t index;
    std::uint32_t weight;
  };
  void find(const Coord& from, std::vector<Hit>& hits) const;

  // For the vector loops. Along an axis: its index, its size or, where it does not wrap around, more than any
  // difference, and the reach of the footprint.
  struct Axis {
    std::size_t index;
    std::int32_t size;
    std::int32_t lo;
    std::int32_t hi;
    int shift;  // log2 of the width of a tile
    std::int32_t num_tiles;
  };
  // Candidates [begin, end), by tiles.
  struct Run {
    std::uint32_t begin;
    std::uint32_t end;
  };
  static constexpr std::size_t padding = 16;
  const std::array<Axis, 2>& axes() const { return axes_; }

 private:
  std::size_t plane(const Coord& at) const {
    std::size_t result = 0;
    for (const auto& [axis, stride] : strides_) result += static_cast<std::size_t>(at[axis]) * stride;
    return result;
  }
  std::size_t tile(const Coord& at) const {
    std::size_t result = plane(at);
    for (const std::size_t i : {1U, 0U}) {
      result = result * static_cast<std::size_t>(axes_[i].num_tiles) +
               static_cast<std::size_t>(at[axes_[i].index] >> axes_[i].shift);
    }
    return result;
  }
  // Tiles [first, last] along an axis.
  struct Tiles {
    std::int32_t first;
    std::int32_t last;
  };
  static constexpr std::size_t most_runs = 16;
  std::span<const Run> runs_around(const Coord& from, std::array<Run, most_runs>& runs) const;
  static std::size_t tiles_met(const Axis& axis, std::int32_t c, std::array<Tiles, 2>& tiles);

  std::array<Axis, 2> axes_;
  std::vector<std::pair<std::size_t, std::size_t>> strides_;  // of the other axes
  std::vector<std::uint32_t> weights_;                        // dense, rows along the first axis
  std::vector<std::uint32_t> ends_;                           // by tile: where its candidates end
  std::vector<std::uint32_t> places_;                         // first coordinate, second << 16; tile by tile
  std::vector<std::uint32_t> indices_;
};

}  // namespace noiseloom
