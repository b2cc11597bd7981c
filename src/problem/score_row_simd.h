// Sums of distances between rows of scalars, or of points of a circle: the inner loop of the score.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace noiseloom {

// The taps of one row of a footprint.
struct RowTaps {
  std::span<const std::int32_t> offsets;
  std::span<const double> weights;
};

// sum_k weights[k] sum_{i < count} |a[i] - b[i + offsets[k]]|; the same bits on every instruction set.
double scalar_row_sum(const RowTaps& taps, const double* a, const double* b, std::size_t count);
// The same with min(d, 1 - d) for d = |a - b|.
double circle_row_sum(const RowTaps& taps, const double* a, const double* b, std::size_t count);

}  // namespace noiseloom
