// The values of one slice, or of a window of it, laid out for the inner loops: planar, with a border that repeats what
// lies around (for a whole slice, the torus), so that a tap is an offset and never wraps.
//
//     reach_x  width  reach_x
//   +----+------------+----+
//   | d' | c'      d' | c' |  reach_y     a, b, c, d: the cells at the corners of the slice
//   +----+------------+----+              a', b', c', d': the same samples once more,
//   | b' | a        b | a' |              from the other side of the torus
//   |    |            |    |  height
//   | d' | c        d | c' |
//   +----+------------+----+
//   | b' | a'      b' | a' |  reach_y
//   +----+------------+----+
//
// With stride = width + 2 reach_x, the element (channel c, x, y) stands at
//
//   c * plane_size + (y + reach_y) * stride + x + reach_x,   -reach_x <= x < width + reach_x, and y alike.
//
// A sample lies in memory in four ways on its way from the space to the file:
//
//   [id][channel]             the list that a space gives (samples/sample_space.h); the permutation of
//                             a slice says which id stands at which cell, and is what a checkpoint holds
//   [channel][y][x], border   the field of a slice, here: what movers and scores read
//   [slice][y][x][channel]    /samples of the run file (files/run_file.h), and what containers write
//   [slice][channel][y][x]    a texture that was read back to be looked at (image/texture_file.h)
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "noiseloom/problem/footprint.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {

// Cells to x and y without a division; exact for cells and widths below 2^32 [Robison05].
class CellDivider {
 public:
  CellDivider() = default;
  explicit CellDivider(std::int64_t width)
      : width_(width), inverse_(~std::uint64_t{0} / narrow<std::uint64_t>(width)) {}
  std::int64_t y(Cell cell) const {
    const auto product = static_cast<unsigned __int128>(inverse_) * static_cast<std::uint64_t>(cell);
    return static_cast<std::int64_t>((product + inverse_) >> 64);
  }
  std::int64_t x(Cell cell) const { return cell - y(cell) * width_; }

 private:
  std::int64_t width_ = 1;
  std::uint64_t inverse_ = ~std::uint64_t{0};
};

// A rectangle of a slice. Along each axis it is the whole ring, or so short that the footprints of its cells do not
// reach around the torus to each other: at most the axis less the reach.
struct WindowSize {
  std::int64_t width;
  std::int64_t height;
};
// Where a window begins; 0 along an axis that it covers whole.
struct Corner {
  std::int64_t x = 0;
  std::int64_t y = 0;
};

struct FieldLayout {
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::int64_t reach_x = 0;
  std::int64_t reach_y = 0;
  std::int64_t stride = 0;
  std::int64_t plane_size = 0;
  int channels = 1;
  bool wraps_x = true;  // the border repeats the cells themselves
  bool wraps_y = true;
  CellDivider divider;

  // Reads of up to `slack` floats past a row's end stay inside the plane.
  static constexpr std::int64_t slack = 32;
  FieldLayout() = default;
  FieldLayout(const Footprint& footprint, int num_channels);  // the whole slice
  FieldLayout(const Footprint& footprint, int num_channels, WindowSize window);

  std::int64_t num_floats() const { return plane_size * channels; }
  // Position of a cell in a plane.
  std::int64_t at(Cell cell) const {
    const std::int64_t y = divider.y(cell);
    return (y + reach_y) * stride + cell - y * width + reach_x;
  }
  // The other place within the border where a column or row is repeated, or itself where there is none. (The reach is
  // at most half the size, so there is at most one.)
  std::int64_t image_x(std::int64_t x) const { return wraps_x ? image(x, width, reach_x) : x; }
  std::int64_t image_y(std::int64_t y) const { return wraps_y ? image(y, height, reach_y) : y; }
  bool whole() const { return wraps_x && wraps_y; }

 private:
  static std::int64_t image(std::int64_t at, std::int64_t size, std::int64_t reach) {
    return at < reach ? at + size : at >= size - reach ? at - size : at;
  }
};

// The cell of the slice that a cell of a window at `corner` is.
inline Cell slice_cell(const FieldLayout& slice, Corner corner, const FieldLayout& window, Cell cell) {
  if (window.whole()) return cell;
  const std::int64_t y = window.divider.y(cell);
  const std::int64_t slice_x = corner.x + cell - y * window.width;
  const std::int64_t slice_y = corner.y + y;
  return (slice_y < slice.height ? slice_y : slice_y - slice.height) * slice.width +
         (slice_x < slice.width ? slice_x : slice_x - slice.width);
}

class SliceField {
 public:
  SliceField() = default;
  explicit SliceField(const FieldLayout& layout)
      : layout_(layout), data_(static_cast<std::size_t>(layout.num_floats())) {}

  const FieldLayout& layout() const { return layout_; }
  const float* plane(int channel) const { return data_.data() + channel * layout_.plane_size; }
  float value(Cell cell, int channel) const { return plane(channel)[layout_.at(cell)]; }
  // Copies the sample of a cell to out[0..channels).
  void get(Cell cell, float* out) const;
  // Writes the sample and its images in the border.
  void set(Cell cell, const float* sample);
  void swap(Cell a, Cell b);
  // The sample of every cell, as `permutation` says; list [id][channel].
  void fill(std::span<const SampleId> permutation, std::span<const float> list);
  // Copies the window at `corner` of a whole slice, and what lies around it.
  void copy_window(const SliceField& slice, Corner corner);
  // Without the border: [channel][y][x], or interleaved [y][x][channel].
  std::vector<float> planar() const;
  void interleaved(std::span<float> out) const;

 private:
  FieldLayout layout_;
  std::vector<float> data_;
};

}  // namespace noiseloom
