// Adding rows of fixed-point weights to rows of words, for every instruction set: what void and cluster and
// construction have in common in their inner loops. Included once for each target (Highway's foreach_target).
#if defined(NOISELOOM_CONSTRUCT_ORDER_ROWS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef NOISELOOM_CONSTRUCT_ORDER_ROWS_INL_H
#undef NOISELOOM_CONSTRUCT_ORDER_ROWS_INL_H
#else
#define NOISELOOM_CONSTRUCT_ORDER_ROWS_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace noiseloom::rows::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Behind each row of weights as many words can be read; a whole number of vectors that holds the row ends in zeros.
using Lanes = hn::CappedTag<std::uint32_t, 16>;

// The set lanes of a mask, as bits.
template <class M>
HWY_INLINE std::uint32_t bits_of(Lanes d, M mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  return static_cast<std::uint32_t>(bytes[0]) | (static_cast<std::uint32_t>(bytes[1]) << 8);
}

template <bool On>
struct Adder {
  template <class V>
  HWY_INLINE void operator()(Lanes d, std::uint32_t* words, V weights) const {
    const auto old = hn::LoadU(d, words);
    hn::StoreU(On ? hn::Add(old, weights) : hn::Sub(old, weights), d, words);
  }
};

// weights[0, count) onto words[0, count); what follows count in `weights` may be anything.
template <class A>
HWY_INLINE void add_part(const A& add, std::uint32_t* words, const std::uint32_t* weights, std::size_t count) {
  const Lanes d;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto part = hn::IfThenElseZero(hn::FirstN(d, count - i), hn::LoadU(d, weights + i));
    add(d, words + i, part);
  }
}

// What of the weights [0, lo + hi] around x falls past an end of a line of `width` words, onto its other end.
template <class A>
HWY_INLINE void add_row_past_ends(std::int64_t width, std::int64_t lo, std::int64_t hi, const std::uint32_t* weights,
                                  const A& add, std::int64_t x, std::uint32_t* line) {
  const std::int64_t begin = x - lo;
  const std::int64_t end = x + hi + 1;
  if (begin < 0) {
    const std::int64_t stop = std::min<std::int64_t>(end, 0);
    add_part(add, line + begin + width, weights, static_cast<std::size_t>(stop - begin));
  }
  if (end > width) {
    const std::int64_t start = std::max(begin, width);
    add_part(add, line + (start - width), weights + (start - begin), static_cast<std::size_t>(end - start));
  }
}

// The weights [0, lo + hi] around x of a line of `width` words, which goes on at its other end where it is toroidal.
// A vector past the end of the line is read and written back as it was.
template <class A>
HWY_INLINE void add_row(std::int64_t width, bool toroidal, std::int64_t lo, std::int64_t hi,
                        const std::uint32_t* weights, const A& add, std::int64_t x, std::uint32_t* line) {
  const Lanes d;
  const std::int64_t begin = x - lo;
  const std::int64_t end = x + hi + 1;
  if (HWY_LIKELY(begin >= 0 && end <= width)) {  // zeros follow the row of weights
    const auto count = static_cast<std::size_t>(end - begin);
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) add(d, line + begin + i, hn::LoadU(d, weights + i));
    return;
  }
  const std::int64_t from = std::max<std::int64_t>(begin, 0);
  const std::int64_t to = std::min(end, width);
  if (to > from) add_part(add, line + from, weights + (from - begin), static_cast<std::size_t>(to - from));
  if (toroidal) add_row_past_ends(width, lo, hi, weights, add, x, line);
}

}  // namespace noiseloom::rows::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
