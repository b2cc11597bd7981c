// Sixteen float lanes on vectors of any width, so that sums have one order everywhere: lane k of every block is added
// to lane k of the sum, and the lanes are folded in halves at the end. Only operations that IEEE 754 rounds exactly,
// and never a fused one: the bits do not depend on the instruction set.
//
// No include guard of the usual kind: compiled once for each target.
#if defined(NOISELOOM_SIMD_LANES) == defined(HWY_TARGET_TOGGLE)
#ifdef NOISELOOM_SIMD_LANES
#undef NOISELOOM_SIMD_LANES
#else
#define NOISELOOM_SIMD_LANES
#endif

#include <hwy/highway.h>

#include <cstddef>

#include "anneal/fields/tap_plan.h"

HWY_BEFORE_NAMESPACE();
namespace noiseloom::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, block_lanes>;
using V = hn::Vec<Floats>;
inline constexpr std::size_t vector_lanes = hn::MaxLanes(Floats());
inline constexpr std::size_t num_parts = block_lanes / vector_lanes;

HWY_INLINE V set(float x) { return hn::Set(Floats(), x); }

// Part p of 16 samples in a row.
HWY_INLINE V load_full(const float* samples, std::size_t p) { return hn::LoadU(Floats(), samples + p * vector_lanes); }
// Part p of 8 samples at `low` and 8 at `high`.
HWY_INLINE V load_split(const float* low, const float* high, std::size_t p) {
#if HWY_TARGET != HWY_SCALAR
  if constexpr (vector_lanes == block_lanes) {
    const hn::Half<Floats> half;
    return hn::Combine(Floats(), hn::LoadU(half, high), hn::LoadU(half, low));
  }
#endif
  const std::size_t lane = p * vector_lanes;
  return hn::LoadU(Floats(), lane < block_lanes / 2 ? low + lane : high + lane - block_lanes / 2);
}

// Lanes k and k + n/2 are added, for n = 16, 8, 4, 2.
template <class D>
HWY_INLINE float fold([[maybe_unused]] D d, hn::Vec<D> v) {
#if HWY_TARGET != HWY_SCALAR
  if constexpr (hn::MaxLanes(d) > 1) {
    const hn::Half<D> half;
    return fold(half, hn::Add(hn::LowerHalf(half, v), hn::UpperHalf(half, v)));
  }
#endif
  return hn::GetLane(v);
}
HWY_INLINE V fold_parts(const V (&sums)[num_parts]) {
  V parts[num_parts];
  for (std::size_t p = 0; p < num_parts; ++p) parts[p] = sums[p];
  for (std::size_t count = num_parts / 2; count > 0; count /= 2) {
    for (std::size_t p = 0; p < count; ++p) parts[p] = hn::Add(parts[p], parts[p + count]);
  }
  return parts[0];
}
HWY_INLINE float fold(const V (&sums)[num_parts]) { return fold(Floats(), fold_parts(sums)); }

#if HWY_TARGET != HWY_SCALAR
// Lane k: of `a` where bit `width` of k is clear, else of `b`, the sum of lanes k and k ^ width.
template <std::size_t width>
HWY_INLINE V add_halves(V a, V b) {
  const Floats d;
  if constexpr (width == 8) {
    return hn::Add(hn::ConcatUpperLower(d, b, a), hn::ConcatLowerUpper(d, b, a));
  } else if constexpr (width == 4) {
    return hn::Add(hn::OddEvenBlocks(b, a), hn::SwapAdjacentBlocks(hn::OddEvenBlocks(a, b)));
  } else if constexpr (width == 2) {
    const hn::Repartition<double, Floats> pairs;
    const auto a2 = hn::BitCast(pairs, a);
    const auto b2 = hn::BitCast(pairs, b);
    return hn::Add(hn::BitCast(d, hn::OddEven(b2, a2)), hn::BitCast(d, hn::Shuffle01(hn::OddEven(a2, b2))));
  } else {
    return hn::Add(hn::OddEven(b, a), hn::Shuffle2301(hn::OddEven(a, b)));
  }
}
#endif

// Lane k of sums[0] becomes fold(sums[k]): the additions of fold(), those of all vectors at once.
template <std::size_t width = vector_lanes / 2>
HWY_INLINE void fold_each([[maybe_unused]] V (&sums)[vector_lanes]) {
#if HWY_TARGET != HWY_SCALAR
  if constexpr (width > 0) {
    for (std::size_t k = 0; k < width; ++k) sums[k] = add_halves<width>(sums[k], sums[k + width]);
    fold_each<width / 2>(sums);
  }
#endif
}

}  // namespace noiseloom::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
