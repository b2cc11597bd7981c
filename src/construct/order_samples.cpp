#include "noiseloom/construct/order_samples.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

static_assert(std::endian::native == std::endian::little, "ranks are stored as they are in memory");

template <class Rank>
std::vector<float> samples_of(std::span<const std::byte> order, std::int64_t num_pixels, const OrderSpec& spec) {
  constexpr Rank on = std::numeric_limits<Rank>::max() - 1;
  std::vector<Rank> ranks(order.size() / sizeof(Rank));
  std::memcpy(ranks.data(), order.data(), ranks.size() * sizeof(Rank));
  std::vector<float> samples(ranks.size(), std::numeric_limits<float>::quiet_NaN());
  if (spec.equalize == Equalize::volume) {
    for (std::size_t i = 0; i < ranks.size(); ++i) {
      if (ranks[i] < on) {
        samples[i] = sample_of_rank(ranks[i], static_cast<std::uint64_t>(num_pixels), spec.bits);
      }
    }
    return samples;
  }
  std::vector<std::uint32_t> cells(ranks.size());
  std::iota(cells.begin(), cells.end(), 0U);
  std::erase_if(cells, [&](std::uint32_t cell) { return ranks[cell] >= on; });
  std::sort(cells.begin(), cells.end(), [&](std::uint32_t a, std::uint32_t b) { return ranks[a] < ranks[b]; });
  // What is still on will be ranked below all that has a rank.
  auto rank = static_cast<std::uint64_t>(std::count(ranks.begin(), ranks.end(), on));
  for (const std::uint32_t cell : cells) samples[cell] = sample_of_rank(rank++, ranks.size(), spec.bits);
  return samples;
}

}  // namespace

float sample_of_rank(std::uint64_t rank, std::uint64_t num_ranks, int bits) {
  if (bits > 0) {
    const std::uint64_t level = (rank << bits) / num_ranks;
    return std::ldexp(static_cast<float>(2 * level + 1), -bits - 1);
  }
  const auto sample = static_cast<float>((static_cast<double>(rank) + 0.5) / static_cast<double>(num_ranks));
  const std::uint64_t exact_level = ((2 * rank + 1) << 15) / num_ranks;
  const bool rounded_past = static_cast<std::uint64_t>(sample * 65536.0F) > exact_level;
  return rounded_past ? std::nextafter(sample, 0.0F) : sample;
}

std::vector<float> samples_of_order(std::span<const std::byte> order, bool wide, std::int64_t num_pixels,
                                    const OrderSpec& spec) {
  return wide ? samples_of<std::uint64_t>(order, num_pixels, spec) : samples_of<std::uint32_t>(order, num_pixels, spec);
}

}  // namespace noiseloom
