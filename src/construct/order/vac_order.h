// The places of the pixels of a range of slices.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "noiseloom/core/error.h"
#include "noiseloom/core/extents.h"
#include "noiseloom/files/order_codec.h"

namespace noiseloom {

class VacOrder {
 public:
  // Pixels of slices [begin, end), all off.
  VacOrder(const Extents& extents, std::int32_t begin, std::int32_t end)
      : cells_(static_cast<std::uint64_t>(extents.cells_per_slice())),
        first_(cells_ * static_cast<std::uint64_t>(begin)),
        end_(cells_ * static_cast<std::uint64_t>(end)),
        num_pixels_(extents.num_cells()),
        codec_(OrderCodec::for_pixels(num_pixels_)),
        bytes_(static_cast<std::size_t>(end_ - first_) * codec_.bytes_per_pixel()) {
    for (std::uint64_t p = first_; p < end_; ++p) set_off(p);
  }

  const OrderCodec& codec() const { return codec_; }
  std::uint64_t begin() const { return first_; }
  std::uint64_t end() const { return end_; }
  bool has(std::uint64_t position) const { return position >= begin() && position < end(); }

  // Positions of own pixels from here on.
  bool has_place(std::uint64_t position) const { return is_place(get(position)); }
  bool is_on(std::uint64_t position) const { return get(position) == on_without_place; }
  void set_place(std::uint64_t position, std::uint64_t place) { set(position, place); }
  void set_on(std::uint64_t position) { set(position, on_without_place); }
  void set_off(std::uint64_t position) { set(position, off_without_place); }

  // As in /order.
  std::vector<std::byte> bytes(SliceIndex slice) const {
    const auto from = bytes_.begin() + static_cast<std::ptrdiff_t>(offset(slice));
    return {from, from + static_cast<std::ptrdiff_t>(slice_bytes())};
  }
  void set_bytes(SliceIndex slice, std::span<const std::byte> bytes) {
    NOISELOOM_CHECK_EQ(bytes.size(), slice_bytes());
    std::ranges::copy(bytes, bytes_.begin() + static_cast<std::ptrdiff_t>(offset(slice)));
  }

  // Of own pixels.
  OrderCensus census() const {
    OrderCensus census(num_pixels_);
    census.add(codec_, bytes_);
    return census;
  }

 private:
  std::size_t slice_bytes() const { return static_cast<std::size_t>(cells_) * codec_.bytes_per_pixel(); }
  std::size_t offset(SliceIndex slice) const {
    return static_cast<std::size_t>(cells_ * static_cast<std::uint64_t>(slice) - first_) * codec_.bytes_per_pixel();
  }
  std::uint64_t get(std::uint64_t position) const { return codec_.get(bytes_, position - first_); }
  void set(std::uint64_t position, std::uint64_t entry) { codec_.set(bytes_, position - first_, entry); }

  std::uint64_t cells_;
  std::uint64_t first_;
  std::uint64_t end_;
  std::int64_t num_pixels_;
  OrderCodec codec_;
  std::vector<std::byte> bytes_;
};

}  // namespace noiseloom
