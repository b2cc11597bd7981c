// The weights of void and cluster in fixed point, cut into rows.
//
// A weight is round(2^b * K) of one group at one offset, the weight of the group in K. b is the largest of at most 30
// for which the weights of all offsets of all groups together add up to less than 2^31. An energy is a sum of such
// weights over distinct offsets, so it stays below 2^31 whichever pixels are on, and bit 31 of a 32-bit word is free
// for a flag. Weights that round to zero are cut.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "noiseloom/construct/void_and_cluster.h"

namespace noiseloom {

constexpr std::uint32_t vac_flag = 0x80000000U;

// Offsets of one group that differ along its first axis only: -lo..hi along that axis, `offset` along the others.
struct VacRow {
  std::array<std::int32_t, Extents::max_axes - 1> offset;
  std::int32_t lo;
  std::int32_t hi;
  std::size_t first;  // weights[first] belongs to -lo
};

// Which offsets count, by whether they pass an edge of x or y: all; those of a tile to itself, which do not; or those
// of a tile to all tiles, which do.
enum class VacEdges { pass, stay, cross };

struct VacGroupKernel {
  int axis0 = 0;            // the group's lowest axis
  std::vector<int> others;  // the rest, ascending
  std::vector<VacRow> rows;
  std::vector<std::uint32_t> weights;   // followed by zeros for whole vectors past the last row; also between rows
  std::vector<std::size_t> same_pixel;  // the weights at offsets that are zero but along box axes
  VacEdges edges = VacEdges::pass;
  bool contains_x() const { return axis0 == 0; }
  bool stays_in_slice() const { return others.empty() ? axis0 < 2 : others.back() < 2; }
  bool is_of_plane() const { return axis0 == 0 && others.size() == 1 && others[0] == 1 && edges == VacEdges::pass; }
  std::int32_t reach_x = 0;
  std::int32_t reach_y = 0;
  // Whether a row around (x, y) may reach past an edge of a slice of that size.
  bool reaches_an_edge(std::int64_t x, std::int64_t width, std::int64_t y, std::int64_t height) const {
    return x < reach_x || x + reach_x >= width || y < reach_y || y + reach_y >= height;
  }
  static constexpr std::size_t padding = 16;
};

class VacKernel {
 public:
  explicit VacKernel(const VacSpec& spec);
  const std::vector<VacGroupKernel>& groups() const { return groups_; }
  int scale_log2() const { return scale_log2_; }
  std::uint64_t weight_sum() const { return weight_sum_; }

 private:
  std::vector<VacGroupKernel> groups_;
  int scale_log2_ = 0;
  std::uint64_t weight_sum_ = 0;
};

}  // namespace noiseloom
