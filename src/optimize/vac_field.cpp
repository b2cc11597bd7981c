#include "optimize/vac_field.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstdlib>
#include <new>

#include "optimize/vac_field_simd.h"

namespace noiseloom {
namespace {

constexpr std::int64_t line_words = 16;
constexpr std::int64_t leaf_words = 64;

std::uint32_t* allocate_words(std::size_t count) {
  // Footprints over slice axes touch a page for every slice: huge pages keep them within reach of the TLB.
  constexpr std::size_t huge_page = std::size_t{1} << 21;
  const std::size_t alignment = count * sizeof(std::uint32_t) >= huge_page ? huge_page : 64;
  const std::size_t bytes = (count * sizeof(std::uint32_t) + alignment - 1) / alignment * alignment;
  void* memory = std::aligned_alloc(alignment, bytes);
  if (memory == nullptr) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
  if (alignment == huge_page) madvise(memory, bytes, MADV_HUGEPAGE);  // only advice: failure costs speed alone
#endif
  return static_cast<std::uint32_t*>(memory);
}

bool contains_x(const VacGroupKernel& group) { return group.axis0 == 0; }

}  // namespace

VacLayout::VacLayout(const VacSpec& spec, SliceIndex begin, SliceIndex end)
    : num_axes(spec.extents.num_axes()),
      size{},
      toroidal{},
      slice_step{},
      cells(spec.extents.cells_per_slice()),
      slice_begin(begin),
      slice_end(end),
      leaves((cells + leaf_words - 1) / leaf_words) {
  std::int64_t step = 1;
  for (int axis = 0; axis < num_axes; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    size[a] = spec.extents.size(axis);
    toroidal[a] = spec.toroidal.empty() || spec.toroidal[a];
    if (axis < 2) continue;
    slice_step[a] = step;
    step *= size[a];
  }
  // At least a whole vector behind each slice (a row of taps is padded with zeros), and an odd number of lines.
  const std::int64_t lines = (cells + line_words - 1) / line_words + 1;
  slice_words = (lines | 1) * line_words;
}

VacLayout::Coord VacLayout::coord(std::uint64_t position) const {
  Coord result{};
  for (std::size_t a = 0; a < static_cast<std::size_t>(num_axes); ++a) {
    const auto n = static_cast<std::uint64_t>(size[a]);
    result[a] = static_cast<std::int64_t>(position % n);
    position /= n;
  }
  return result;
}

void VacFree::operator()(void* memory) const { std::free(memory); }

VacField::VacField(const VacSpec& spec, const VacKernel& kernel, SliceIndex slice_begin, SliceIndex slice_end)
    : layout_(spec, slice_begin, slice_end),
      kernel_(kernel),
      num_words_(static_cast<std::size_t>((slice_end - slice_begin) * layout_.slice_words + line_words)),
      data_(allocate_words(num_words_)),
      bounds_(static_cast<std::size_t>((slice_end - slice_begin) * layout_.leaves + line_words)) {
  clear();
}

bool VacField::has(std::uint64_t position) const {
  return layout_.has_slice(static_cast<std::int64_t>(position) / layout_.cells);
}

std::size_t VacField::index(std::uint64_t position) const {
  const auto p = static_cast<std::int64_t>(position);
  return static_cast<std::size_t>((p / layout_.cells - layout_.slice_begin) * layout_.slice_words + p % layout_.cells);
}

std::size_t VacField::leaf(std::uint64_t position) const {
  const auto p = static_cast<std::int64_t>(position);
  const std::int64_t slice = p / layout_.cells - layout_.slice_begin;
  return static_cast<std::size_t>(slice * layout_.leaves + p % layout_.cells / leaf_words);
}

void VacField::clear() { std::fill_n(data_.get(), num_words_, 0U); }

// Calls visit(word, weight) for every tap of a group without x around `position`.
template <class Visit>
static void visit_points(const VacLayout& layout, const VacGroupKernel& group, std::uint64_t position,
                         std::uint32_t* data, const Visit& visit) {
  const VacLayout::Coord at = layout.coord(position);
  const auto a0 = static_cast<std::size_t>(group.axis0);
  const std::int64_t n = layout.size[a0];
  const std::int64_t own_slice = static_cast<std::int64_t>(position) / layout.cells;
  // A step along axis0 in slices and in words; along y it stays in its slice.
  const std::int64_t slice_step = layout.slice_step[a0];
  const std::int64_t word_step = a0 == 1 ? layout.size[0] : slice_step * layout.slice_words;
  for (const VacRow& row : group.rows) {
    std::int64_t slice = own_slice - at[a0] * slice_step;
    bool inside = true;
    for (std::size_t i = 0; i < group.others.size() && inside; ++i) {
      const auto a = static_cast<std::size_t>(group.others[i]);
      std::int64_t c = at[a];
      inside = layout.move(c, group.others[i], row.offset[i]);
      slice += (c - at[a]) * layout.slice_step[a];
    }
    if (!inside) continue;
    const std::int64_t y = a0 == 1 ? 0 : at[1];
    std::uint32_t* const words = data + (slice - layout.slice_begin) * layout.slice_words + y * layout.size[0] + at[0];
    const std::uint32_t* weights = group.weights.data() + row.first + row.lo - at[a0];  // of the tap at coordinate 0
    const auto part = [&](std::int64_t begin, std::int64_t end, std::int64_t shift) {
      for (std::int64_t c = begin; c < end; ++c) {
        if (layout.has_slice(slice + c * slice_step)) visit(words[c * word_step], weights[c + shift]);
      }
    };
    const std::int64_t begin = at[a0] - row.lo;
    const std::int64_t end = at[a0] + row.hi + 1;
    part(std::max<std::int64_t>(begin, 0), std::min(end, n), 0);
    if (!layout.toroidal[a0]) continue;
    if (begin < 0) part(begin + n, n, -n);
    if (end > n) part(0, end - n, n);
  }
}

template <bool On>
void VacField::turn(std::span<const std::uint64_t> positions) {
  for (const std::uint64_t position : positions) {
    if (has(position)) data_[index(position)] ^= vac_flag;
  }
  for (const VacGroupKernel& group : kernel_.groups()) {
    if (contains_x(group)) {
      vac_simd::add_rows(layout_, group, data_.get(), On, positions);
      continue;
    }
    // Pixels of one cache line reach the same lines along the slice axes: take them together.
    by_cell_.assign(positions.begin(), positions.end());
    const auto cells = static_cast<std::uint64_t>(layout_.cells);
    std::stable_sort(by_cell_.begin(), by_cell_.end(),
                     [cells](std::uint64_t a, std::uint64_t b) { return a % cells / 16 < b % cells / 16; });
    for (const std::uint64_t position : by_cell_) {
      visit_points(layout_, group, position, data_.get(),
                   [](std::uint32_t& word, std::uint32_t weight) { word = On ? word + weight : word - weight; });
    }
  }
}

void VacField::turn_on(std::span<const std::uint64_t> positions) { turn<true>(positions); }
void VacField::turn_off(std::span<const std::uint64_t> positions) { turn<false>(positions); }

template <bool On>
static void turn_watching(const VacLayout& layout, const VacKernel& kernel, std::uint32_t* data, std::uint64_t position,
                          std::uint32_t limit, std::vector<std::size_t>& hits) {
  for (const VacGroupKernel& group : kernel.groups()) {
    if (contains_x(group)) {
      vac_simd::add_rows_watching(layout, group, data, On, position, limit, hits);
      continue;
    }
    visit_points(layout, group, position, data, [&](std::uint32_t& word, std::uint32_t weight) {
      word = On ? word + weight : word - weight;
      if (On ? word >= limit : word <= limit) hits.push_back(static_cast<std::size_t>(&word - data));
    });
  }
}

static void append_positions(const VacLayout& layout, std::span<const std::size_t> words,
                             std::vector<std::uint64_t>& positions) {
  const auto slice_words = static_cast<std::size_t>(layout.slice_words);
  for (const std::size_t word : words) {
    const std::size_t slice = word / slice_words + static_cast<std::size_t>(layout.slice_begin);
    positions.push_back(slice * static_cast<std::size_t>(layout.cells) + word % slice_words);
  }
}

void VacField::turn_on_watching(std::uint64_t position, std::uint32_t limit, std::vector<std::uint64_t>& hits) {
  watched_.clear();
  data_[index(position)] ^= vac_flag;
  turn_watching<true>(layout_, kernel_, data_.get(), position, limit, watched_);
  append_positions(layout_, watched_, hits);
}

void VacField::turn_off_watching(std::uint64_t position, std::uint32_t limit, std::vector<std::uint64_t>& hits) {
  watched_.clear();
  data_[index(position)] ^= vac_flag;
  turn_watching<false>(layout_, kernel_, data_.get(), position, limit, watched_);
  append_positions(layout_, watched_, hits);
}

void VacField::refresh_bounds(VacView view) { vac_simd::leaf_minima(layout_, data_.get(), view, bounds_.data()); }

std::span<const std::uint32_t> VacField::bounds() const {
  return std::span(bounds_).first(bounds_.size() - static_cast<std::size_t>(line_words));
}

bool VacField::scan(VacView view, const VacTieHash& hash, std::uint64_t limit, std::size_t max_found,
                    std::vector<VacCandidate>& found) {
  found.clear();
  return vac_simd::scan_leaves(layout_, data_.get(), view, hash, limit, max_found, bounds_.data(), found);
}

void VacField::lower_bound_to(std::uint64_t position, std::uint32_t value) {
  std::uint32_t& bound = bounds_[leaf(position)];
  bound = std::min(bound, value);
}

}  // namespace noiseloom
