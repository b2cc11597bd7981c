#include "noiseloom/anneal/involution.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <set>
#include <vector>

namespace noiseloom {
namespace {

TEST(Involution, IsItsOwnInverseWithFewFixedPoints) {
  for (const std::uint64_t n : std::vector<std::uint64_t>{1, 2, 3, 5, 16, 17, 64, 101, 1000, 4096, 10007}) {
    for (std::uint32_t sweep = 0; sweep < 5; ++sweep) {
      const Involution rho(7, 3, sweep, n);
      std::uint64_t fixed = 0;
      for (std::uint64_t i = 0; i < n; ++i) {
        const std::uint64_t j = rho(i);
        ASSERT_LT(j, n);
        ASSERT_EQ(rho(j), i);
        fixed += i == j;
      }
      // XOR pairs all of a power of two; a reflection leaves one cell of an odd n, none or two of an even n.
      EXPECT_LE(fixed, std::has_single_bit(n) && n > 1 ? 0U : 2U) << n;
    }
  }
}

TEST(Involution, SigmaIsAPermutation) {
  for (const std::uint64_t n : std::vector<std::uint64_t>{2, 3, 17, 101, 256, 10007}) {
    const Involution rho(1, 0, 0, n);
    std::set<std::uint64_t> images;
    for (std::uint64_t i = 0; i < n; ++i) {
      EXPECT_TRUE(images.insert(rho.permute(i)).second);
      EXPECT_EQ(rho.unpermute(rho.permute(i)), i);
    }
  }
}

// Over many sweeps every pair comes up about equally often: the counts of one cell's partners stay within 6 standard
// deviations of the mean (2000 sweeps, 100 partners, fixed seed).
TEST(Involution, PairsEveryCellWithEveryOther) {
  constexpr std::uint64_t n = 101;
  constexpr int sweeps = 2000;
  std::vector<int> partners(n);
  for (std::uint32_t sweep = 0; sweep < sweeps; ++sweep) ++partners[Involution(5, 2, sweep, n)(42)];
  const double mean = static_cast<double>(sweeps) / n;
  for (std::uint64_t j = 0; j < n; ++j) EXPECT_NEAR(partners[j], mean, 6 * std::sqrt(mean)) << j;
}

}  // namespace
}  // namespace noiseloom
