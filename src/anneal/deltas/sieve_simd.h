// The loops of Sieve over features, vectorised; the same bits on every instruction set. Cells hold `num_lanes` floats
// each, one after another; matrices have rows of num_lanes.
#pragma once

#include <cstdint>
#include <span>

#include "noiseloom/anneal/slice_field.h"
#include "noiseloom/anneal/swap_delta.h"

namespace noiseloom {

// Taps side by side: weights[first + k] at (dx + k, dy), k < count.
struct FootprintRow {
  std::int64_t dx;
  std::int64_t dy;
  std::int64_t first;
  std::int64_t count;
};
struct FootprintRows {
  std::span<const FootprintRow> rows;
  const float* weights;
};

// (f_j - f_i) . (b_i - b_j) of each pair of cells.
void estimate_swaps(const float* f, const float* b, std::int64_t num_lanes, std::span<const CellPair> pairs,
                    float* out);
// b = matrix (b + scale f) of every cell; the matrix is symmetric. Requires num_lanes <= most_mixed_lanes.
inline constexpr std::int64_t most_mixed_lanes = 64;
void mix_cells(const float* matrix, std::int64_t num_lanes, std::int64_t num_cells, const float* f, float scale,
               float* b);
// out = matrix (a - b), of one cell each; the matrix is symmetric.
void mix_difference(const float* matrix, std::int64_t num_lanes, const float* a, const float* b, float* out);
// b += sign weight change, at the cells of the window where the footprint around (x, y) has its taps.
void add_footprint(const FootprintRows& footprint, const FieldLayout& layout, std::int64_t x, std::int64_t y,
                   const float* change, float sign, std::int64_t num_lanes, float* b);

}  // namespace noiseloom
