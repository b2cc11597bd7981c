#include "anneal/deltas/delta_fields.h"

#include <algorithm>

namespace noiseloom {
namespace {

std::int64_t round_up(std::int64_t n, std::size_t multiple) {
  const auto m = static_cast<std::int64_t>(multiple);
  return (n + m - 1) / m * m;
}

}  // namespace

DeltaFields::DeltaFields(const Footprint& footprint, int channels, WindowSize window, bool with_others)
    : footprint_(footprint),
      layout_(footprint, channels, window),
      slice_layout_(footprint, channels),
      largest_near_(layout_.reach_y * layout_.width + layout_.width - 1),
      origin_(layout_.at(0)),
      origin_of_slice_(slice_layout_.at(0)),
      transposed_stride_(layout_.height + 2 * layout_.reach_y),
      transposed_origin_(layout_.reach_x * transposed_stride_ + layout_.reach_y),
      own_plan_(plan_plane(footprint.slices()[0].taps, layout_.stride, transposed_stride_)),
      pair_weights_(pair_weight_table<float>(footprint, layout_)),
      own_(layout_) {
  if (!own_plan_.columns.empty()) {
    transposed_size_ = transposed_stride_ * (layout_.width + 2 * layout_.reach_x) + FieldLayout::slack;
    transposed_.resize(static_cast<std::size_t>(transposed_size_ * channels));
  }
  if (with_others) plan_others();
}

void DeltaFields::plan_others() {
  std::vector<PlaneTap> stack;
  for (const SliceTaps& slice : footprint_.slices().subspan(1)) {
    if (same_pixel_only(slice)) {
      stack.push_back({static_cast<std::int32_t>(stacked_.size()), 0, slice.taps[0].weight});
      stacked_.push_back(slice.offset);
    } else {
      planes_.push_back({slice.offset, plan_rows(slice.taps, slice_layout_.stride)});
    }
  }
  stack_taps_ = plan_rows(stack, 0);
  stack_size_ = round_up(static_cast<std::int64_t>(stacked_.size()), block_lanes);
  stack_samples_.resize(static_cast<std::size_t>(stack_size_ * layout_.width * layout_.height * layout_.channels));
}

void DeltaFields::bind(SliceIndex slice, Corner corner, const SliceField& own, const FieldOf& others) {
  own_.copy_window(own, corner);
  corner_ = corner;
  parts_.clear();
  if (!own_plan_.rows.empty()) parts_.push_back({own_.plane(0), layout_.plane_size, &own_plan_.rows, rows});
  if (transposed_size_ > 0) {
    transpose();
    parts_.push_back({transposed_.data(), transposed_size_, &own_plan_.columns, columns});
  }
  for (const Plane& plane : planes_) {
    const SliceField& field = others(footprint_.extents().slice_at(slice, plane.offset));
    parts_.push_back({field.plane(0), slice_layout_.plane_size, &plane.taps, other_rows});
  }
  if (stack_size_ > 0) {
    stack(slice, others);
    parts_.push_back({stack_samples_.data(), stack_size_ * layout_.width * layout_.height, &stack_taps_, stacked});
  }
}

void DeltaFields::stack(SliceIndex slice, const FieldOf& others) {
  const Cell cells = layout_.width * layout_.height;
  std::vector<const SliceField*> fields;
  for (const auto& offset : stacked_) fields.push_back(&others(footprint_.extents().slice_at(slice, offset)));
  for (int c = 0; c < layout_.channels; ++c) {
    for (std::int64_t y = 0; y < layout_.height; ++y) {
      float* out = stack_samples_.data() + (c * cells + y * layout_.width) * stack_size_;
      const std::int64_t slice_y = (corner_.y + y) % slice_layout_.height;
      const std::int64_t row = slice_layout_.at(slice_y * slice_layout_.width);
      const std::int64_t until_wrap = std::min(layout_.width, slice_layout_.width - corner_.x);
      for (std::size_t k = 0; k < fields.size(); ++k) {
        const float* in = fields[k]->plane(c) + row;
        float* to = out + k;
        for (std::int64_t x = 0; x < until_wrap; ++x) to[x * stack_size_] = in[corner_.x + x];
        for (std::int64_t x = until_wrap; x < layout_.width; ++x) to[x * stack_size_] = in[x - until_wrap];
      }
    }
  }
}

void DeltaFields::swap(Cell i, Cell j) {
  own_.swap(i, j);
  if (transposed_size_ == 0) return;
  set_transposed(i);
  set_transposed(j);
}

// In tiles that the first cache holds; the border comes along.
void DeltaFields::transpose() {
  constexpr std::int64_t tile = 16;
  const std::int64_t width = layout_.stride;
  const std::int64_t height = transposed_stride_;
  for (int c = 0; c < layout_.channels; ++c) {
    const float* in = own_.plane(c);
    float* out = transposed_.data() + c * transposed_size_;
    for (std::int64_t y0 = 0; y0 < height; y0 += tile) {
      for (std::int64_t x0 = 0; x0 < width; x0 += tile) {
        for (std::int64_t x = x0; x < std::min(x0 + tile, width); ++x) {
          for (std::int64_t y = y0; y < std::min(y0 + tile, height); ++y) out[x * height + y] = in[y * width + x];
        }
      }
    }
  }
}

void DeltaFields::set_transposed(Cell cell) {
  const std::int64_t y = layout_.divider.y(cell);
  const std::int64_t x = cell - y * layout_.width;
  const std::int64_t image_x = layout_.image_x(x);
  const std::int64_t image_y = layout_.image_y(y);
  for (int c = 0; c < layout_.channels; ++c) {
    const float value = own_.plane(c)[y * layout_.stride + x + origin_];
    float* base = transposed_.data() + c * transposed_size_ + transposed_origin_;
    base[x * transposed_stride_ + y] = value;
    base[image_x * transposed_stride_ + y] = value;
    base[x * transposed_stride_ + image_y] = value;
    base[image_x * transposed_stride_ + image_y] = value;
  }
}

}  // namespace noiseloom
