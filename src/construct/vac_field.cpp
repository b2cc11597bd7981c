#include "construct/vac_field.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstdlib>
#include <new>
#include <utility>

#include "construct/vac_field_simd.h"

namespace noiseloom {
namespace {

constexpr std::int64_t line_words = VacLayout::line_words;
constexpr std::int64_t leaf_cells = VacLayout::leaf_cells;

}  // namespace

VacWords allocate_words(std::size_t count) {
  // Footprints over slice axes touch a page for every slice: huge pages keep them within reach of the TLB.
  constexpr std::size_t huge_page = std::size_t{1} << 21;
  const std::size_t alignment = count * sizeof(std::uint32_t) >= huge_page ? huge_page : 64;
  const std::size_t bytes = (count * sizeof(std::uint32_t) + alignment - 1) / alignment * alignment;
  void* memory = std::aligned_alloc(alignment, bytes);
  if (memory == nullptr) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
  if (alignment == huge_page) madvise(memory, bytes, MADV_HUGEPAGE);  // only advice: failure costs speed alone
#endif
  return VacWords(static_cast<std::uint32_t*>(memory));
}

void VacFree::operator()(void* memory) const { std::free(memory); }

VacField::VacField(const VacSpec& spec, const VacKernel& kernel, std::int32_t slice_begin, std::int32_t slice_end,
                   std::int64_t cells_to_wait)
    : layout_(spec, slice_begin, slice_end),
      kernel_(kernel),
      num_words_(static_cast<std::size_t>((slice_end - slice_begin) * layout_.slice_words + line_words)),
      data_(allocate_words(num_words_)),
      bounds_(static_cast<std::size_t>((slice_end - slice_begin) * layout_.leaves + line_words)),
      sorter_(layout_, kernel) {
  for (const VacGroupKernel& group : kernel.groups()) columns_.push_back(VacColumns::make(layout_, group));
  if (layout_.cells >= cells_to_wait && slice_end > slice_begin) pending_ = VacPending::make(layout_, kernel_);
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
  return static_cast<std::size_t>(slice * layout_.leaves + p % layout_.cells / leaf_cells);
}

void VacField::clear() {
  std::fill_n(data_.get(), num_words_, 0U);
  if (pending_) pending_->clear();
}

// Nothing waits after this.
void VacField::settle() {
  if (!pending_ || pending_->empty()) return;
  vac_simd::bring_up_all(layout_, data_.get(), *pending_);
  pending_->clear();
}

namespace {

// The taps of a group without x, seen from one pixel.
class Points {
 public:
  Points(const VacLayout& layout, const VacGroupKernel& group, std::uint32_t* data, const VacPlace& place)
      : layout_(layout), group_(group), own_slice_(place.slice) {
    for (const int axis : group.others) at_[static_cast<std::size_t>(axis)] = coordinate(place, axis);
    const auto a0 = static_cast<std::size_t>(group.axis0);
    at0_ = coordinate(place, group.axis0);
    size0_ = layout.size[a0];
    toroidal0_ = layout.toroidal[a0];
    slice_step_ = layout.slice_step[a0];  // of a step along axis0; along y it stays in its slice
    word_step_ = a0 == 1 ? layout.size[0] : slice_step_ * layout.slice_words;
    cell_ = data + (a0 == 1 ? place.cell % layout.size[0] : place.cell);
    whole_ = layout.slice_begin == 0 && layout.slice_end == layout.num_slices;
  }

  std::int64_t at(std::size_t axis) const { return at_[axis]; }

  // The coordinates [begin, end) of the group's second axis whose rows can meet slices that are present.
  std::pair<std::int64_t, std::int64_t> rows_present() const {
    const auto a = static_cast<std::size_t>(group_.others[0]);
    if (whole_) return {0, layout_.size[a]};
    const std::int64_t step = layout_.slice_step[a];
    const std::int64_t first = own_slice_ - at0_ * slice_step_ - at_[a] * step;  // slice at the origin of both axes
    const std::int64_t before = layout_.slice_begin - first - (size0_ - 1) * slice_step_;
    const std::int64_t behind = layout_.slice_end - first;
    return {before > 0 ? (before - 1) / step + 1 : 0,
            behind > 0 ? std::min(layout_.size[a], (behind - 1) / step + 1) : 0};
  }

  // Fetches the lines that rows at coordinate `c` of the group's second axis write to.
  void prefetch_row(std::int64_t c) const {
    const auto a = static_cast<std::size_t>(group_.others[0]);
    const std::int64_t slice = own_slice_ - at0_ * slice_step_ + (c - at_[a]) * layout_.slice_step[a];
    std::int64_t begin = 0;
    std::int64_t end = size0_;
    if (!whole_ && !clip(slice, begin, end)) return;
    const std::uint32_t* words = cell_ + (slice - layout_.slice_begin) * layout_.slice_words + begin * word_step_;
    for (std::int64_t left = end - begin; left > 0; --left, words += word_step_) __builtin_prefetch(words, 1);
  }

  // Calls visit(word, weight) for the taps of one row.
  template <class Visit>
  void row(const VacRow& row, const Visit& visit) const {
    std::int64_t slice = own_slice_ - at0_ * slice_step_;
    for (std::size_t i = 0; i < group_.others.size(); ++i) {
      const auto a = static_cast<std::size_t>(group_.others[i]);
      std::int64_t c = at_[a];
      if (!layout_.move(c, group_.others[i], row.offset[i])) return;
      slice += (c - at_[a]) * layout_.slice_step[a];
    }
    std::uint32_t* const words = cell_ + (slice - layout_.slice_begin) * layout_.slice_words;
    const std::uint32_t* const weights = group_.weights.data() + row.first;
    const std::int64_t begin = at0_ - row.lo;
    const std::int64_t end = at0_ + row.hi + 1;
    const std::int64_t from = std::max<std::int64_t>(begin, 0);
    const std::int64_t to = std::min(end, size0_);
    part(words, slice, from, to, weights + (from - begin), visit);
    if (!toroidal0_) return;
    if (begin < 0) part(words, slice, begin + size0_, size0_, weights, visit);
    if (end > size0_) part(words, slice, 0, end - size0_, weights + (size0_ - begin), visit);
  }

 private:
  template <class Visit>
  void part(std::uint32_t* words, std::int64_t slice, std::int64_t begin, std::int64_t end,
            const std::uint32_t* weights, const Visit& visit) const {
    const std::int64_t first = begin;
    if (!whole_ && !clip(slice, begin, end)) return;
    weights += begin - first;
    words += begin * word_step_;
    for (std::int64_t left = end - begin; left > 0; --left, words += word_step_) visit(*words, *weights++);
  }

  // Cuts coordinates [begin, end) of axis0 down to those whose slices are present; false when none are. `slice`: that
  // of coordinate 0.
  bool clip(std::int64_t slice, std::int64_t& begin, std::int64_t& end) const {
    const std::int64_t before = layout_.slice_begin - slice;  // present: before <= c * slice_step < behind
    const std::int64_t behind = layout_.slice_end - slice;
    if (begin * slice_step_ >= before && (end - 1) * slice_step_ < behind) return begin < end;
    if (slice_step_ == 0) return false;
    if (before > 0) begin = std::max(begin, (before - 1) / slice_step_ + 1);
    if (behind <= 0) return false;
    end = std::min(end, (behind - 1) / slice_step_ + 1);
    return begin < end;
  }

  std::int64_t coordinate(const VacPlace& place, int axis) const {
    const auto a = static_cast<std::size_t>(axis);
    if (axis == 1) return place.cell / layout_.size[0];
    const auto slice = static_cast<std::uint32_t>(place.slice);  // below 2^31; 32 bits divide faster
    return slice / static_cast<std::uint32_t>(layout_.slice_step[a]) % static_cast<std::uint32_t>(layout_.size[a]);
  }

  const VacLayout& layout_;
  const VacGroupKernel& group_;
  VacLayout::Coord at_{};
  std::int64_t own_slice_;
  std::int64_t at0_;
  std::int64_t size0_;
  bool toroidal0_;
  std::int64_t slice_step_;
  std::int64_t word_step_;
  std::uint32_t* cell_;
  bool whole_;
};

// Kernel rows of a group of two axes by the coordinate where they end up: row_to(to - from). Null where there is none.
class RowsByDifference {
 public:
  RowsByDifference(const VacLayout& layout, const VacGroupKernel& group)
      : size_(layout.size[static_cast<std::size_t>(group.others[0])]),
        rows_(static_cast<std::size_t>(2 * size_ - 1), nullptr) {
    const bool toroidal = layout.toroidal[static_cast<std::size_t>(group.others[0])];
    for (const VacRow& row : group.rows) {
      for (const std::int64_t d : {row.offset[0] - size_, std::int64_t{row.offset[0]}, row.offset[0] + size_}) {
        const bool image = d != row.offset[0];
        if (std::abs(d) < size_ && (toroidal || !image)) rows_[static_cast<std::size_t>(d + size_ - 1)] = &row;
      }
    }
  }
  std::int64_t size() const { return size_; }
  const VacRow* row_to(std::int64_t difference) const {
    return rows_[static_cast<std::size_t>(difference + size_ - 1)];
  }

 private:
  std::int64_t size_;
  std::vector<const VacRow*> rows_;
};

// Adds the taps of a group without x around all pixels, which are ordered by line: those of one line reach the same
// lines along the slice axes, so they are taken together; in a plane of two axes row after row, so that the lines of a
// row are read once.
template <bool On>
void add_points(const VacLayout& layout, const VacGroupKernel& group, const VacColumns* columns, std::uint32_t* data,
                std::span<const VacPlace> places) {
  const auto add = [](std::uint32_t& word, std::uint32_t weight) { word = On ? word + weight : word - weight; };
  if (columns != nullptr) {
    for (const VacPlace& place : places) columns->visit(place, data, add);
    return;
  }
  if (group.others.size() != 1) {
    for (const VacPlace& place : places) {
      const Points points(layout, group, data, place);
      for (const VacRow& row : group.rows) points.row(row, add);
    }
    return;
  }
  const RowsByDifference rows(layout, group);
  const auto axis = static_cast<std::size_t>(group.others[0]);
  std::vector<Points> together;
  for (std::size_t i = 0; i < places.size();) {
    together.clear();
    const std::int64_t line = VacLineSorter::line_of(places[i]);
    std::int64_t begin = rows.size();
    std::int64_t end = 0;
    for (; i < places.size() && VacLineSorter::line_of(places[i]) == line; ++i) {
      const auto present = together.emplace_back(layout, group, data, places[i]).rows_present();
      begin = std::min(begin, present.first);
      end = std::max(end, present.second);
    }
    const bool fetch = together.size() >= 4;  // then nearly every line of a row will be met
    for (std::int64_t to = begin; to < end; ++to) {
      if (fetch && to + 1 < end) together[0].prefetch_row(to + 1);
      for (const Points& points : together) {
        if (const VacRow* row = rows.row_to(to - points.at(axis))) points.row(*row, add);
      }
    }
  }
}

}  // namespace

std::pair<std::size_t, std::size_t> VacField::own(std::span<const std::uint64_t> positions) const {
  const auto cells = static_cast<std::uint64_t>(layout_.cells);
  const auto first =
      std::lower_bound(positions.begin(), positions.end(), cells * static_cast<std::uint64_t>(layout_.slice_begin));
  const auto last = std::lower_bound(first, positions.end(), cells * static_cast<std::uint64_t>(layout_.slice_end));
  return {static_cast<std::size_t>(first - positions.begin()), static_cast<std::size_t>(last - positions.begin())};
}

template <bool On>
void VacField::turn_all(std::span<const std::uint64_t> positions, std::span<const VacPlace> by_line) {
  const auto [first, last] = this->own(positions);
  const std::span<const std::uint64_t> own = positions.subspan(first, last - first);
  for (const std::uint64_t position : own) data_[index(position)] ^= vac_flag;
  std::span<const std::uint64_t> in_own_slice = own;
  if (!On) settle();
  if (On && pending_) {
    at_once_.clear();
    for (const std::uint64_t position : own) {
      if (!pending_->add(layout_, layout_.place(position))) at_once_.push_back(position);
    }
    in_own_slice = at_once_;
  }
  for (std::size_t g = 0; g < kernel_.groups().size(); ++g) {
    const VacGroupKernel& group = kernel_.groups()[g];
    if (group.contains_x()) {
      const bool in_slice = group.others.empty() || group.others.back() == 1;
      vac_simd::add_rows(layout_, group, data_.get(), On,
                         VacPending::waits(group) ? in_own_slice
                         : in_slice               ? own
                                                  : positions);
      continue;
    }
    add_points<On>(layout_, group, columns_[g] ? &*columns_[g] : nullptr, data_.get(), by_line);
  }
  if (!On || !pending_) return;
  pending_->end_batch();
  if (pending_->is_full()) settle();
}

void VacField::turn(bool on, std::span<const std::uint64_t> positions, std::span<const VacPlace> by_line) {
  if (on) {
    turn_all<true>(positions, by_line);
  } else {
    turn_all<false>(positions, by_line);
  }
}

void VacField::turn_on(std::span<const std::uint64_t> positions) {
  sorter_.sort(positions, by_line_);
  turn(true, positions, by_line_);
}
void VacField::turn_off(std::span<const std::uint64_t> positions) {
  sorter_.sort(positions, by_line_);
  turn(false, positions, by_line_);
}

template <bool On>
static void turn_watching(const VacLayout& layout, const VacKernel& kernel, std::uint32_t* data, std::uint64_t position,
                          std::uint32_t limit, std::vector<std::size_t>& hits) {
  for (const VacGroupKernel& group : kernel.groups()) {
    if (group.contains_x()) {
      vac_simd::add_rows_watching(layout, group, data, On, position, limit, hits);
      continue;
    }
    const Points points(layout, group, data, layout.place(position));
    for (const VacRow& row : group.rows) {
      points.row(row, [&](std::uint32_t& word, std::uint32_t weight) {
        word = On ? word + weight : word - weight;
        if (On ? word >= limit : word <= limit) hits.push_back(static_cast<std::size_t>(&word - data));
      });
    }
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

template <bool On>
void VacField::turn_one(std::uint64_t position, std::uint32_t limit, std::vector<std::uint64_t>& hits) {
  settle();
  watched_.clear();
  if (has(position)) data_[index(position)] ^= vac_flag;
  turn_watching<On>(layout_, kernel_, data_.get(), position, limit, watched_);
  append_positions(layout_, watched_, hits);
}

void VacField::turn_on_watching(std::uint64_t position, std::uint32_t limit, std::vector<std::uint64_t>& hits) {
  turn_one<true>(position, limit, hits);
}

void VacField::turn_off_watching(std::uint64_t position, std::uint32_t limit, std::vector<std::uint64_t>& hits) {
  turn_one<false>(position, limit, hits);
}

void VacField::refresh_bounds(VacView view) {
  settle();
  found_.clear();
  vac_simd::leaf_minima(layout_, data_.get(), view, bounds_.data());
}

std::span<const std::uint32_t> VacField::bounds() const {
  return std::span(bounds_).first(bounds_.size() - static_cast<std::size_t>(line_words));
}

bool VacField::scan(VacView view, const VacTieHash& hash, std::uint64_t limit, std::size_t max_found) {
  end_of_batch();
  view_ = view;
  return vac_simd::scan_leaves(layout_, data_.get(), pending_ ? &*pending_ : nullptr, view, hash, limit, max_found,
                               bounds_.data(), found_);
}

void VacField::end_of_batch() {
  const auto flip = static_cast<std::uint32_t>(view_);
  for (const VacCandidate& c : found_) {
    const std::uint32_t value = data_[index(c.position)] ^ flip;  // at least: it is higher where picks wait
    std::uint32_t& bound = bounds_[leaf(c.position)];
    if (value < vac_flag) bound = std::min(bound, value);
  }
  found_.clear();
}

}  // namespace noiseloom
