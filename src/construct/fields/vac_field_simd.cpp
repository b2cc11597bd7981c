#include "construct/fields/vac_field_simd.h"

#include <algorithm>
#include <array>
#include <bit>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "construct/fields/vac_field_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "construct/fields/rows-inl.h"
#include "construct/fields/vac_pending-inl.h"

HWY_BEFORE_NAMESPACE();
namespace noiseloom::vac_simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using rows::HWY_NAMESPACE::Adder;
using rows::HWY_NAMESPACE::bits_of;
using rows::HWY_NAMESPACE::Lanes;

template <bool On>
struct WatchingAdder {
  const std::uint32_t* data;
  std::uint32_t limit;
  std::vector<std::size_t>* hits;

  template <class V>
  HWY_INLINE void operator()(Lanes d, std::uint32_t* words, V weights) const {
    const auto old = hn::LoadU(d, words);
    const auto value = On ? hn::Add(old, weights) : hn::Sub(old, weights);
    hn::StoreU(value, d, words);
    const auto past = On ? hn::Gt(value, hn::Set(d, limit - 1)) : hn::Lt(value, hn::Set(d, limit + 1));
    const auto mask = hn::And(past, hn::Ne(weights, hn::Zero(d)));
    if (HWY_LIKELY(hn::AllFalse(d, mask))) return;
    for (std::uint32_t bits = bits_of(d, mask); bits != 0; bits &= bits - 1) {
      hits->push_back(static_cast<std::size_t>(words - data) + static_cast<std::size_t>(std::countr_zero(bits)));
    }
  }
};

template <class A>
HWY_INLINE void add_row(const VacLayout& layout, const VacRow& row, const std::uint32_t* weights, const A& add,
                        std::int64_t x, std::uint32_t* words) {
  rows::HWY_NAMESPACE::add_row(layout.size[0], layout.toroidal[0], row.lo, row.hi, weights + row.first, add, x, words);
}

// Calls visit(row, x, words of the row's line) for the kernel rows that meet the slice of `position`.
template <class Word, class Visit>
HWY_INLINE void each_plane_row(const VacLayout& layout, const VacGroupKernel& group, Word* data, std::uint64_t position,
                               const Visit& visit) {
  const auto cell = static_cast<std::int64_t>(position) % layout.cells;
  const std::int64_t slice = static_cast<std::int64_t>(position) / layout.cells;
  if (!layout.has_slice(slice)) return;
  const std::int64_t width = layout.size[0];
  const std::int64_t x = cell % width;
  const std::int64_t y = cell / width;
  Word* const words = data + (slice - layout.slice_begin) * layout.slice_words;
  for (const VacRow& row : group.rows) {
    std::int64_t row_y = y;
    if (layout.move(row_y, 1, row.offset[0])) visit(row, x, words + row_y * width);
  }
}

template <class A>
HWY_INLINE void add_plane(const VacLayout& layout, const VacGroupKernel& group, std::uint32_t* data, const A& add,
                          std::uint64_t position) {
  each_plane_row(layout, group, data, position, [&](const VacRow& row, std::int64_t x, std::uint32_t* line) HWY_ATTR {
    add_row(layout, row, group.weights.data(), add, x, line);
  });
}

// Fetches the lines that add_plane will write to.
HWY_INLINE void prefetch_plane(const VacLayout& layout, const VacGroupKernel& group, const std::uint32_t* data,
                               std::uint64_t position) {
  each_plane_row(layout, group, data, position,
                 [](const VacRow& row, std::int64_t x, const std::uint32_t* line) HWY_ATTR {
                   const std::uint32_t* const begin = line + std::max<std::int64_t>(x - row.lo, 0);
                   __builtin_prefetch(begin, 1);
                   __builtin_prefetch(begin + row.lo + row.hi, 1);
                 });
}

template <class A>
HWY_INLINE void add_any(const VacLayout& layout, const VacGroupKernel& group, std::uint32_t* data, const A& add,
                        std::uint64_t position) {
  const VacLayout::Coord at = layout.coord(position);
  if (group.edges == VacEdges::cross && !group.reaches_an_edge(at[0], layout.size[0], at[1], layout.size[1])) return;
  // Rows of one slice follow each other: `others` ascend, and the first of them changes from row to row.
  const std::int64_t own_slice = static_cast<std::int64_t>(position) / layout.cells;
  const std::size_t first_slice_axis = !group.others.empty() && group.others[0] == 1 ? 1 : 0;
  const VacRow* first_of_slice = nullptr;
  std::int64_t slice = own_slice;
  bool is_present = false;
  for (const VacRow& row : group.rows) {
    bool another = first_of_slice == nullptr;
    for (std::size_t i = first_slice_axis; i < group.others.size() && !another; ++i) {
      another = row.offset[i] != first_of_slice->offset[i];
    }
    if (another) {
      first_of_slice = &row;
      slice = own_slice;
      is_present = true;
      for (std::size_t i = first_slice_axis; i < group.others.size() && is_present; ++i) {
        const auto a = static_cast<std::size_t>(group.others[i]);
        std::int64_t c = at[a];
        is_present = layout.move(c, group.others[i], row.offset[i]);
        slice += (c - at[a]) * layout.slice_step[a];
      }
      is_present = is_present && layout.has_slice(slice);
    }
    if (!is_present) continue;
    std::int64_t y = at[1];
    if (first_slice_axis == 1 && !layout.move(y, 1, row.offset[0])) continue;
    const bool crosses = first_slice_axis == 1 && y != at[1] + row.offset[0];
    std::uint32_t* const words = data + (slice - layout.slice_begin) * layout.slice_words + y * layout.size[0];
    if (group.edges == VacEdges::pass || (crosses && group.edges == VacEdges::cross)) {
      add_row(layout, row, group.weights.data(), add, at[0], words);
    } else if (group.edges == VacEdges::cross && layout.toroidal[0]) {
      rows::HWY_NAMESPACE::add_row_past_ends(layout.size[0], row.lo, row.hi, group.weights.data() + row.first, add,
                                             at[0], words);
    } else if (group.edges == VacEdges::stay && !crosses) {
      rows::HWY_NAMESPACE::add_row(layout.size[0], false, row.lo, row.hi, group.weights.data() + row.first, add, at[0],
                                   words);
    }
  }
}

template <class A>
HWY_INLINE void add_planes(const VacLayout& layout, const VacGroupKernel& group, std::uint32_t* data, const A& add,
                           std::span<const std::uint64_t> positions) {
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (i + 2 < positions.size()) prefetch_plane(layout, group, data, positions[i + 2]);
    add_plane(layout, group, data, add, positions[i]);
  }
}

template <class A>
HWY_INLINE void add_group(const VacLayout& layout, const VacGroupKernel& group, std::uint32_t* data, const A& add,
                          std::span<const std::uint64_t> positions) {
  if (group.is_of_plane()) {
    add_planes(layout, group, data, add, positions);
  } else {
    for (const std::uint64_t position : positions) add_any(layout, group, data, add, position);
  }
}

void AddRows(const VacLayout& layout, const VacGroupKernel& group, std::uint32_t* data, bool on,
             std::span<const std::uint64_t> positions) {
  if (on) {
    add_group(layout, group, data, Adder<true>{}, positions);
  } else {
    add_group(layout, group, data, Adder<false>{}, positions);
  }
}

void AddRowsWatching(const VacLayout& layout, const VacGroupKernel& group, std::uint32_t* data, bool on,
                     std::uint64_t position, std::uint32_t limit, std::vector<std::size_t>& hits) {
  const std::span<const std::uint64_t> one(&position, 1);
  if (on) {
    add_group(layout, group, data, WatchingAdder<true>{data, limit, &hits}, one);
  } else {
    add_group(layout, group, data, WatchingAdder<false>{data, limit, &hits}, one);
  }
}

// Calls visit(leaf, words of the leaf, number of pixels) for every leaf of slice `s` from `leaf` on. A leaf at the end
// of a slice is handed out as a copy filled up with what no view looks for.
constexpr std::size_t leaf_words = 64;
struct LeafCopy {
  alignas(64) std::array<std::uint32_t, leaf_words> words;
};
HWY_INLINE const std::uint32_t* leaf_of(const VacLayout& layout, const std::uint32_t* slice, std::int64_t leaf,
                                        VacView view, LeafCopy& copy) {
  const std::int64_t begin = leaf * static_cast<std::int64_t>(leaf_words);
  const std::int64_t left = layout.cells - begin;
  if (left >= static_cast<std::int64_t>(leaf_words)) return slice + begin;
  copy.words.fill(~static_cast<std::uint32_t>(view));
  std::copy_n(slice + begin, left, copy.words.begin());
  return copy.words.data();
}

void LeafMinima(const VacLayout& layout, const std::uint32_t* data, VacView view, std::uint32_t* bounds) {
  const Lanes d;
  const auto flip = hn::Set(d, static_cast<std::uint32_t>(view));
  LeafCopy copy;
  for (std::int64_t slice = layout.slice_begin; slice < layout.slice_end; ++slice, data += layout.slice_words) {
    for (std::int64_t leaf = 0; leaf < layout.leaves; ++leaf) {
      const std::uint32_t* words = leaf_of(layout, data, leaf, view, copy);
      auto least = hn::Set(d, ~std::uint32_t{0});
      for (std::size_t i = 0; i < leaf_words; i += hn::Lanes(d)) {
        least = hn::Min(least, hn::Xor(hn::LoadU(d, words + i), flip));
      }
      *bounds++ = hn::GetLane(hn::MinOfLanes(d, least));
    }
  }
}

struct Scan {
  const VacScan& asked;
  std::uint32_t view;
  std::uint32_t energy_limit;
  std::uint32_t hash_limit;
  std::vector<VacCandidate>* found;

  // Appends the pixels of a leaf within the limits; returns the smallest value of the others.
  HWY_INLINE std::uint32_t leaf(const std::uint32_t* words, std::uint64_t position) const {
    const Lanes d;
    const auto flip = hn::Set(d, view);
    const auto none = hn::Set(d, ~std::uint32_t{0});
    const auto limit = hn::Set(d, energy_limit + 1);
    auto least = none;
    std::uint32_t rest = ~std::uint32_t{0};
    for (std::size_t i = 0; i < leaf_words; i += hn::Lanes(d)) {
      const auto value = hn::Xor(hn::LoadU(d, words + i), flip);
      const auto within = hn::Lt(value, limit);
      least = hn::Min(least, hn::IfThenElse(within, none, value));
      if (hn::AllFalse(d, within)) continue;
      for (std::uint32_t bits = bits_of(d, within); bits != 0; bits &= bits - 1) {
        const std::size_t lane = i + static_cast<std::size_t>(std::countr_zero(bits));
        const std::uint32_t energy = words[lane] ^ view;
        const std::uint32_t tie = asked.hash(position + lane) ^ view;
        if (energy < energy_limit || tie <= hash_limit) {
          found->push_back({position + lane + static_cast<std::uint64_t>(asked.shift), energy, tie});
        } else {
          rest = energy;
        }
      }
    }
    return std::min(rest, hn::GetLane(hn::MinOfLanes(d, least)));
  }
};

void BringUpAll(const VacLayout& layout, std::uint32_t* data, VacPending& pending) {
  for (std::int64_t slice = 0; slice < layout.slice_end - layout.slice_begin; ++slice) {
    for (std::int64_t leaf = 0; leaf < layout.leaves; ++leaf) {
      bring_up(pending, layout, data + slice * layout.slice_words, slice, leaf);
    }
  }
}

bool ScanLeaves(const VacLayout& layout, std::int64_t slice, std::int64_t begin, std::int64_t end, std::uint32_t* data,
                VacPending* pending, const VacScan& asked, std::uint32_t* bounds, std::vector<VacCandidate>& found) {
  const Lanes d;
  const Scan scan{asked, static_cast<std::uint32_t>(asked.view), static_cast<std::uint32_t>(asked.limit >> 32),
                  static_cast<std::uint32_t>(asked.limit), &found};
  const auto open_limit = hn::Set(d, scan.energy_limit + 1);  // unsigned vectors have < and > only
  LeafCopy copy;
  const auto local = slice - layout.slice_begin;
  std::uint32_t* const words = data + local * layout.slice_words;
  std::uint32_t* const slice_bounds = bounds + local * layout.leaves;
  const auto lanes = static_cast<std::int64_t>(hn::Lanes(d));
  HWY_ALIGN std::array<std::uint32_t, hn::MaxLanes(d)> last;
  const auto opened = [&](std::int64_t i) HWY_ATTR {  // of the leaves from i on, as bits
    const std::uint32_t* some = slice_bounds + i;
    if (end - i < lanes) {  // those behind are not looked at: another thread may write to them
      last.fill(~std::uint32_t{0});
      some = std::copy_n(some, end - i, last.begin()) - (end - i);
    }
    const auto open = hn::Lt(hn::LoadU(d, some), open_limit);
    return hn::AllFalse(d, open) ? std::uint32_t{0} : bits_of(d, open);
  };
  std::uint32_t bits = begin < end ? opened(begin) : 0;
  for (std::int64_t i = begin; i < end; i += lanes) {
    const std::uint32_t next = i + lanes < end ? opened(i + lanes) : 0;
    for (std::uint32_t rest = next; rest != 0; rest &= rest - 1) {
      const std::uint32_t* leaf = words + (i + lanes + std::countr_zero(rest)) * 64;
      for (int line = 0; line < 4; ++line) __builtin_prefetch(leaf + 16 * line);
    }
    for (; bits != 0; bits &= bits - 1) {
      const std::int64_t leaf = i + std::countr_zero(bits);
      const auto position = static_cast<std::uint64_t>(slice * layout.cells + leaf * 64);
      if (pending != nullptr) bring_up(*pending, layout, words, local, leaf);
      slice_bounds[leaf] = scan.leaf(leaf_of(layout, words, leaf, asked.view, copy), position);
      if (found.size() > asked.max_found) return false;
    }
    bits = next;
  }
  return true;
}

}  // namespace noiseloom::vac_simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace noiseloom::vac_simd {

HWY_EXPORT(AddRows);
HWY_EXPORT(AddRowsWatching);
HWY_EXPORT(LeafMinima);
HWY_EXPORT(ScanLeaves);
HWY_EXPORT(BringUpAll);

void add_rows(const VacLayout& layout, const VacGroupKernel& group, std::uint32_t* data, bool on,
              std::span<const std::uint64_t> positions) {
  HWY_DYNAMIC_DISPATCH(AddRows)(layout, group, data, on, positions);
}

void add_rows_watching(const VacLayout& layout, const VacGroupKernel& group, std::uint32_t* data, bool on,
                       std::uint64_t position, std::uint32_t limit, std::vector<std::size_t>& hits) {
  HWY_DYNAMIC_DISPATCH(AddRowsWatching)(layout, group, data, on, position, limit, hits);
}

void leaf_minima(const VacLayout& layout, const std::uint32_t* data, VacView view, std::uint32_t* bounds) {
  HWY_DYNAMIC_DISPATCH(LeafMinima)(layout, data, view, bounds);
}

bool scan_leaves(const VacLayout& layout, std::int64_t slice, std::int64_t begin, std::int64_t end, std::uint32_t* data,
                 VacPending* pending, const VacScan& scan, std::uint32_t* bounds, std::vector<VacCandidate>& found) {
  return HWY_DYNAMIC_DISPATCH(ScanLeaves)(layout, slice, begin, end, data, pending, scan, bounds, found);
}

void bring_up_all(const VacLayout& layout, std::uint32_t* data, VacPending& pending) {
  HWY_DYNAMIC_DISPATCH(BringUpAll)(layout, data, pending);
}

}  // namespace noiseloom::vac_simd
#endif
