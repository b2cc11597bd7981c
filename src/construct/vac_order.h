// The ranks of the pixels of a range of slices.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "noiseloom/core/error.h"
#include "noiseloom/core/extents.h"

namespace noiseloom {

// True where ranks need 64 bits: the two largest values of 32 bits mark pixels without a rank.
constexpr bool vac_wide(std::int64_t num_cells) { return num_cells > 0xFFFFFFFE; }

class VacOrder {
 public:
  // Pixels of slices [begin, end), all off.
  VacOrder(const Extents& extents, SliceIndex begin, SliceIndex end)
      : cells_(static_cast<std::uint64_t>(extents.cells_per_slice())),
        first_(cells_ * static_cast<std::uint64_t>(begin)),
        wide_(vac_wide(extents.num_cells())) {
    const auto n = static_cast<std::size_t>(cells_) * static_cast<std::size_t>(end - begin);
    if (wide_) {
      ranks64_.assign(n, ~std::uint64_t{0});
    } else {
      ranks32_.assign(n, ~std::uint32_t{0});
    }
  }

  bool wide() const { return wide_; }
  std::uint64_t begin() const { return first_; }
  std::uint64_t end() const { return first_ + (wide_ ? ranks64_.size() : ranks32_.size()); }
  bool has(std::uint64_t position) const { return position >= begin() && position < end(); }

  // Positions of own pixels from here on.
  bool has_rank(std::uint64_t position) const { return get(position) < on(); }
  bool is_on(std::uint64_t position) const { return get(position) == on(); }
  void set_rank(std::uint64_t position, std::uint64_t rank) { set(position, rank); }
  void set_on(std::uint64_t position) { set(position, on()); }
  void set_off(std::uint64_t position) { set(position, on() + 1); }

  static_assert(std::endian::native == std::endian::little, "files hold little-endian ranks");
  std::vector<std::byte> bytes(SliceIndex slice) const {
    const auto part = std::as_bytes(wide_ ? std::as_bytes(std::span(ranks64_)) : std::as_bytes(std::span(ranks32_)));
    const auto from = part.begin() + static_cast<std::ptrdiff_t>(offset(slice));
    return {from, from + static_cast<std::ptrdiff_t>(slice_bytes())};
  }
  void set_bytes(SliceIndex slice, std::span<const std::byte> bytes) {
    NOISELOOM_CHECK_EQ(bytes.size(), slice_bytes());
    const auto part = wide_ ? std::as_writable_bytes(std::span(ranks64_)) : std::as_writable_bytes(std::span(ranks32_));
    std::memcpy(part.data() + offset(slice), bytes.data(), bytes.size());
  }

 private:
  std::size_t element() const { return wide_ ? sizeof(std::uint64_t) : sizeof(std::uint32_t); }
  std::size_t slice_bytes() const { return static_cast<std::size_t>(cells_) * element(); }
  std::size_t offset(SliceIndex slice) const {
    return static_cast<std::size_t>(cells_ * static_cast<std::uint64_t>(slice) - first_) * element();
  }
  std::uint64_t on() const { return wide_ ? ~std::uint64_t{1} : std::uint64_t{~std::uint32_t{1}}; }
  std::uint64_t get(std::uint64_t p) const { return wide_ ? ranks64_[p - first_] : ranks32_[p - first_]; }
  void set(std::uint64_t p, std::uint64_t value) {
    if (wide_) {
      ranks64_[p - first_] = value;
    } else {
      ranks32_[p - first_] = static_cast<std::uint32_t>(value);
    }
  }

  std::uint64_t cells_;
  std::uint64_t first_;
  bool wide_;
  std::vector<std::uint32_t> ranks32_;  // the one that is not in use is empty
  std::vector<std::uint64_t> ranks64_;
};

}  // namespace noiseloom
