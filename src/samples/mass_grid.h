// A density that is constant in each texel of a grid, as the mass of every box of it.
//
// Masses are integers in one summed-area table [Crow84]: the mass of a box with whole edges is exact, so an empty
// texel stays empty however bright others are, and what is computed from fractions of it never falls as an edge moves
// on. A texel whose share of the whole is below 2^-63 counts as empty.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "noiseloom/core/shared_values.h"

namespace noiseloom {

enum class GridAxis { x, y };

// In texels: low <= position < high on each axis, [x, y]; 0 to the size of the grid.
struct TexelBox {
  std::array<double, 2> low;
  std::array<double, 2> high;

  bool contains(double x, double y) const { return x >= low[0] && x < high[0] && y >= low[1] && y < high[1]; }
};

// A position and the texel that holds it: texel[a] <= at[a] < texel[a] + 1.
struct TexelPoint {
  std::array<int, 2> texel;
  std::array<double, 2> at;
};

class MassGrid {
 public:
  // mass_of(x, y) is the mass of a texel; finite, none below 0, not all 0. It is asked twice for each.
  using MassOf = std::function<double(int x, int y)>;
  MassGrid(int width, int height, const MassOf& mass_of);
  // The same in two steps, so that the table can lie in memory of others.
  static std::size_t num_sums(int width, int height);
  static void sum_up(int width, int height, const MassOf& mass_of, std::span<std::uint64_t> sums);
  MassGrid(int width, int height, SharedValues<std::uint64_t> sums);

  int width() const { return size_[0]; }
  int height() const { return size_[1]; }
  TexelBox whole() const;
  bool is_empty(int x, int y) const;

  // The boxes here must hold some mass.

  // The same mass without the empty columns and rows at the sides.
  TexelBox trimmed(const TexelBox& box) const;
  // The position on `axis` with that share (0 to 1) of the mass below it.
  double cut(const TexelBox& box, GridAxis axis, double share) const;
  // The point of a box whose place in the distribution is u, v in [0, 1): u over columns, v over the rows of one
  // column. Its texel is not empty.
  TexelPoint point(const TexelBox& box, double u, double v) const;

 private:
  class Band;

  std::uint64_t below(GridAxis along, int at, int across) const {
    const std::size_t pitch = static_cast<std::size_t>(size_[0]) + 1;
    const auto x = static_cast<std::size_t>(along == GridAxis::x ? at : across);
    const auto y = static_cast<std::size_t>(along == GridAxis::x ? across : at);
    return below_[y * pitch + x];
  }

  std::array<int, 2> size_;
  SharedValues<std::uint64_t> below_;  // [y][x], (height + 1) * (width + 1): the mass of all texels before both edges
};

}  // namespace noiseloom
