// The shape of a texture, and how its cells and slices are numbered.
//
// Axis 0 is x, axis 1 is y; the rest are the slice axes. The first axis varies fastest everywhere:
//   cell  = x + X * y                        position inside a slice (int64)
//   slice = t + T * (z + Z * (w + ...))      position of the slice (int32); coordinates in the order of the slice axes
// so arrays in files have the dimensions [..., z, t, y, x, channel]. All axes are toroidal.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "noiseloom/core/error.h"
#include "noiseloom/core/index.h"

namespace noiseloom {

using Cell = std::int64_t;

class Extents {
 public:
  static constexpr int max_axes = 8;

  Extents() = default;
  // Sizes and names of x, y, then the slice axes. Requires 2 <= number of axes <= max_axes, every size >= 1 and fewer
  // than 2^31 slices.
  Extents(std::vector<std::int64_t> sizes, std::vector<std::string> names);
  // Names the axes x, y, t, z, w, v, u, s.
  explicit Extents(std::vector<std::int64_t> sizes);

  int num_axes() const { return static_cast<int>(sizes_.size()); }
  int num_slice_axes() const { return num_axes() - 2; }
  std::int64_t size(int axis) const { return sizes_[static_cast<std::size_t>(axis)]; }
  const std::string& name(int axis) const { return names_[static_cast<std::size_t>(axis)]; }
  // The axis of that name, or -1.
  int axis(const std::string& name) const;

  std::int64_t width() const { return sizes_[0]; }
  std::int64_t height() const { return sizes_[1]; }
  Cell cells_per_slice() const { return sizes_[0] * sizes_[1]; }
  std::int32_t num_slices() const { return num_slices_; }
  IndexRange<SliceIndex> slices() const { return first_indices<SliceIndex>(num_slices_); }
  std::int64_t num_cells() const { return cells_per_slice() * num_slices_; }

  // Coordinates along the slice axes (index 0 is axis 2).
  using SliceCoord = std::array<std::int32_t, max_axes - 2>;
  SliceCoord slice_coord(SliceIndex slice) const;
  SliceIndex slice_index(const SliceCoord& coord) const;
  // The slice at `slice + offset`, wrapped around the torus. Offsets may be negative and larger than the axis.
  SliceIndex slice_at(SliceIndex slice, const SliceCoord& offset) const;

  // Sizes in file order: [..., t, y, x].
  std::vector<std::int64_t> file_dimensions() const;
  std::string to_string() const;  // "128 x 128 x 32"

  friend bool operator==(const Extents& a, const Extents& b) { return a.sizes_ == b.sizes_ && a.names_ == b.names_; }

 private:
  std::vector<std::int64_t> sizes_;
  std::vector<std::string> names_;
  std::int32_t num_slices_ = 0;
};

}  // namespace noiseloom
