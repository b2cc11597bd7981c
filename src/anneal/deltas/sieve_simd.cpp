#include "anneal/deltas/sieve_simd.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "anneal/deltas/sieve_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "anneal/fields/simd_kernels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace noiseloom::HWY_NAMESPACE {

HWY_INLINE V estimate_lanes(const float* f, const float* b, std::int64_t num_lanes, CellPair pair) {
  const std::int64_t i = std::int64_t{pair.i} * num_lanes;
  const std::int64_t j = std::int64_t{pair.j} * num_lanes;
  V sums[num_parts];
  for (V& sum : sums) sum = hn::Zero(Floats());
  for (std::int64_t n = 0; n < num_lanes; n += std::int64_t{block_lanes}) {
    for (std::size_t p = 0; p < num_parts; ++p) {
      const V features = hn::Sub(load_full(f + j + n, p), load_full(f + i + n, p));
      const V pulls = hn::Sub(load_full(b + i + n, p), load_full(b + j + n, p));
      sums[p] = hn::Add(sums[p], hn::Mul(features, pulls));
    }
  }
  return fold_parts(sums);
}

void estimate_swaps(const float* f, const float* b, std::int64_t num_lanes, std::span<const CellPair> pairs,
                    float* out) {
  std::size_t k = 0;
  for (; k + vector_lanes <= pairs.size(); k += vector_lanes) {
    V sums[vector_lanes];
    for (std::size_t lane = 0; lane < vector_lanes; ++lane) {
      sums[lane] = estimate_lanes(f, b, num_lanes, pairs[k + lane]);
    }
    fold_each(sums);
    hn::StoreU(sums[0], Floats(), out + k);
  }
  for (; k < pairs.size(); ++k) out[k] = fold(Floats(), estimate_lanes(f, b, num_lanes, pairs[k]));
}

// out[n..] = a vector of the product of a symmetric matrix and the numbers value(m), m < num_lanes.
template <class Value>
HWY_INLINE V product_at(const float* matrix, std::int64_t num_lanes, std::int64_t n, const Value& value) {
  V sum = hn::Zero(Floats());
  for (std::int64_t m = 0; m < num_lanes; ++m) {
    sum = hn::Add(sum, hn::Mul(set(value(m)), hn::LoadU(Floats(), matrix + m * num_lanes + n)));
  }
  return sum;
}

void mix_cells(const float* matrix, std::int64_t num_lanes, std::int64_t num_cells, const float* f, float scale,
               float* b) {
  float sums[most_mixed_lanes];
  for (std::int64_t cell = 0; cell < num_cells; ++cell, f += num_lanes, b += num_lanes) {
    for (std::int64_t n = 0; n < num_lanes; n += static_cast<std::int64_t>(vector_lanes)) {
      hn::StoreU(hn::Add(hn::LoadU(Floats(), b + n), hn::Mul(set(scale), hn::LoadU(Floats(), f + n))), Floats(),
                 sums + n);
    }
    for (std::int64_t n = 0; n < num_lanes; n += static_cast<std::int64_t>(vector_lanes)) {
      hn::StoreU(product_at(matrix, num_lanes, n, [&](std::int64_t m) { return sums[m]; }), Floats(), b + n);
    }
  }
}

void mix_difference(const float* matrix, std::int64_t num_lanes, const float* a, const float* b, float* out) {
  for (std::int64_t n = 0; n < num_lanes; n += static_cast<std::int64_t>(vector_lanes)) {
    hn::StoreU(product_at(matrix, num_lanes, n, [&](std::int64_t m) { return a[m] - b[m]; }), Floats(), out + n);
  }
}

HWY_INLINE void add_run(const float* weights, std::int64_t count, V change, std::int64_t num_lanes, float* b) {
  for (std::int64_t k = 0; k < count; ++k, b += num_lanes) {
    hn::StoreU(hn::Add(hn::LoadU(Floats(), b), hn::Mul(set(weights[k]), change)), Floats(), b);
  }
}

// A row that goes beyond the window comes in again at its other end where the window is the whole slice.
HWY_INLINE void add_row(const FootprintRow& row, const float* weights, const FieldLayout& layout, std::int64_t x,
                        V change, std::int64_t num_lanes, float* line) {
  const std::int64_t first = x + row.dx;
  const std::int64_t end = first + row.count;
  if (first >= 0 && end <= layout.width) {
    add_run(weights, row.count, change, num_lanes, line + first * num_lanes);
    return;
  }
  const std::int64_t begin = std::max<std::int64_t>(first, 0);
  add_run(weights + (begin - first), std::min(end, layout.width) - begin, change, num_lanes, line + begin * num_lanes);
  if (!layout.wraps_x) return;
  add_run(weights, std::min(-first, row.count), change, num_lanes, line + (first + layout.width) * num_lanes);
  const std::int64_t beyond = std::max(first, layout.width);
  add_run(weights + (beyond - first), end - beyond, change, num_lanes, line + (beyond - layout.width) * num_lanes);
}

void add_footprint(const FootprintRows& footprint, const FieldLayout& layout, std::int64_t x, std::int64_t y,
                   const float* change, float sign, std::int64_t num_lanes, float* b) {
  for (std::int64_t n = 0; n < num_lanes; n += static_cast<std::int64_t>(vector_lanes)) {
    const V signed_change = hn::Mul(set(sign), hn::LoadU(Floats(), change + n));
    for (const FootprintRow& row : footprint.rows) {
      std::int64_t at_y = y + row.dy;
      if (at_y < 0 || at_y >= layout.height) {
        if (!layout.wraps_y) continue;
        at_y += at_y < 0 ? layout.height : -layout.height;
      }
      add_row(row, footprint.weights + row.first, layout, x, signed_change, num_lanes,
              b + at_y * layout.width * num_lanes + n);
    }
  }
}

}  // namespace noiseloom::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace noiseloom {

HWY_EXPORT(estimate_swaps);
HWY_EXPORT(mix_cells);
HWY_EXPORT(mix_difference);
HWY_EXPORT(add_footprint);

void estimate_swaps(const float* f, const float* b, std::int64_t num_lanes, std::span<const CellPair> pairs,
                    float* out) {
  HWY_DYNAMIC_DISPATCH(estimate_swaps)(f, b, num_lanes, pairs, out);
}

void mix_cells(const float* matrix, std::int64_t num_lanes, std::int64_t num_cells, const float* f, float scale,
               float* b) {
  HWY_DYNAMIC_DISPATCH(mix_cells)(matrix, num_lanes, num_cells, f, scale, b);
}

void mix_difference(const float* matrix, std::int64_t num_lanes, const float* a, const float* b, float* out) {
  HWY_DYNAMIC_DISPATCH(mix_difference)(matrix, num_lanes, a, b, out);
}

void add_footprint(const FootprintRows& footprint, const FieldLayout& layout, std::int64_t x, std::int64_t y,
                   const float* change, float sign, std::int64_t num_lanes, float* b) {
  HWY_DYNAMIC_DISPATCH(add_footprint)(footprint, layout, x, y, change, sign, num_lanes, b);
}

}  // namespace noiseloom
#endif
