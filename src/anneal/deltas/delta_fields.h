// What the float swap delta reads: a copy of the moving slice, its transposed copy, and the other slices, each as
// planes of samples with the blocks of taps that are centred in them.
#pragma once

#include <vector>

#include "anneal/fields/pair_weights.h"
#include "anneal/fields/tap_plan.h"
#include "noiseloom/anneal/swap_delta.h"

namespace noiseloom {

class DeltaFields {
 public:
  // Without the others, only the moving slice itself counts.
  DeltaFields(const Footprint& footprint, int channels, WindowSize window, bool with_others);

  // Where the centre of a footprint lies in the four kinds of plane.
  enum Kind { rows, columns, stacked, other_rows, num_kinds };
  struct Position {
    std::int64_t x;
    std::int64_t y;
    std::int64_t in[num_kinds];
  };
  Position position(Cell cell) const {
    const std::int64_t y = layout_.divider.y(cell);
    const std::int64_t x = cell - y * layout_.width;
    std::int64_t slice_x = corner_.x + x;
    std::int64_t slice_y = corner_.y + y;
    if (slice_x >= slice_layout_.width) slice_x -= slice_layout_.width;
    if (slice_y >= slice_layout_.height) slice_y -= slice_layout_.height;
    return {x,
            y,
            {y * layout_.stride + x + origin_, x * transposed_stride_ + y + transposed_origin_, cell * stack_size_,
             slice_y * slice_layout_.stride + slice_x + origin_of_slice_}};
  }

  struct Part {
    const float* samples;
    std::int64_t plane_size;  // from one channel to the next
    const TapBlocks* taps;
    Kind kind;
  };
  const std::vector<Part>& parts() const { return parts_; }
  const SliceField& own() const { return own_; }
  // F between two cells of the slice.
  float pair_weight(const Position& i, const Position& j) const {
    const std::int64_t dx = nearest_offset(j.x - i.x, layout_.width, layout_.wraps_x);
    const std::int64_t dy = nearest_offset(j.y - i.y, layout_.height, layout_.wraps_y);
    if (dx > layout_.reach_x || -dx > layout_.reach_x || dy > layout_.reach_y || -dy > layout_.reach_y) return 0;
    return pair_weights_[static_cast<std::size_t>((dy + layout_.reach_y) * (2 * layout_.reach_x + 1) + dx +
                                                  layout_.reach_x)];
  }

  // False where pair_weight() is surely 0, as the rows of the cells are further apart than the reach: so it is of most
  // pairs, and this tells it without looking their positions up.
  bool may_be_near(Cell i, Cell j) const {
    const std::int64_t apart = i < j ? j - i : i - j;
    return apart <= largest_near_ || apart >= layout_.width * layout_.height - largest_near_;
  }

  void prefetch_stack(Cell cell) const {
    if (stack_size_ == 0) return;
    for (int c = 0; c < layout_.channels; ++c) {
      prefetch_floats(stack_samples_.data() + (c * layout_.width * layout_.height + cell) * stack_size_, stack_size_);
    }
  }

  const FieldLayout& layout() const { return layout_; }
  void bind(SliceIndex slice, Corner corner, const SliceField& own, const FieldOf& others);
  void swap(Cell i, Cell j);

 private:
  struct Plane {
    Extents::SliceCoord offset;
    TapBlocks taps;
  };
  void plan_others();
  void plan_pair_weights();
  void transpose();
  void set_transposed(Cell cell);
  void stack(SliceIndex slice, const FieldOf& others);

  const Footprint& footprint_;
  FieldLayout layout_;        // of the window
  FieldLayout slice_layout_;  // of the other slices
  Corner corner_;
  std::int64_t largest_near_;
  std::int64_t origin_;
  std::int64_t origin_of_slice_;
  std::int64_t transposed_stride_;
  std::int64_t transposed_origin_;
  std::int64_t transposed_size_ = 0;  // of one channel; 0: not kept
  std::int64_t stack_size_ = 0;       // samples of one cell's stack; 0: none

  PlanePlan own_plan_;
  std::vector<Plane> planes_;                 // of slices with taps beside the same pixel
  std::vector<Extents::SliceCoord> stacked_;  // slices of which only the same pixel counts
  TapBlocks stack_taps_;
  std::vector<float> pair_weights_;

  SliceField own_;
  std::vector<float> transposed_;
  std::vector<float> stack_samples_;  // [channel][cell][stacked slice]
  std::vector<Part> parts_;
};

}  // namespace noiseloom
