#include "noiseloom/construct/order_samples.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "noiseloom/core/error.h"

namespace noiseloom {

float sample_of_place(std::uint64_t place, std::uint64_t num_places, int bits) {
  if (bits > 0) {
    const std::uint64_t level = (place << bits) / num_places;
    return std::ldexp(static_cast<float>(2 * level + 1), -bits - 1);
  }
  const auto sample = static_cast<float>((static_cast<double>(place) + 0.5) / static_cast<double>(num_places));
  const std::uint64_t exact_level = ((2 * place + 1) << 15) / num_places;
  const bool rounded_past = static_cast<std::uint64_t>(sample * 65536.0F) > exact_level;
  return rounded_past ? std::nextafter(sample, 0.0F) : sample;
}

namespace {

// Calls visit(cell, place): the place of each cell that has one among those of its slice.
template <class Visit>
void for_each_place_in_slice(std::span<const std::byte> order, const OrderCodec& codec, std::int64_t num_pixels,
                             const Visit& visit) {
  const auto entry = [&](std::size_t cell) { return codec.get(order, cell); };
  OrderCensus census(num_pixels);
  census.add(codec, order);
  std::vector<std::uint32_t> cells(codec.num_pixels(order));
  std::iota(cells.begin(), cells.end(), 0U);
  std::erase_if(cells, [&](std::uint32_t cell) { return !is_place(entry(cell)); });
  std::sort(cells.begin(), cells.end(), [&](std::uint32_t a, std::uint32_t b) { return entry(a) < entry(b); });
  // What is still on will have its place before all that has one.
  auto place = static_cast<std::uint64_t>(census.num_on());
  for (const std::uint32_t cell : cells) visit(cell, place++);
}

}  // namespace

std::vector<float> samples_of_order(std::span<const std::byte> order, const OrderCodec& codec, std::int64_t num_pixels,
                                    const OrderSpec& spec) {
  const std::size_t num_cells = codec.num_pixels(order);
  std::vector<float> samples(num_cells, std::numeric_limits<float>::quiet_NaN());
  if (spec.equalize == Equalize::slice) {
    for_each_place_in_slice(order, codec, num_pixels, [&](std::size_t cell, std::uint64_t place) {
      samples[cell] = sample_of_place(place, num_cells, spec.bits);
    });
    return samples;
  }
  for (std::size_t cell = 0; cell < num_cells; ++cell) {
    const auto entry = codec.get(order, cell);
    if (is_place(entry)) samples[cell] = sample_of_place(entry, static_cast<std::uint64_t>(num_pixels), spec.bits);
  }
  return samples;
}

std::vector<float> samples_along_curve(std::span<const std::byte> order, const OrderCodec& codec,
                                       std::int64_t num_pixels, std::span<const float> list) {
  const std::size_t num_cells = codec.num_pixels(order);
  NOISELOOM_CHECK(list.size() % num_cells == 0);
  const std::size_t channels = list.size() / num_cells;
  std::vector<float> samples(list.size(), std::numeric_limits<float>::quiet_NaN());
  for_each_place_in_slice(order, codec, num_pixels, [&](std::size_t cell, std::uint64_t place) {
    std::copy_n(list.begin() + static_cast<std::ptrdiff_t>(place * channels), channels,
                samples.begin() + static_cast<std::ptrdiff_t>(cell * channels));
  });
  return samples;
}

}  // namespace noiseloom
