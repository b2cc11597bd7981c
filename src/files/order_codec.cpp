#include "noiseloom/files/order_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace noiseloom {
namespace {

std::uint64_t mixed(std::uint64_t place) {  // the finalizer of SplitMix64
  std::uint64_t z = place + 0x9E3779B97F4A7C15U;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31);
}

auto find_order(const RunFileContent& content) {
  return std::ranges::find(content.datasets, order_name, &SliceDataset::name);
}

[[noreturn]] void throw_unfinished(std::int64_t num_placed, std::int64_t num_pixels, const std::string& path) {
  throw UserError(path, fmt::format("not finished: {} of {} pixels have their place in the order; go on with generate "
                                    "--resume",
                                    num_placed, num_pixels));
}

}  // namespace

void OrderCodec::read(std::span<const std::byte> bytes, std::span<std::uint64_t> entries) const {
  NOISELOOM_CHECK_EQ(bytes.size(), entries.size() * bytes_per_pixel());
  for (std::size_t pixel = 0; pixel < entries.size(); ++pixel) entries[pixel] = get(bytes, pixel);
}

void OrderCodec::write(std::span<const std::uint64_t> entries, std::span<std::byte> bytes) const {
  NOISELOOM_CHECK_EQ(bytes.size(), entries.size() * bytes_per_pixel());
  for (std::size_t pixel = 0; pixel < entries.size(); ++pixel) set(bytes, pixel, entries[pixel]);
}

OrderCensus OrderCensus::of_places(std::int64_t num_pixels, std::int64_t begin, std::int64_t end, std::int64_t num_on) {
  OrderCensus census(num_pixels);
  for (std::int64_t place = begin; place < end; ++place) census.add(static_cast<std::uint64_t>(place));
  census.num_on_ = num_on;
  return census;
}

void OrderCensus::add(std::uint64_t entry) {
  num_on_ += entry == on_without_place;
  if (!is_place(entry)) return;
  ++num_placed_;
  num_in_range_ += entry < static_cast<std::uint64_t>(num_pixels_);
  digest_ += mixed(entry);
}

void OrderCensus::add(const OrderCodec& codec, std::span<const std::byte> bytes) {
  const std::size_t count = codec.num_pixels(bytes);
  for (std::size_t pixel = 0; pixel < count; ++pixel) add(codec.get(bytes, pixel));
}

SliceDataset order_dataset(std::int64_t num_pixels) {
  return {order_name, OrderCodec::for_pixels(num_pixels).type(), 1, false};
}

std::optional<OrderCodec> order_codec_of(const SliceDataset& dataset) {
  if (dataset.type == ElementType::float32 || dataset.channels != 1) return std::nullopt;
  return OrderCodec(dataset.type);
}

OrderCensus census_of_order(const RunFileReader& reader) {
  const RunFileContent& content = reader.content();
  const int order = reader.dataset(order_name);
  const SliceDataset& dataset = content.datasets[static_cast<std::size_t>(order)];
  const OrderCodec codec(dataset.type);
  std::vector<std::byte> slice(bytes_per_slice(dataset, content.extents));
  OrderCensus census(content.extents.num_cells());
  for (const SliceIndex s : content.extents.slices()) {
    reader.read_slice(order, s, slice);
    census.add(codec, slice);
  }
  return census;
}

bool is_order_run(const RunFileContent& content) { return find_order(content) != content.datasets.end(); }

std::string why_order_cannot_be_read(const RunFileContent& content) {
  const auto found = find_order(content);
  if (found == content.datasets.end())
    return "holds no /order, the sequence of its pixels: only masks of method \"void-and-cluster\" have one";
  if (!order_codec_of(*found)) return "/order is no list of places (uint32 or uint64, one a pixel)";
  return "";
}

void require_finished_order(const RunFileContent& content, const std::string& path) {
  const auto finished = content.state.find("finished");
  if (!content.state.contains("phase") || finished == content.state.end() || finished->second != Attribute("")) return;
  const auto ranked = content.state.find("ranked");
  const bool counted = ranked != content.state.end() && std::holds_alternative<std::int64_t>(ranked->second);
  throw_unfinished(counted ? std::get<std::int64_t>(ranked->second) : 0, content.extents.num_cells(), path);
}

void require_complete_order(const OrderCensus& census, const std::string& path) {
  if (!census.is_complete()) throw_unfinished(census.num_in_range(), census.num_pixels(), path);
}

}  // namespace noiseloom
