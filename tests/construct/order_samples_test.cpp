#include "noiseloom/construct/order_samples.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <random>

namespace noiseloom {
namespace {

const OrderCodec uint32_codec(ElementType::uint32);
const OrderCodec uint64_codec(ElementType::uint64);

template <class Entry>
std::vector<std::byte> bytes_of(const std::vector<Entry>& entries) {
  const auto bytes = std::as_bytes(std::span(entries));
  return {bytes.begin(), bytes.end()};
}

// Places 0 .. n-1 in random places, cut into slices.
std::vector<std::vector<std::uint32_t>> shuffled_slices(std::size_t num_slices, std::size_t cells) {
  std::vector<std::uint32_t> places(num_slices * cells);
  std::iota(places.begin(), places.end(), 0U);
  std::shuffle(places.begin(), places.end(), std::mt19937(1));
  std::vector<std::vector<std::uint32_t>> slices;
  for (std::size_t s = 0; s < num_slices; ++s) {
    const auto first = places.begin() + static_cast<std::ptrdiff_t>(s * cells);
    slices.emplace_back(first, first + static_cast<std::ptrdiff_t>(cells));
  }
  return slices;
}

OrderSpec settings(int bits, Equalize equalize) {
  OrderSpec spec;
  spec.bits = bits;
  spec.equalize = equalize;
  return spec;
}

// The difference between the largest and the smallest count, of levels 0 .. 2^bits - 1.
std::int64_t spread(const std::map<int, std::int64_t>& counts, int bits) {
  std::int64_t least = counts.size() < (std::size_t{1} << bits) ? 0 : counts.begin()->second;
  std::int64_t most = 0;
  for (const auto& [level, count] : counts) {
    EXPECT_GE(level, 0);
    EXPECT_LT(level, 1 << bits);
    least = std::min(least, count);
    most = std::max(most, count);
  }
  return most - least;
}

TEST(OrderSamples, AreTheMiddlesOfThePlaces) {
  for (const std::uint64_t n : {1ULL, 2ULL, 3ULL, 1000ULL, 65536ULL, 131071ULL}) {
    for (std::uint64_t place = 0; place < n; place += 1 + n / 997) {
      const double exact = (static_cast<double>(place) + 0.5) / static_cast<double>(n);
      EXPECT_EQ(sample_of_place(place, n, 0), static_cast<float>(exact)) << place << " of " << n;
    }
  }
}

TEST(OrderSamples, AreNeverOneAndKeepTheirLevel) {
  const std::uint64_t most = std::uint64_t{1} << 48;
  const std::vector<std::uint64_t> sizes = {(1ULL << 24) - 1, 1ULL << 24, (1ULL << 24) + 1, 100'000'007, 1ULL << 32,
                                            most - 1,         most};
  for (const std::uint64_t n : sizes) {
    std::vector<std::uint64_t> places = {0, n - 1, n / 2, n / 2 - 1};
    for (std::uint64_t level = 1; level < 65536; level += 13) {
      // The last place of each level, which float32 would round into the next one, and the first.
      const std::uint64_t first = static_cast<std::uint64_t>((static_cast<unsigned __int128>(n) * level + 65535) >> 16);
      places.insert(places.end(), {first - 1, first});
    }
    for (const std::uint64_t place : places) {
      const float sample = sample_of_place(place, n, 0);
      EXPECT_LT(sample, 1.0F);
      const auto level = static_cast<std::uint64_t>((static_cast<unsigned __int128>(2 * place + 1) << 15) / n);
      EXPECT_EQ(static_cast<std::uint64_t>(sample * 65536.0F), level) << place << " of " << n;
      const double exact = (static_cast<double>(place) + 0.5) / static_cast<double>(n);
      EXPECT_NEAR(sample, exact, exact * 0x1p-23);
    }
    EXPECT_EQ(sample_of_place(n - 1, n, 0), std::nextafter(1.0F, 0.0F)) << n;
  }
}

TEST(OrderSamples, LevelsAreExactAndEquallyFrequent) {
  for (const int bits : {1, 3, 8, 16}) {
    for (const std::uint64_t n : {1ULL, 7ULL, 1ULL << bits, 3ULL << bits, 100'003ULL}) {
      std::map<int, std::int64_t> counts;
      for (std::uint64_t place = 0; place < n; ++place) {
        const double level = static_cast<double>(sample_of_place(place, n, bits)) * std::exp2(bits) - 0.5;
        ASSERT_EQ(level, std::floor(level)) << place;
        ++counts[static_cast<int>(level)];
      }
      EXPECT_EQ(spread(counts, bits), n % (1ULL << bits) == 0 ? 0 : 1) << n << " at " << bits << " bits";
    }
  }
  const std::uint64_t most = std::uint64_t{1} << 48;
  EXPECT_EQ(sample_of_place(most - 1, most, 16), 1.0F - 0x1p-17F);
}

TEST(OrderSamples, EqualizeVolumesOrSlices) {
  const std::size_t cells = 16 * 12;
  const std::size_t num_slices = 5;
  const auto slices = shuffled_slices(num_slices, cells);
  for (const int bits : {0, 4}) {
    const int counted_bits = bits > 0 ? bits : 6;
    for (const Equalize equalize : {Equalize::volume, Equalize::slice}) {
      std::map<int, std::int64_t> volume;
      std::int64_t worst_slice = 0;
      for (const auto& places : slices) {
        std::map<int, std::int64_t> slice;
        const auto samples =
            samples_of_order(bytes_of(places), uint32_codec, num_slices * cells, settings(bits, equalize));
        ASSERT_EQ(samples.size(), cells);
        for (std::size_t i = 0; i < cells; ++i) {
          const int level = static_cast<int>(samples[i] * static_cast<float>(1 << counted_bits));
          ++volume[level];
          ++slice[level];
          for (std::size_t j = 0; j < i; j += 17) {  // the order inside a slice stays
            EXPECT_TRUE(places[j] > places[i] || samples[j] <= samples[i]);
          }
        }
        worst_slice = std::max(worst_slice, spread(slice, counted_bits));
      }
      EXPECT_EQ(spread(volume, counted_bits), 0);
      if (equalize == Equalize::slice) {
        EXPECT_EQ(worst_slice, 0);
      } else {
        EXPECT_GT(worst_slice, 1);  // places at random here
      }
    }
  }
}

TEST(OrderSamples, WidePlacesGiveTheSame) {
  for (const Equalize equalize : {Equalize::volume, Equalize::slice}) {
    const std::vector<std::uint32_t> narrow = {3, 0, 5, 1, 4, 2};
    const std::vector<std::uint64_t> wide(narrow.begin(), narrow.end());
    EXPECT_EQ(samples_of_order(bytes_of(narrow), uint32_codec, 6, settings(0, equalize)),
              samples_of_order(bytes_of(wide), uint64_codec, 6, settings(0, equalize)));
  }
  const std::uint64_t large = (std::uint64_t{1} << 40) + 3;
  const auto samples =
      samples_of_order(bytes_of<std::uint64_t>({large, ~std::uint64_t{0}}), uint64_codec, 1LL << 41, {});
  EXPECT_EQ(samples[0], static_cast<float>((static_cast<double>(large) + 0.5) / 0x1p41));
  EXPECT_TRUE(std::isnan(samples[1]));
}

// A pixel that has its place has its last sample: on the way through drain and fill none changes.
TEST(OrderSamples, ArePartsOfTheFinishedOnesWhilePlacesAreMissing) {
  const std::uint32_t off = ~0U;
  const std::uint32_t on = off - 1;
  const std::uint32_t points = 60;
  for (const auto& slice : shuffled_slices(3, 200)) {
    for (const Equalize equalize : {Equalize::volume, Equalize::slice}) {
      const auto finished = samples_of_order(bytes_of(slice), uint32_codec, 600, settings(0, equalize));
      for (const std::uint32_t placed : {0U, 17U, 60U, 61U, 300U, 599U}) {
        std::vector<std::uint32_t> partial = slice;
        for (std::uint32_t& place : partial) {
          if (placed < points) {
            place = place >= points ? off : place < points - placed ? on : place;  // drain, from the highest point down
          } else if (place >= placed) {
            place = off;  // fill
          }
        }
        const auto samples = samples_of_order(bytes_of(partial), uint32_codec, 600, settings(0, equalize));
        for (std::size_t i = 0; i < slice.size(); ++i) {
          if (partial[i] >= on) {
            EXPECT_TRUE(std::isnan(samples[i]));
          } else {
            EXPECT_EQ(samples[i], finished[i]);
          }
        }
      }
    }
  }
}

// Vectors go where the scalars of their numbers would.
TEST(OrderSamples, AlongACurveAreDealtByTheOrderOfTheSlice) {
  const std::uint32_t off = ~0U;
  for (std::vector<std::uint32_t> slice : shuffled_slices(3, 200)) {
    std::vector<float> list;
    for (int i = 0; i < 200; ++i) list.insert(list.end(), {static_cast<float>(i), static_cast<float>(1000 - i)});
    for (const std::uint32_t placed : {600U, 311U}) {
      for (std::uint32_t& place : slice) place = place < placed ? place : off;
      const auto numbers = samples_of_order(bytes_of(slice), uint32_codec, 600, settings(0, Equalize::slice));
      const auto samples = samples_along_curve(bytes_of(slice), uint32_codec, 600, list);
      ASSERT_EQ(samples.size(), 400U);
      for (std::size_t i = 0; i < 200; ++i) {
        ASSERT_EQ(std::isnan(numbers[i]), std::isnan(samples[2 * i]));
        if (std::isnan(numbers[i])) continue;
        EXPECT_EQ(samples[2 * i], std::floor(numbers[i] * 200));
        EXPECT_EQ(samples[2 * i + 1], 1000 - samples[2 * i]);
      }
    }
  }
}

}  // namespace
}  // namespace noiseloom
