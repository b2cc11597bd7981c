#include "optimize/vac_selector.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace noiseloom {
namespace {

constexpr std::int64_t run_bits = 56;  // what one unaligned load yields whatever the first bit is

std::uint64_t load_run(const std::uint64_t* words, std::int64_t bit, std::int64_t count) {
  std::uint64_t value;
  std::memcpy(&value, reinterpret_cast<const char*>(words) + (bit >> 3), sizeof value);
  return (value >> (bit & 7)) & ((std::uint64_t{1} << count) - 1);
}

void flip_bit(std::vector<std::uint64_t>& words, std::uint64_t bit) {
  words[bit >> 6] ^= std::uint64_t{1} << (bit & 63);
}

}  // namespace

VacSelector::VacSelector(const VacSpec& spec, const VacKernel& kernel)
    : layout_(spec, 0, spec.extents.num_slices()), position_stride_{} {
  static_assert(std::endian::native == std::endian::little, "runs of bits are read across the bytes of words");
  const auto num_words = static_cast<std::size_t>(spec.extents.num_cells() / 64 + 2);
  std::int64_t stride = 1;
  for (std::size_t a = 0; a < static_cast<std::size_t>(layout_.num_axes); ++a) {
    position_stride_[a] = stride;
    stride *= layout_.size[a];
  }
  present_.resize(num_words);
  first_in_word_.resize(num_words);
  for (const VacGroupKernel& group : kernel.groups()) {
    Bitmap bitmap{{}, position_stride_, group.axis0 == 0, &group};
    if (!bitmap.by_position) {
      bitmap.words.resize(num_words);
      std::vector<int> axes{group.axis0};
      axes.insert(axes.end(), group.others.begin(), group.others.end());
      for (int axis = 0; axis < layout_.num_axes; ++axis) {
        if (std::find(axes.begin(), axes.end(), axis) == axes.end()) axes.push_back(axis);
      }
      stride = 1;
      for (const int axis : axes) {
        bitmap.stride[static_cast<std::size_t>(axis)] = stride;
        stride *= layout_.size[static_cast<std::size_t>(axis)];
      }
    }
    bitmaps_.push_back(std::move(bitmap));
  }
}

std::int64_t VacSelector::bit_of(const Bitmap& bitmap, const VacLayout::Coord& at) const {
  std::int64_t bit = 0;
  for (std::size_t a = 0; a < static_cast<std::size_t>(layout_.num_axes); ++a) bit += at[a] * bitmap.stride[a];
  return bit;
}

std::uint32_t VacSelector::slot_of(std::uint64_t position) const {
  const std::uint64_t word = position >> 6;
  const std::uint64_t before = present_[word] & ((std::uint64_t{1} << (position & 63)) - 1);
  return first_in_word_[word] + static_cast<std::uint32_t>(std::popcount(before));
}

void VacSelector::enter(std::span<const VacCandidate> candidates) {
  const std::size_t n = candidates.size();
  energy_.resize(n);
  picked_.assign(n, 0);
  next_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint64_t position = candidates[i].position;
    energy_[i] = candidates[i].energy;
    if (present_[position >> 6] == 0) first_in_word_[position >> 6] = static_cast<std::uint32_t>(i);
    flip_bit(present_, position);
  }
  for (Bitmap& bitmap : bitmaps_) {
    if (bitmap.by_position) continue;
    for (const VacCandidate& c : candidates) {
      flip_bit(bitmap.words, static_cast<std::uint64_t>(bit_of(bitmap, layout_.coord(c.position))));
    }
  }
}

void VacSelector::leave(std::span<const VacCandidate> candidates) {
  for (const VacCandidate& c : candidates) present_[c.position >> 6] = 0;
  for (Bitmap& bitmap : bitmaps_) {
    if (bitmap.by_position) continue;
    for (const VacCandidate& c : candidates) {
      bitmap.words[static_cast<std::size_t>(bit_of(bitmap, layout_.coord(c.position)) >> 6)] = 0;
    }
  }
}

void VacSelector::raise_run(const Bitmap& bitmap, std::int64_t bit, std::int64_t count, std::int64_t position,
                            std::int64_t position_step, const std::uint32_t* weights) {
  const std::uint64_t* words = bitmap.by_position ? present_.data() : bitmap.words.data();
  for (std::int64_t done = 0; done < count; done += run_bits) {
    std::uint64_t bits = load_run(words, bit + done, std::min(run_bits, count - done));
    for (; bits != 0; bits &= bits - 1) {
      const std::int64_t i = done + std::countr_zero(bits);
      energy_[slot_of(static_cast<std::uint64_t>(position + i * position_step))] += weights[i];
    }
  }
}

void VacSelector::raise_group(const Bitmap& bitmap, const VacLayout::Coord& at) {
  const VacGroupKernel& group = *bitmap.group;
  const auto a0 = static_cast<std::size_t>(group.axis0);
  const std::int64_t n = layout_.size[a0];
  const std::int64_t step = position_stride_[a0];
  std::int64_t own_bit = 0;
  std::int64_t own_position = 0;
  for (std::size_t a = 0; a < static_cast<std::size_t>(layout_.num_axes); ++a) {
    if (a == a0) continue;
    own_bit += at[a] * bitmap.stride[a];
    own_position += at[a] * position_stride_[a];
  }
  for (const VacRow& row : group.rows) {
    std::int64_t bit = own_bit;
    std::int64_t position = own_position;
    bool inside = true;
    for (std::size_t i = 0; i < group.others.size() && inside; ++i) {
      const auto a = static_cast<std::size_t>(group.others[i]);
      std::int64_t c = at[a];
      inside = layout_.move(c, group.others[i], row.offset[i]);
      bit += (c - at[a]) * bitmap.stride[a];
      position += (c - at[a]) * position_stride_[a];
    }
    if (!inside) continue;
    const std::uint32_t* weights = group.weights.data() + row.first;
    const std::int64_t begin = at[a0] - row.lo;
    const std::int64_t end = at[a0] + row.hi + 1;
    const std::int64_t from = std::max<std::int64_t>(begin, 0);
    const std::int64_t to = std::min(end, n);
    raise_run(bitmap, bit + from, to - from, position + from * step, step, weights + (from - begin));
    if (!layout_.toroidal[a0]) continue;
    if (begin < 0) raise_run(bitmap, bit + begin + n, -begin, position + (begin + n) * step, step, weights);
    if (end > n) raise_run(bitmap, bit, end - n, position, step, weights + (n - begin));
  }
}

void VacSelector::raise_around(std::uint64_t position) {
  const VacLayout::Coord at = layout_.coord(position);
  for (const Bitmap& bitmap : bitmaps_) raise_group(bitmap, at);
}

// Files a candidate that is not picked under its present key, or forgets it where that is past the limit.
void VacSelector::put(std::uint32_t i) {
  const VacCandidate now{0, energy_[i], candidates_[i].hash};
  if (now.key() > limit_) return;
  const std::uint32_t bucket = (energy_[i] - least_) >> shift_;
  if (bucket <= current_) {
    heap_.push_back({now.key(), i ^ mirror_});
    std::push_heap(heap_.begin(), heap_.end());
  } else {
    next_[i] = head_[bucket];
    head_[bucket] = i;
  }
}

void VacSelector::select(VacView view, std::span<const VacCandidate> candidates, std::uint64_t limit,
                         std::size_t max_picks, std::vector<std::uint32_t>& picks) {
  picks.clear();
  if (candidates.empty()) return;
  enter(candidates);
  candidates_ = candidates;
  limit_ = limit;
  mirror_ = static_cast<std::uint32_t>(view);
  least_ = *std::min_element(energy_.begin(), energy_.end());
  const std::uint32_t range = static_cast<std::uint32_t>(limit >> 32) - least_;
  shift_ = std::max(0, static_cast<int>(std::bit_width(range)) - static_cast<int>(std::bit_width(candidates.size())));
  const std::uint32_t last = range >> shift_;
  head_.assign(std::size_t{last} + 1, none);
  heap_.clear();
  current_ = 0;
  for (std::uint32_t i = 0; i < candidates.size(); ++i) put(i);
  while (picks.size() < max_picks) {
    if (heap_.empty()) {
      do {
        if (current_ == last) break;
        ++current_;
      } while (head_[current_] == none);
      for (std::uint32_t i = head_[current_]; i != none;) {
        const std::uint32_t after = next_[i];
        put(i);
        i = after;
      }
      head_[current_] = none;
      if (heap_.empty() && current_ == last) break;
      continue;
    }
    std::pop_heap(heap_.begin(), heap_.end());
    const Entry entry = heap_.back();
    heap_.pop_back();
    const std::uint32_t i = entry.order ^ mirror_;
    if (static_cast<std::uint32_t>(entry.key >> 32) != energy_[i]) {
      put(i);
      continue;
    }
    picked_[i] = 1;
    picks.push_back(i);
    raise_around(candidates[i].position);
  }
  leave(candidates);
}

}  // namespace noiseloom
