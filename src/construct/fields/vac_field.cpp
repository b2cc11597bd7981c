#include "construct/fields/vac_field.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstdlib>
#include <new>
#include <utility>

#include "construct/fields/vac_field_simd.h"
#include "construct/fields/vac_sources.h"

namespace noiseloom {
namespace {

constexpr std::int64_t line_words = VacLayout::line_words;
constexpr std::int64_t leaf_cells = VacLayout::leaf_cells;

}  // namespace

VacWords allocate_words(std::size_t count) {
  // Rows of a footprint, and slices, are pages apart: huge pages keep them within reach of the TLB. The rest of the
  // words takes usual ones, as threads have many fields and each would take up to a huge page more than it needs.
  constexpr std::size_t huge_page = std::size_t{1} << 21;
  const std::size_t bytes = std::max<std::size_t>(count, 1) * sizeof(std::uint32_t);
  void* memory = nullptr;
  if (posix_memalign(&memory, bytes >= huge_page ? huge_page : 64, bytes) != 0) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
  // Only advice: failure costs speed alone.
  if (bytes >= huge_page) madvise(memory, bytes / huge_page * huge_page, MADV_HUGEPAGE);
#endif
  return VacWords(static_cast<std::uint32_t*>(memory));
}

void VacFree::operator()(void* memory) const { std::free(memory); }

VacField::VacField(const VacSpec& spec, const VacKernel& kernel, std::int32_t slice_begin, std::int32_t slice_end,
                   std::int64_t cells_to_wait)
    : layout_(spec, slice_begin, slice_end),
      kernel_(kernel),
      num_words_(
          static_cast<std::size_t>((layout_.slice_end - layout_.slice_begin) * layout_.slice_words + line_words)),
      data_(allocate_words(num_words_)),
      bounds_(static_cast<std::size_t>((layout_.slice_end - layout_.slice_begin) * layout_.leaves + line_words)) {
  if (layout_.cells >= cells_to_wait && layout_.slice_end > layout_.slice_begin)
    pending_ = VacPending::make(layout_, kernel_);
  clear();
}

bool VacField::has(std::uint64_t position) const {
  return position >= layout_.first_position() && position < layout_.end_position();
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

// Adds the taps of a group without x around all pixels.
template <bool On>
void add_points(const VacLayout& layout, const VacGroupKernel& group, std::uint32_t* data,
                std::span<const std::uint64_t> positions) {
  for (const std::uint64_t position : positions) {
    const Points points(layout, group, data, layout.place(position));
    for (const VacRow& row : group.rows) {
      points.row(row, [](std::uint32_t& word, std::uint32_t weight) { word = On ? word + weight : word - weight; });
    }
  }
}

// Adds to the words of slice `to` what the pixels of all slices do to it through a group over slice axes.
template <bool On>
void add_sources(const VacLayout& layout, const VacGroupKernel& group, const VacPortion& portion, std::int64_t to,
                 std::uint32_t* words) {
  each_run_of_sources(layout, group, to,
                      [&](std::int64_t first, std::int64_t last, const std::uint32_t* weights, std::int64_t middle) {
                        const std::size_t end = portion.begin_of(last + 1);
                        for (std::size_t i = portion.begin_of(first); i < end; ++i) {
                          std::uint32_t& word = words[portion.cells[i]];
                          const std::uint32_t weight = weights[middle - portion.slices[i]];
                          word = On ? word + weight : word - weight;
                        }
                      });
}

}  // namespace

std::pair<std::size_t, std::size_t> VacField::own(std::span<const std::uint64_t> positions) const {
  const auto first = std::lower_bound(positions.begin(), positions.end(), layout_.first_position());
  const auto last = std::lower_bound(first, positions.end(), layout_.end_position());
  return {static_cast<std::size_t>(first - positions.begin()), static_cast<std::size_t>(last - positions.begin())};
}

// Turns those pixels of one slice that are present, and adds the weights of the groups that stay in their slices.
template <bool On>
void VacField::turn_in_slice(std::span<const std::uint64_t> positions) {
  const auto [first, last] = own(positions);
  for (const std::uint64_t position : positions.subspan(first, last - first)) data_[index(position)] ^= vac_flag;
  const bool wait = On && pending_.has_value();
  at_once_.clear();
  for (const std::uint64_t position : positions) {
    if (wait && !pending_->add(layout_, layout_.place(position))) at_once_.push_back(position);
  }
  for (const VacGroupKernel& group : kernel_.groups()) {
    if (!group.contains_x() || !group.stays_in_slice()) continue;
    vac_simd::add_rows(layout_, group, data_.get(), On,
                       wait && VacPending::waits(group) ? std::span<const std::uint64_t>(at_once_) : positions);
  }
}

template <bool On>
void VacField::turn_all(const VacPortion& portion, const VacScan* then) {
  if (!On) settle();
  const std::span<const std::uint64_t> positions = portion.positions;
  const auto by_slices = [&](const VacGroupKernel& group) { return is_of_slices(group) && portion.is_divided(); };
  for (const VacGroupKernel& group : kernel_.groups()) {
    if (!group.contains_x()) {
      if (!by_slices(group)) add_points<On>(layout_, group, data_.get(), positions);
    } else if (!group.stays_in_slice()) {
      vac_simd::add_rows(layout_, group, data_.get(), On, positions);
    }
  }
  const bool scans_slices = then != nullptr && portion.is_divided() && !pending_;
  std::size_t num_back = 0;
  if (scans_slices) begin_scan(*then);
  if (portion.is_divided()) {
    // A slice stays in the second cache for all that is done to it.
    for (std::int64_t slice = layout_.slice_begin; slice < layout_.slice_end; ++slice) {
      const std::size_t first = portion.begin_of(slice);
      turn_in_slice<On>(positions.subspan(first, portion.begin_of(slice + 1) - first));
      std::uint32_t* const words = data_.get() + (slice - layout_.slice_begin) * layout_.slice_words;
      for (const VacGroupKernel& group : kernel_.groups()) {
        if (by_slices(group)) add_sources<On>(layout_, group, portion, slice, words);
      }
      if (!scans_slices) continue;
      const auto behind = static_cast<std::uint64_t>(layout_.cells * (slice + 1));
      for (; num_back < found_before_.size() && found_before_[num_back].position < behind; ++num_back) {
        take_back(found_before_[num_back]);
      }
      scan_slices(*then, slice, slice + 1);
    }
  } else {
    const auto [first, last] = own(positions);
    turn_in_slice<On>(positions.subspan(first, last - first));
  }
  if (On && pending_) {
    pending_->end_batch();
    if (pending_->is_full()) settle();
  }
  if (then != nullptr && !scans_slices) scan(*then);
}

void VacField::turn(bool on, const VacPortion& portion, const VacScan* then) {
  if (on) {
    turn_all<true>(portion, then);
  } else {
    turn_all<false>(portion, then);
  }
}

void VacField::turn(bool on, std::vector<std::uint64_t> positions) {
  VacPortion portion;
  portion.positions = std::move(positions);
  portion.divide(layout_);
  turn(on, portion);
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
std::span<std::uint32_t> VacField::bounds() {
  return std::span(bounds_).first(bounds_.size() - static_cast<std::size_t>(line_words));
}

void VacField::scan(const VacScan& asked) {
  begin_scan(asked);
  for (const VacCandidate& candidate : found_before_) take_back(candidate);
  scan_slices(asked, layout_.slice_begin, layout_.slice_end);
}

void VacField::begin_scan(const VacScan& asked) {
  found_before_.swap(found_);
  found_.clear();
  found_all_ = true;
  view_ = asked.view;
}

void VacField::scan_slices(const VacScan& asked, std::int64_t begin, std::int64_t end) {
  for (std::int64_t slice = begin; slice < end && found_all_; ++slice) {
    found_all_ = vac_simd::scan_leaves(layout_, slice, 0, layout_.leaves, data_.get(), pending_ ? &*pending_ : nullptr,
                                       asked, bounds_.data(), found_);
  }
}

void VacField::take_back(const VacCandidate& candidate) {
  // At least: it is higher where picks wait.
  const std::uint32_t value = data_[index(candidate.position)] ^ static_cast<std::uint32_t>(view_);
  std::uint32_t& bound = bounds_[leaf(candidate.position)];
  if (value < vac_flag) bound = std::min(bound, value);
}

void VacField::end_of_batch() {
  for (const VacCandidate& candidate : found_) take_back(candidate);
  found_.clear();
}

}  // namespace noiseloom
