#include "problem/filters/overlap.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

namespace noiseloom {
namespace {

// The order of the sum decides its last bits, and with them every texture.
TEST(Overlap, SumsOfProductsOfTapsAreInAscendingOrder) {
  for (const std::size_t n : {1U, 2U, 3U, 7U, 8U, 9U, 16U, 37U, 100U}) {
    std::vector<double> varied(n);
    for (std::size_t i = 0; i < n; ++i) varied[i] = 0.1 + std::sin(static_cast<double>(i * i));
    for (const std::vector<double>& taps : {varied, std::vector<double>(n, 1 / static_cast<double>(3 * n))}) {
      const std::vector<double> sums = autocorrelation(taps);
      ASSERT_EQ(sums.size(), n);
      for (std::size_t d = 0; d < n; ++d) {
        double sum = 0;
        for (std::size_t i = 0; i + d < n; ++i) sum += taps[i] * taps[i + d];
        EXPECT_EQ(sums[d], sum) << n << " " << d;
      }
    }
  }
}

TEST(Overlap, SumsOfAnArrayAreInAscendingOrder) {
  const std::vector<std::int64_t> sizes = {5, 3, 4};
  const Extents extents({31, 29, 23});
  std::vector<double> taps(60);
  for (std::size_t i = 0; i < taps.size(); ++i) taps[i] = i % 7 == 3 ? 0 : 0.1 + std::sin(static_cast<double>(i * i));
  std::map<std::array<std::int64_t, 3>, double> expected;
  const auto at = [&](std::int64_t i) { return std::array{i % 5, i / 5 % 3, i / 15}; };
  for (std::int64_t i = 0; i < 60; ++i) {
    for (std::int64_t j = i; j < 60; ++j) {
      const auto a = at(i);
      const auto b = at(j);
      expected[{b[0] - a[0], b[1] - a[1], b[2] - a[2]}] +=
          taps[static_cast<std::size_t>(i)] * taps[static_cast<std::size_t>(j)];
    }
  }
  std::erase_if(expected, [](const auto& entry) { return entry.second == 0; });
  std::size_t seen = 0;
  for (const OverlapTap& tap : array_overlap(extents, {0, 1, 2}, sizes, taps).taps) {
    const auto found = expected.find({tap.offset[0], tap.offset[1], tap.offset[2]});
    if (found == expected.end()) continue;  // the other sign
    EXPECT_EQ(tap.weight, found->second);
    ++seen;
  }
  EXPECT_EQ(seen, expected.size());
}

}  // namespace
}  // namespace noiseloom
