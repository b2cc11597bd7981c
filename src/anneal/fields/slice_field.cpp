#include "noiseloom/anneal/slice_field.h"

#include <algorithm>

namespace noiseloom {

FieldLayout::FieldLayout(const Footprint& footprint, int num_channels)
    : FieldLayout(footprint, num_channels, {footprint.extents().width(), footprint.extents().height()}) {}

FieldLayout::FieldLayout(const Footprint& footprint, int num_channels, WindowSize window)
    : width(window.width),
      height(window.height),
      reach_x(footprint.reach(0)),
      reach_y(footprint.reach(1)),
      channels(num_channels),
      wraps_x(width == footprint.extents().width()),
      wraps_y(height == footprint.extents().height()),
      divider(width) {
  NOISELOOM_CHECK(wraps_x ? 2 * reach_x <= width : width + reach_x <= footprint.extents().width());
  NOISELOOM_CHECK(wraps_y ? 2 * reach_y <= height : height + reach_y <= footprint.extents().height());
  stride = width + 2 * reach_x;
  plane_size = stride * (height + 2 * reach_y) + slack;
}

void SliceField::get(Cell cell, float* out) const {
  const std::int64_t at = layout_.at(cell);
  for (int c = 0; c < layout_.channels; ++c) out[c] = plane(c)[at];
}

void SliceField::set(Cell cell, const float* sample) {
  const std::int64_t y = layout_.divider.y(cell);
  const std::int64_t x = cell - y * layout_.width;
  const std::int64_t image_x = layout_.image_x(x);
  const std::int64_t image_y = layout_.image_y(y);
  for (int c = 0; c < layout_.channels; ++c) {
    float* base = data_.data() + c * layout_.plane_size + layout_.reach_y * layout_.stride + layout_.reach_x;
    base[y * layout_.stride + x] = sample[c];
    base[y * layout_.stride + image_x] = sample[c];
    base[image_y * layout_.stride + x] = sample[c];
    base[image_y * layout_.stride + image_x] = sample[c];
  }
}

void SliceField::swap(Cell a, Cell b) {
  float sample_a[8];
  float sample_b[8];
  NOISELOOM_CHECK_LE(layout_.channels, 8);
  get(a, sample_a);
  get(b, sample_b);
  set(a, sample_b);
  set(b, sample_a);
}

void SliceField::fill(std::span<const SampleId> permutation, std::span<const float> list) {
  for (std::size_t cell = 0; cell < permutation.size(); ++cell) {
    set(static_cast<Cell>(cell),
        list.data() + std::size_t{permutation[cell].value()} * static_cast<std::size_t>(layout_.channels));
  }
}

void SliceField::copy_window(const SliceField& slice, Corner corner) {
  const FieldLayout& from = slice.layout_;
  NOISELOOM_CHECK(from.whole() && from.channels == layout_.channels);
  if (layout_.whole()) {
    data_ = slice.data_;
    return;
  }
  const auto onto_ring = [](std::int64_t at, std::int64_t size) { return (at % size + size) % size; };
  for (int c = 0; c < layout_.channels; ++c) {
    float* out = data_.data() + c * layout_.plane_size;
    for (std::int64_t y = -layout_.reach_y; y < layout_.height + layout_.reach_y; ++y) {
      const float* row = slice.plane(c) + from.at(onto_ring(corner.y + y, from.height) * from.width);
      std::int64_t x = onto_ring(corner.x - layout_.reach_x, from.width);
      for (std::int64_t left = layout_.stride; left > 0;) {
        const std::int64_t length = std::min(left, from.width - x);
        out = std::copy_n(row + x, length, out);
        left -= length;
        x = 0;
      }
    }
  }
}

std::vector<float> SliceField::planar() const {
  const Cell cells = layout_.width * layout_.height;
  std::vector<float> values(static_cast<std::size_t>(cells * layout_.channels));
  for (int c = 0; c < layout_.channels; ++c) {
    for (std::int64_t y = 0; y < layout_.height; ++y) {
      const float* row = plane(c) + layout_.at(y * layout_.width);
      std::copy(row, row + layout_.width, values.begin() + c * cells + y * layout_.width);
    }
  }
  return values;
}

void SliceField::interleaved(std::span<float> out) const {
  NOISELOOM_CHECK_EQ(static_cast<std::int64_t>(out.size()), layout_.width * layout_.height * layout_.channels);
  for (int c = 0; c < layout_.channels; ++c) {
    for (Cell cell = 0; cell < layout_.width * layout_.height; ++cell) {
      out[static_cast<std::size_t>(cell * layout_.channels + c)] = plane(c)[layout_.at(cell)];
    }
  }
}

}  // namespace noiseloom
