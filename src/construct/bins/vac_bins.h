// Pixels in bins that are at least as wide as a group reaches, so that a footprint meets few of those out of its reach.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "construct/fields/vac_field.h"

namespace noiseloom {

class VacBins {
 public:
  using Coord = std::array<std::int32_t, Extents::max_axes>;
  VacBins(const VacLayout& layout, const VacGroupKernel& group);

  // Replaces all pixels. They must stay where they are until the next call.
  void assign(std::span<const Coord> at);

  // Calls visit(index, weight) for the pixels in the group's footprint around `from`, each once, in no order that
  // matters.
  template <class Visit>
  void visit(const Coord& from, const Visit& visit) const {
    if (axes_.size() == 1) {
      visit_axes<1>(from, visit);
    } else if (axes_.size() == 2) {
      visit_axes<2>(from, visit);
    } else {
      visit_axes<0>(from, visit);
    }
  }

 private:
  struct Axis {
    std::size_t index;
    std::int32_t size;
    bool toroidal;
    std::int32_t lo;
    std::int32_t hi;
    int shift;  // log2 of the width of a bin
    std::int32_t num_bins;
    std::int64_t bin_stride;
    std::int64_t weight_stride;
  };
  static constexpr std::size_t max_bins_met = 5;
  static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

  std::int64_t bin(const Coord& at) const;
  std::size_t slot(std::int64_t bin) const {
    return static_cast<std::size_t>(static_cast<std::uint64_t>(bin) * 0x9E3779B97F4A7C15U >> slot_shift_);
  }
  std::size_t bins_met(const Axis& axis, std::int32_t c, std::array<std::int64_t, max_bins_met>& bins) const;

  // NumAxes 0: any number.
  template <std::size_t NumAxes, class Visit>
  void visit_axes(const Coord& from, const Visit& visit) const {
    const std::size_t num_axes = NumAxes > 0 ? NumAxes : axes_.size();
    std::array<std::array<std::int64_t, max_bins_met>, Extents::max_axes> bins;
    std::array<std::size_t, Extents::max_axes> count;
    std::array<std::size_t, Extents::max_axes> step{};
    Coord at{};
    std::int64_t base = 0;
    for (const auto& [axis, stride] : fixed_stride_) base += from[axis] * stride;
    for (std::size_t a = 0; a < num_axes; ++a) {
      at[a] = from[axes_[a].index];
      count[a] = bins_met(axes_[a], at[a], bins[a]);
    }
    while (true) {
      std::int64_t outer = base;
      for (std::size_t a = 1; a < num_axes; ++a) outer += bins[a][step[a]];
      for (std::size_t b = 0; b < count[0]; ++b) {
        const std::int64_t wanted = outer + bins[0][b];
        for (std::uint32_t i = heads_[slot(wanted)]; i != none; i = next_[i]) {
          if (bin_[i] != wanted) continue;
          const Coord& pixel = at_[i];
          std::int64_t index = 0;
          bool inside = true;
          bool crosses = false;
          for (std::size_t a = 0; a < num_axes; ++a) {
            const Axis& axis = axes_[a];
            std::int32_t d = pixel[axis.index] - at[a];
            if (axis.toroidal) {
              const std::int32_t around = d > axis.hi ? -axis.size : d < -axis.lo ? axis.size : 0;
              d += around;
              crosses = crosses || (around != 0 && axis.index < 2);
            }
            inside = inside && d >= -axis.lo && d <= axis.hi;
            index += (d + axis.lo) * axis.weight_stride;
          }
          inside = inside && (edges_ == VacEdges::pass || crosses == (edges_ == VacEdges::cross));
          if (inside) visit(i, weights_[static_cast<std::size_t>(index)]);
        }
      }
      std::size_t a = 1;
      while (a < num_axes && ++step[a] == count[a]) step[a++] = 0;
      if (a >= num_axes) return;
    }
  }

  VacEdges edges_;
  std::vector<Axis> axes_;                                          // of the group
  std::vector<std::pair<std::size_t, std::int64_t>> fixed_stride_;  // the other axes
  std::vector<std::uint32_t> weights_;                              // dense
  // Nearly all bins are empty, so those that share a slot share a list.
  std::vector<std::uint32_t> heads_;  // of each slot: one of its pixels
  std::vector<std::uint32_t> next_;   // of each pixel: another one of its slot
  std::vector<std::int64_t> bin_;     // of each pixel
  int slot_shift_ = 0;
  std::span<const Coord> at_;
};

}  // namespace noiseloom
