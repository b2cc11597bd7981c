// The taps of one slice offset as blocks of 16 weights, for loops over planar samples (SliceField).
//
// A footprint of 2r + 1 columns seldom fills a whole number of vectors: 17 columns would waste 15 of 32 lanes. So rows
// are cut into halves of 8, two halves of different rows may share a block, and the columns that are left over may be
// read from a transposed copy of the plane, where they are rows.
#pragma once

#include <hwy/cache_control.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "noiseloom/problem/footprint.h"

namespace noiseloom {

inline constexpr std::size_t block_lanes = 16;

struct alignas(64) BlockWeights {
  float lane[block_lanes];
};

// Blocks one behind the other are one array of floats.
inline float* values_of(std::vector<BlockWeights>& blocks) { return reinterpret_cast<float*>(blocks.data()); }
inline const float* values_of(const std::vector<BlockWeights>& blocks) {
  return reinterpret_cast<const float*>(blocks.data());
}

// `count`: a multiple of block_lanes.
inline void prefetch_floats(const float* at, std::int64_t count) {
  for (std::int64_t k = 0; k < count; k += std::int64_t{block_lanes}) hwy::Prefetch(at + k);
}

// Offsets are relative to the centre's position in the plane. Lanes without a tap have weight zero, and may lie up to
// block_lanes - 1 past a row's end.
struct TapBlocks {
  struct Split {
    std::int32_t low;   // lanes 0..7
    std::int32_t high;  // lanes 8..15
  };
  std::vector<std::int32_t> full;  // 16 samples in a row
  std::vector<BlockWeights> full_weights;
  std::vector<Split> split;
  std::vector<BlockWeights> split_weights;

  bool empty() const { return full.empty() && split.empty(); }
};

// Whether a slice acts through the pixel at the same place alone.
inline bool same_pixel_only(const SliceTaps& slice) {
  return slice.taps.size() == 1 && slice.taps[0].dx == 0 && slice.taps[0].dy == 0;
}

inline bool same_pixels_only(std::span<const SliceTaps> slices) {
  return std::all_of(slices.begin(), slices.end(), same_pixel_only);
}

// Rows only.
TapBlocks plan_rows(std::span<const PlaneTap> taps, std::int64_t stride);

struct PlanePlan {
  TapBlocks rows;
  TapBlocks columns;  // offsets in the transposed plane; empty where rows alone are as good
};
PlanePlan plan_plane(std::span<const PlaneTap> taps, std::int64_t stride, std::int64_t transposed_stride);

}  // namespace noiseloom
