// Bringing leaves up to date with the picks that wait, for every instruction set. Included once for each target
// (Highway's foreach_target).
#if defined(NOISELOOM_CONSTRUCT_ORDER_VAC_PENDING_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef NOISELOOM_CONSTRUCT_ORDER_VAC_PENDING_INL_H
#undef NOISELOOM_CONSTRUCT_ORDER_VAC_PENDING_INL_H
#else
#define NOISELOOM_CONSTRUCT_ORDER_VAC_PENDING_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cstdint>

#include "construct/fields/rows-inl.h"
#include "construct/fields/vac_pending.h"

HWY_BEFORE_NAMESPACE();
namespace noiseloom::vac_simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The part of a leaf that lies in one row: pixels [begin, end) of the row y of the bins' rows. The leaf's first pixel
// would be at x = `origin` of this row.
struct Segment {
  std::int64_t y;
  std::int64_t begin;
  std::int64_t end;
  std::int64_t origin;
};

// Where in the table of weights those of the picks found so far begin, seen from the leaf's first pixel.
struct FoundPicks {
  static constexpr std::size_t capacity = 256;
  std::array<std::uint32_t, capacity + VacPending::bin_size> starts;
  std::size_t count = 0;
};

// Bins along an axis that a segment may hear of: which they are, and where they begin, seen from the segment (around
// the torus).
struct NearBins {
  static constexpr std::size_t most = 12;  // a reach of 32 to both sides, cut at an end of the torus
  std::array<std::int64_t, most> bin;
  std::array<std::int64_t, most> begin;
  std::size_t count = 0;

  // Those that hold coordinates [first, last], each of which stands for one of [0, size) or, without a torus, for none.
  HWY_INLINE NearBins(std::int64_t first, std::int64_t last, std::int64_t size, bool toroidal, int bits) {
    add(std::max<std::int64_t>(first, 0), std::min(last, size - 1), 0, bits);
    if (!toroidal) return;
    if (first < 0) add(first + size, size - 1, -size, bits);
    if (last >= size) add(0, last - size, size, bits);
  }

 private:
  HWY_INLINE void add(std::int64_t first, std::int64_t last, std::int64_t shift, int bits) {
    for (std::int64_t b = first >> bits; b <= last >> bits; ++b) {
      bin[count] = b;
      begin[count++] = (b << bits) + shift;
    }
  }
};

// Adds the weights of the picks found to the pixels [begin, end) of a leaf.
HWY_INLINE void add_found(const VacPending& pending, std::int64_t begin, std::int64_t end, std::uint32_t* words,
                          FoundPicks& found) {
  using rows::HWY_NAMESPACE::Lanes;
  const Lanes d;
  const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
  const bool whole = begin == 0 && end == 64;
  const std::uint32_t* const weights = pending.weights.data();
  for (std::int64_t i = 0; i < 64; i += 2 * lanes) {
    auto sum0 = hn::Zero(d);
    auto sum1 = hn::Zero(d);
    for (std::size_t k = 0; k < found.count; ++k) {
      const std::uint32_t* const row = weights + found.starts[k] + i;
      sum0 = hn::Add(sum0, hn::LoadU(d, row));
      sum1 = hn::Add(sum1, hn::LoadU(d, row + lanes));
    }
    if (whole) {
      hn::StoreU(hn::Add(hn::LoadU(d, words + i), sum0), d, words + i);
      hn::StoreU(hn::Add(hn::LoadU(d, words + i + lanes), sum1), d, words + i + lanes);
      continue;
    }
    HWY_ALIGN std::uint32_t sums[2 * hn::MaxLanes(d)];
    hn::Store(sum0, d, sums);
    hn::Store(sum1, d, sums + lanes);
    for (std::int64_t k = std::max(begin, i); k < std::min(end, i + 2 * lanes); ++k) words[k] += sums[k - i];
  }
  found.count = 0;
}

// Finds the picks that the segment has not got yet, bin by bin, and adds their weights.
HWY_INLINE void bring_up_segment(const VacPending& pending, const VacLayout& layout, const VacPending::Bin* bins,
                                 std::uint32_t since, const Segment& segment, std::uint32_t* leaf_words) {
  using rows::HWY_NAMESPACE::Lanes;
  const Lanes d;
  const auto set = [d](std::int64_t value) HWY_ATTR { return hn::Set(d, static_cast<std::uint32_t>(value)); };
  const NearBins rows_of_bins(segment.y - pending.reach_y, segment.y + pending.reach_y, layout.size[1],
                              layout.toroidal[1], VacPending::y_bits);
  const NearBins columns(segment.begin - pending.reach_x, segment.end - 1 + pending.reach_x, layout.size[0],
                         layout.toroidal[0], VacPending::x_bits);
  const std::int64_t begin = segment.begin - segment.origin;
  const std::int64_t end = segment.end - segment.origin;
  const auto before = hn::Set(d, since - 1);
  const auto mask_x = set((1 << VacPending::x_bits) - 1);
  const auto mask_y = set((1 << VacPending::y_bits) - 1);
  const auto end_x = set(segment.end - segment.begin + 2 * pending.reach_x);
  const auto end_y = set(2 * pending.reach_y + 1);
  const auto row_words = set(pending.row_words);
  FoundPicks found;
  for (std::size_t by = 0; by < rows_of_bins.count; ++by) {
    const std::int64_t y = rows_of_bins.begin[by];
    const VacPending::Bin* const row = bins + rows_of_bins.bin[by] * pending.bins_per_row;
    const auto from_y = set(y - (segment.y - pending.reach_y));
    const std::int64_t start_of_row =
        (segment.y - y + pending.reach_y) * pending.row_words + segment.origin + pending.first_column;
    for (std::size_t bx = 0; bx < columns.count; ++bx) {
      const std::int64_t x = columns.begin[bx];
      const std::uint32_t* const bin = row[columns.bin[bx]].entries;
      const auto from_x = set(x - (segment.begin - pending.reach_x));
      const auto start = set(start_of_row - x);
      for (std::size_t i = 0; i < VacPending::bin_size; i += hn::Lanes(d)) {
        const auto entries = hn::Load(d, bin + i);
        const auto entry_x = hn::And(entries, mask_x);
        const auto entry_y = hn::And(hn::ShiftRight<VacPending::x_bits>(entries), mask_y);
        const auto in_x = hn::Lt(hn::Add(entry_x, from_x), end_x);
        const auto in_y = hn::Lt(hn::Add(entry_y, from_y), end_y);
        const auto mask = hn::And(hn::Gt(entries, before), hn::And(in_x, in_y));
        const auto starts = hn::Sub(hn::Sub(start, hn::Mul(entry_y, row_words)), entry_x);
        hn::StoreU(hn::Compress(starts, mask), d, found.starts.data() + found.count);
        found.count += hn::CountTrue(d, mask);
      }
      if (found.count > FoundPicks::capacity - VacPending::bin_size) {
        add_found(pending, begin, end, leaf_words, found);
      }
    }
  }
  add_found(pending, begin, end, leaf_words, found);
}

// Adds to the words of a leaf what waits for it. `slice`: counted from the first that is present.
HWY_INLINE void bring_up(VacPending& pending, const VacLayout& layout, std::uint32_t* words, std::int64_t slice,
                         std::int64_t leaf) {
  std::uint32_t& up_to = pending.up_to[static_cast<std::size_t>(slice * layout.leaves + leaf)];
  if (up_to == pending.batch) return;
  const std::uint32_t since = up_to << (VacPending::x_bits + VacPending::y_bits);
  up_to = static_cast<std::uint32_t>(pending.batch);
  const VacPending::Bin* const bins = pending.bins.data() + slice * pending.bins_per_slice;
  const std::int64_t width = layout.size[0];
  const std::int64_t first = leaf * 64;
  const std::int64_t end = std::min(first + 64, layout.cells);
  for (std::int64_t cell = first; cell < end;) {
    const std::int64_t y = cell / width;
    const std::int64_t x = cell - y * width;
    const std::int64_t end_x = std::min(width, x + end - cell);
    bring_up_segment(pending, layout, bins, since, {y, x, end_x, x - (cell - first)}, words + leaf * 64);
    cell += end_x - x;
  }
}

}  // namespace noiseloom::vac_simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
