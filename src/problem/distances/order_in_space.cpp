#include "problem/distances/order_in_space.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>

namespace noiseloom {
namespace {

// Ascending by the upper half; equals stay in the order that they had. Digits of 11 bits, the last first.
void sort_by_upper_half(std::vector<std::uint64_t>& items) {
  constexpr std::uint64_t digit = 0x7ff;
  std::vector<std::uint64_t> from(items.size());
  for (const int shift : {32, 43, 54}) {
    std::array<std::size_t, digit + 2> begin{};
    for (const std::uint64_t item : items) ++begin[(item >> shift & digit) + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    from.swap(items);
    for (const std::uint64_t item : from) items[begin[item >> shift & digit]++] = item;
  }
}

// Ascends as x does; the same for both zeros.
std::uint32_t ascending_bits(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x + 0.0F);
  return bits >> 31 != 0 ? ~bits : bits | 0x80000000U;
}

}  // namespace

std::vector<std::uint32_t> order_in_space(std::span<const float> list, int channels) {
  const auto count = static_cast<std::size_t>(channels);
  const std::size_t size = list.size() / count;
  const std::size_t used = std::min(count, std::size_t{8});
  const std::size_t bits = 32 / used;
  std::vector<std::uint64_t> items(size);
  std::vector<std::uint32_t> keys(size);
  for (std::size_t c = 0; c < used; ++c) {
    for (std::size_t i = 0; i < size; ++i) items[i] = std::uint64_t{ascending_bits(list[i * count + c])} << 32 | i;
    sort_by_upper_half(items);
    std::size_t rank = 0;  // the same for equal values
    for (std::size_t at = 0; at < size; ++at) {
      if (at > 0 && items[at] >> 32 != items[at - 1] >> 32) rank = at;
      const std::uint64_t coordinate = (std::uint64_t{rank} << bits) / size;
      std::uint32_t& key = keys[static_cast<std::uint32_t>(items[at])];
      for (std::size_t bit = 0; bit < bits; ++bit)
        key |= static_cast<std::uint32_t>(coordinate >> bit & 1) << (bit * used + c);
    }
  }
  for (std::size_t i = 0; i < size; ++i) items[i] = std::uint64_t{keys[i]} << 32 | i;
  sort_by_upper_half(items);
  std::transform(items.begin(), items.end(), keys.begin(),
                 [](std::uint64_t item) { return static_cast<std::uint32_t>(item); });
  return keys;
}

}  // namespace noiseloom
