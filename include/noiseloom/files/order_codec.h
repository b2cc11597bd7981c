// /order of a run file: the place of every pixel of a mask in the sequence in which pixels are turned on.
//
// Each pixel has one little-endian entry, which is its place or, while it has none, one of two marks: that it is on, or
// that it is off. The marks are the two largest numbers of the type, uint32, or uint64 where uint32 does not have room
// for all places and the marks. In memory an entry is uint64 with the marks below, whatever the type in the file.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>

#include "noiseloom/core/error.h"
#include "noiseloom/files/run_file.h"

namespace noiseloom {

inline constexpr const char* order_name = "/order";

inline constexpr std::uint64_t on_without_place = ~std::uint64_t{1};
inline constexpr std::uint64_t off_without_place = ~std::uint64_t{0};
constexpr bool is_place(std::uint64_t entry) { return entry < on_without_place; }

// Entries as the bytes of a file, of either type.
class OrderCodec {
 public:
  // Requires uint32 or uint64.
  explicit OrderCodec(ElementType type) : wide_(type == ElementType::uint64) {
    NOISELOOM_CHECK(type != ElementType::float32);
  }
  // What /order of so many pixels is written with.
  static OrderCodec for_pixels(std::int64_t num_pixels) {
    return OrderCodec(num_pixels > std::int64_t{narrow_mark} ? ElementType::uint64 : ElementType::uint32);
  }

  ElementType type() const { return wide_ ? ElementType::uint64 : ElementType::uint32; }
  std::size_t bytes_per_pixel() const { return wide_ ? sizeof(std::uint64_t) : sizeof(std::uint32_t); }
  std::size_t num_pixels(std::span<const std::byte> bytes) const { return bytes.size() / bytes_per_pixel(); }

  // One entry; `pixel` counts from the first of `bytes`.
  std::uint64_t get(std::span<const std::byte> bytes, std::size_t pixel) const {
    if (wide_) return load<std::uint64_t>(bytes, pixel);
    const std::uint64_t entry = load<std::uint32_t>(bytes, pixel);
    return entry < narrow_mark ? entry : on_without_place + (entry - narrow_mark);
  }
  void set(std::span<std::byte> bytes, std::size_t pixel, std::uint64_t entry) const {
    if (wide_) {
      store(bytes, pixel, entry);
    } else {
      store(bytes, pixel, static_cast<std::uint32_t>(entry));  // makes a mark that of 32 bits
    }
  }

  // As many entries as there is room for. Requires as many bytes.
  void read(std::span<const std::byte> bytes, std::span<std::uint64_t> entries) const;
  void write(std::span<const std::uint64_t> entries, std::span<std::byte> bytes) const;

  friend bool operator==(const OrderCodec&, const OrderCodec&) = default;

 private:
  static_assert(std::endian::native == std::endian::little, "entries are stored as they are in memory");
  static constexpr auto narrow_mark = static_cast<std::uint32_t>(on_without_place);  // the lower one

  template <class Entry>
  static Entry load(std::span<const std::byte> bytes, std::size_t pixel) {
    Entry entry;
    std::memcpy(&entry, bytes.data() + pixel * sizeof entry, sizeof entry);
    return entry;
  }
  template <class Entry>
  static void store(std::span<std::byte> bytes, std::size_t pixel, Entry entry) {
    std::memcpy(bytes.data() + pixel * sizeof entry, &entry, sizeof entry);
  }

  bool wide_;
};

// What the entries of an order come to, whatever their sequence. Places are compared as sets by the sum of a mixture of
// each, so that billions need no memory.
class OrderCensus {
 public:
  // Of no entry yet, of an order of so many pixels.
  explicit OrderCensus(std::int64_t num_pixels) : num_pixels_(num_pixels) {}
  // Of places begin, ..., end - 1, each once, and so many pixels that are on without a place.
  static OrderCensus of_places(std::int64_t num_pixels, std::int64_t begin, std::int64_t end, std::int64_t num_on);

  void add(std::uint64_t entry);
  void add(const OrderCodec& codec, std::span<const std::byte> bytes);

  std::int64_t num_pixels() const { return num_pixels_; }      // that the whole order has
  std::int64_t num_on() const { return num_on_; }              // without a place
  std::int64_t num_placed() const { return num_placed_; }      // with a place, even one past the last
  std::int64_t num_in_range() const { return num_in_range_; }  // with a place below num_pixels()
  std::uint64_t digest() const { return digest_; }             // of the places

  // True where every pixel has a place below num_pixels(). Whether each has its own only the digest tells.
  bool is_complete() const { return num_in_range_ == num_pixels_; }

  friend bool operator==(const OrderCensus&, const OrderCensus&) = default;

 private:
  std::int64_t num_pixels_;
  std::int64_t num_on_ = 0;
  std::int64_t num_placed_ = 0;
  std::int64_t num_in_range_ = 0;
  std::uint64_t digest_ = 0;
};

// How /order of so many pixels stands in a run file.
SliceDataset order_dataset(std::int64_t num_pixels);
// The codec of a dataset; none where it is no list of entries, one a pixel.
std::optional<OrderCodec> order_codec_of(const SliceDataset& dataset);
// The census of all slices, read one after the other. Requires a file with an /order that has a codec.
OrderCensus census_of_order(const RunFileReader& reader);

// True for a run file of a method that orders pixels (void and cluster).
bool is_order_run(const RunFileContent& content);

// Why /order of a run file with that content cannot be read: it holds none, or one of another kind. "" where it can.
std::string why_order_cannot_be_read(const RunFileContent& content);

// Throw UserError for an order that is not complete, which is no texture and no sequence yet: by what /state says, and
// by a census of the entries.
void require_finished_order(const RunFileContent& content, const std::string& path);
void require_complete_order(const OrderCensus& census, const std::string& path);

}  // namespace noiseloom
