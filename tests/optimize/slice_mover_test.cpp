#include "noiseloom/optimize/slice_mover.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "noiseloom/optimize/involution.h"
#include "optimize/texture_fixture.h"

namespace noiseloom {
namespace {

using test::group;
using test::Texture;

class Movers : public ::testing::Test {
 protected:
  const Extents extents_{Extents({17, 13, 3})};
  const Footprint footprint_{extents_,
                             {Combine::product, {group({0, 1}, KernelKind::gauss, 1), group({2}, KernelKind::box, 2)}}};
  const ValueKernel kernel_ = test::kernel_of(test::all_spaces()[0], ValueKernelKind::distance, 3);
  const Cell cells_ = extents_.cells_per_slice();

  std::vector<std::uint32_t> ids() const {
    std::vector<std::uint32_t> ids(static_cast<std::size_t>(cells_));
    std::iota(ids.begin(), ids.end(), 0U);
    return ids;
  }
  AnnealMover anneal_mover() const {
    return AnnealMover(make_swap_delta(footprint_, kernel_, Precision::dual));
  }
};

void apply(const VisitResult& result, SliceField& field) {
  for (const Swap& swap : result.swaps) field.swap(swap.a, swap.b);
}

TEST_F(Movers, AnnealAtTemperatureZeroNeverRaisesTheEnergyAndLowersIt) {
  Texture texture(footprint_, kernel_, 3);
  AnnealMover mover = anneal_mover();
  const PartnerDraw partners(cells_, 8, false);
  const double start = texture.energy();
  double last = start;
  for (std::uint32_t sweep = 0; sweep < 5; ++sweep) {
    const VisitResult result = mover.visit({1, sweep, 9}, 0, partners, texture.field(1), ids(), texture.field_of());
    apply(result, texture.field(1));
    EXPECT_LE(texture.energy(), last + 1e-9);
    last = texture.energy();
  }
  EXPECT_LT(last, start);
}

TEST_F(Movers, SwapsKeepTheSamplesOfTheSlice) {
  Texture texture(footprint_, kernel_, 4);
  AnnealMover mover = anneal_mover();
  std::vector<float> before = texture.field(2).planar();
  const VisitResult result =
      mover.visit({2, 0, 9}, 1, PartnerDraw(cells_, 64, false), texture.field(2), ids(), texture.field_of());
  EXPECT_GT(result.swaps.size(), 0U);
  EXPECT_LE(std::ssize(result.swaps), result.candidates);
  apply(result, texture.field(2));
  std::vector<float> after = texture.field(2).planar();
  EXPECT_NE(before, after);
  std::sort(before.begin(), before.end());
  std::sort(after.begin(), after.end());
  EXPECT_EQ(before, after);
}

TEST_F(Movers, AnEnormousTemperatureAcceptsNearlyEverything) {
  Texture texture(footprint_, kernel_, 4);
  AnnealMover mover = anneal_mover();
  const VisitResult result =
      mover.visit({0, 0, 9}, 1e12, PartnerDraw(cells_, 64, false), texture.field(0), ids(), texture.field_of());
  EXPECT_EQ(std::ssize(result.swaps), result.candidates);
}

TEST_F(Movers, AnnealIsAFunctionOfSeedSliceAndSweep) {
  const Texture texture(footprint_, kernel_, 4);
  AnnealMover mover = anneal_mover();
  const PartnerDraw partners(cells_, 64, false);
  const auto swaps = [&](const Visit& visit) {
    return mover.visit(visit, 0.1, partners, texture.field(visit.slice), ids(), texture.field_of()).swaps;
  };
  const auto first = swaps({0, 5, 9});
  EXPECT_NE(first, swaps({0, 6, 9}));
  EXPECT_NE(first, swaps({1, 5, 9}));
  EXPECT_NE(first, swaps({0, 5, 10}));
  EXPECT_EQ(first, swaps({0, 5, 9}));
}

TEST_F(Movers, EqualSamplesNeverMakeAChange) {
  Texture texture(footprint_, kernel_, 4);
  const std::vector<float> same(static_cast<std::size_t>(cells_), 0.5F);
  for (SliceIndex slice = 0; slice < 3; ++slice) texture.field(slice).fill(ids(), same);
  AnnealMover mover = anneal_mover();
  EXPECT_EQ(
      mover.mean_magnitude({0, 0, 9}, 100, PartnerDraw(cells_, 64, false), texture.field(0), ids(), texture.field_of()),
      0);
}

TEST_F(Movers, PairingSwapsDisjointPairsThatEachLowerTheEnergy) {
  Texture texture(footprint_, kernel_, 5);
  PairingMover mover(make_swap_delta(footprint_, kernel_, Precision::dual));
  const VisitResult result = mover.visit({1, 0, 9}, 1, texture.field(1), texture.field_of());
  EXPECT_GE(result.candidates, cells_ / 2 - 1);
  EXPECT_GT(result.swaps.size(), 0U);
  std::set<std::uint32_t> touched;
  const double start = texture.energy();
  for (const Swap& swap : result.swaps) {
    EXPECT_TRUE(touched.insert(swap.a).second);
    EXPECT_TRUE(touched.insert(swap.b).second);
    texture.field(1).swap(swap.a, swap.b);
    EXPECT_LT(texture.energy(), start);
    texture.field(1).swap(swap.a, swap.b);
  }
}

TEST(Involution, IsItsOwnInverseAndPairsNearlyAllCells) {
  for (const std::uint64_t n : {1U, 2U, 3U, 4U, 31U, 64U, 221U, 1024U}) {
    const Involution rho(11, 2, 3, n);
    std::uint64_t alone = 0;
    for (std::uint64_t i = 0; i < n; ++i) {
      EXPECT_LT(rho(i), n);
      EXPECT_EQ(rho(rho(i)), i);
      alone += rho(i) == i ? 1 : 0;
    }
    EXPECT_LE(alone, n % 2 == 1 ? 1U : 2U) << n;
  }
}

TEST(PartnerDraw, StaysInRangeAndKeepsItsDistance) {
  constexpr std::int64_t n = 1009;
  for (const bool circular : {false, true}) {
    const PartnerDraw partners(n, 64, circular);
    for (std::uint32_t k = 0; k < 20000; ++k) {
      const std::uint32_t bits = k * 2654435761U;
      const std::uint32_t id = k % n;
      const std::int64_t other = partners.partner(id, bits);
      ASSERT_GE(other, 0);
      ASSERT_LT(other, n);
      if (circular) {
        const std::int64_t d = std::abs(other - std::int64_t{id});
        ASSERT_GE(std::min(d, n - d), n / 64);
      }
    }
  }
}

}  // namespace
}  // namespace noiseloom
