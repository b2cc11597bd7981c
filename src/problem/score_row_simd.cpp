// The sums of scalars and circles, vectorised for each instruction set; which one runs is found at run time. Eight
// partial sums in a fixed order and no fused operations: the bits do not depend on the instruction set.
#include "problem/score_row_simd.h"

#include <algorithm>
#include <iterator>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "problem/score_row_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace noiseloom::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t lanes = 8;
using D = hn::CappedTag<double, lanes>;
using V = hn::Vec<D>;
constexpr std::size_t vector_lanes = hn::MaxLanes(D());
constexpr std::size_t num_parts = lanes / vector_lanes;
// Taps that share the loads of a.
constexpr std::size_t taps_at_once = 4;

// sums[k] += d(a, b_k), lane by lane.
template <bool circle>
HWY_INLINE void add_distances(const double* a, const double* const (&b)[taps_at_once], std::size_t at,
                              V (&sums)[taps_at_once][num_parts]) {
  for (std::size_t p = 0; p < num_parts; ++p) {
    const V x = hn::LoadU(D(), a + at + p * vector_lanes);
    for (std::size_t k = 0; k < taps_at_once; ++k) {
      V d = hn::Abs(hn::Sub(x, hn::LoadU(D(), b[k] + at + p * vector_lanes)));
      if constexpr (circle) d = hn::Min(d, hn::Sub(hn::Set(D(), 1), d));
      sums[k][p] = hn::Add(sums[k][p], d);
    }
  }
}

template <bool circle>
double row_sum(const RowTaps& taps, const double* a, const double* b, std::size_t count) {
  const std::size_t whole = count / lanes * lanes;
  double a_last[lanes] = {};  // what is left of a row, with zeros
  std::copy(a + whole, a + count, a_last);
  V total[num_parts];
  for (V& part : total) part = hn::Zero(D());
  for (std::size_t first = 0; first < taps.weights.size(); first += taps_at_once) {
    const double* from[taps_at_once];
    const double* from_last[taps_at_once];
    double last[taps_at_once][lanes] = {};
    V sums[taps_at_once][num_parts];
    for (std::size_t k = 0; k < taps_at_once; ++k) {
      from[k] = b + taps.offsets[std::min(first + k, taps.offsets.size() - 1)];
      from_last[k] = last[k];
      std::copy(from[k] + whole, from[k] + count, last[k]);
      for (V& part : sums[k]) part = hn::Zero(D());
    }
    for (std::size_t i = 0; i < whole; i += lanes) add_distances<circle>(a, from, i, sums);
    if (whole < count) add_distances<circle>(a_last, from_last, 0, sums);
    for (std::size_t k = 0; k < taps_at_once && first + k < taps.weights.size(); ++k) {
      const V weight = hn::Set(D(), taps.weights[first + k]);
      for (std::size_t p = 0; p < num_parts; ++p) total[p] = hn::Add(total[p], hn::Mul(weight, sums[k][p]));
    }
  }
  double sums[lanes];
  for (std::size_t p = 0; p < num_parts; ++p) hn::StoreU(total[p], D(), sums + p * vector_lanes);
  return ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]));
}

double scalar_row_sum(const RowTaps& taps, const double* a, const double* b, std::size_t count) {
  return row_sum<false>(taps, a, b, count);
}
double circle_row_sum(const RowTaps& taps, const double* a, const double* b, std::size_t count) {
  return row_sum<true>(taps, a, b, count);
}

}  // namespace noiseloom::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace noiseloom {

HWY_EXPORT(scalar_row_sum);
HWY_EXPORT(circle_row_sum);

double scalar_row_sum(const RowTaps& taps, const double* a, const double* b, std::size_t count) {
  return HWY_DYNAMIC_DISPATCH(scalar_row_sum)(taps, a, b, count);
}
double circle_row_sum(const RowTaps& taps, const double* a, const double* b, std::size_t count) {
  return HWY_DYNAMIC_DISPATCH(circle_row_sum)(taps, a, b, count);
}

}  // namespace noiseloom
#endif
