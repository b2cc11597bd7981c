// Candidates by the plane of a group that they lie in, for groups of two axes whose planes are small (up to
// 128 x 128): then a plane holds few candidates, and looking at all of them by vectors costs less than finding out
// which are near.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "construct/vac_layout.h"

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

  // For the vector loops. Along an axis: its index, its size or, where it does not wrap around, more than any
  // difference, and the reach of the footprint.
  struct Axis {
    std::size_t index;
    std::int32_t size;
    std::int32_t lo;
    std::int32_t hi;
  };
  static constexpr std::size_t padding = 16;
  const std::array<Axis, 2>& axes() const { return axes_; }

 private:
  std::size_t plane(const Coord& at) const {
    std::size_t result = 0;
    for (const auto& [axis, stride] : strides_) result += static_cast<std::size_t>(at[axis]) * stride;
    return result;
  }

  std::array<Axis, 2> axes_;
  std::vector<std::pair<std::size_t, std::size_t>> strides_;  // of the other axes
  std::vector<std::uint32_t> weights_;                        // dense, rows along the first axis
  std::vector<std::uint32_t> ends_;                           // by plane: where its candidates end
  std::vector<std::uint32_t> places_;                         // first coordinate, second << 16; plane by plane
  std::vector<std::uint32_t> indices_;
};

}  // namespace noiseloom
