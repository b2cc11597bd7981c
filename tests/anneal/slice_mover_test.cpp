#include "noiseloom/anneal/slice_mover.h"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <set>

#include "anneal/moves/proposals.h"
#include "anneal/texture_fixture.h"
#include "noiseloom/core/random.h"

namespace noiseloom {
namespace {

using namespace testing_support;
using test::Texture;

// A slice has as many samples as cells, and both are numbers from 0: none is taken for the other.
static_assert(!std::is_convertible_v<Cell, SampleId> && !std::is_convertible_v<SampleId, Cell>);
static_assert(sizeof(SampleId) == sizeof(std::uint32_t) && std::is_trivially_copyable_v<SampleId>);
template <class Id>
concept HasPartner = requires(const PartnerDraw& draw, Id id) {
  draw.partner(id, 1);
};
static_assert(HasPartner<SampleId> && !HasPartner<Cell> && !HasPartner<std::uint32_t>);
template <class Key>
concept NamesCell = requires(decltype(cells_by_id({}, {}, {}, {})) cells, Key key) {
  cells[key];
};
static_assert(NamesCell<SampleId> && !NamesCell<Cell> && !NamesCell<std::uint32_t>);
template <class Ids>
concept LaysOut = requires(SliceField field, Ids ids, std::vector<float> list) {
  field.fill(ids, list);
};
static_assert(LaysOut<Permutation> && !LaysOut<std::vector<std::uint32_t>> && !LaysOut<std::vector<Cell>>);

class Movers : public ::testing::Test {
 protected:
  const Extents extents_{Extents({17, 13, 3})};
  const Footprint footprint_{extents_, product({group({0, 1}, gauss(1)), group({2}, box(2))})};
  const ValueKernel kernel_ = test::kernel_of(test::all_spaces()[0], ValueKernelKind::distance, 3);
  const Cell cells_ = extents_.cells_per_slice();

  Permutation ids() const { return identity_permutation(cells_); }
  AnnealMover anneal_mover() const { return AnnealMover(make_swap_delta(footprint_, kernel_, Precision::float64)); }
};

void apply(const VisitResult& result, SliceField& field) {
  for (const Swap& swap : result.swaps) field.swap(swap.a, swap.b);
}

TEST_F(Movers, AnnealAtTemperatureZeroNeverRaisesTheEnergyAndLowersIt) {
  Texture texture(footprint_, kernel_, 3);
  AnnealMover mover = anneal_mover();
  const PartnerDraw partners(cells_, {8}, false);
  const double start = texture.energy();
  double last = start;
  for (std::uint32_t sweep = 0; sweep < 5; ++sweep) {
    const VisitResult result =
        mover.visit({SliceIndex(1), sweep, 9}, 0, partners, texture.field(SliceIndex(1)), ids(), texture.field_of());
    apply(result, texture.field(SliceIndex(1)));
    EXPECT_LE(texture.energy(), last + 1e-9);
    last = texture.energy();
  }
  EXPECT_LT(last, start);
}

TEST_F(Movers, SwapsKeepTheSamplesOfTheSlice) {
  Texture texture(footprint_, kernel_, 4);
  AnnealMover mover = anneal_mover();
  std::vector<float> before = texture.field(SliceIndex(2)).planar();
  const VisitResult result = mover.visit({SliceIndex(2), 0, 9}, 1, PartnerDraw(cells_, {64}, false),
                                         texture.field(SliceIndex(2)), ids(), texture.field_of());
  EXPECT_GT(result.swaps.size(), 0U);
  EXPECT_LE(std::ssize(result.swaps), result.candidates);
  apply(result, texture.field(SliceIndex(2)));
  std::vector<float> after = texture.field(SliceIndex(2)).planar();
  EXPECT_NE(before, after);
  std::sort(before.begin(), before.end());
  std::sort(after.begin(), after.end());
  EXPECT_EQ(before, after);
}

TEST_F(Movers, AnEnormousTemperatureAcceptsNearlyEverything) {
  Texture texture(footprint_, kernel_, 4);
  AnnealMover mover = anneal_mover();
  const VisitResult result = mover.visit({SliceIndex(0), 0, 9}, 1e12, PartnerDraw(cells_, {64}, false),
                                         texture.field(SliceIndex(0)), ids(), texture.field_of());
  EXPECT_EQ(std::ssize(result.swaps), result.candidates);
}

TEST_F(Movers, AnnealIsAFunctionOfSeedSliceAndSweep) {
  const Texture texture(footprint_, kernel_, 4);
  AnnealMover mover = anneal_mover();
  const PartnerDraw partners(cells_, {64}, false);
  const auto swaps = [&](const Visit& visit) {
    return mover.visit(visit, 0.1, partners, texture.field(visit.slice), ids(), texture.field_of()).swaps;
  };
  const auto first = swaps({SliceIndex(0), 5, 9});
  EXPECT_NE(first, swaps({SliceIndex(0), 6, 9}));
  EXPECT_NE(first, swaps({SliceIndex(1), 5, 9}));
  EXPECT_NE(first, swaps({SliceIndex(0), 5, 10}));
  EXPECT_EQ(first, swaps({SliceIndex(0), 5, 9}));
}

TEST_F(Movers, EqualSamplesNeverMakeAChange) {
  Texture texture(footprint_, kernel_, 4);
  const std::vector<float> same(static_cast<std::size_t>(cells_), 0.5F);
  for (const SliceIndex slice : first_indices<SliceIndex>(3)) texture.field(slice).fill(ids(), same);
  AnnealMover mover = anneal_mover();
  EXPECT_EQ(mover.mean_magnitude({SliceIndex(0), 0, 9}, 100, PartnerDraw(cells_, {64}, false),
                                 texture.field(SliceIndex(0)), ids(), texture.field_of()),
            0);
}

TEST_F(Movers, PairingSwapsDisjointPairsThatEachLowerTheEnergy) {
  Texture texture(footprint_, kernel_, 5);
  PairingMover mover(make_swap_delta(footprint_, kernel_, Precision::float64));
  const VisitResult result = mover.visit({SliceIndex(1), 0, 9}, 1, texture.field(SliceIndex(1)), texture.field_of());
  EXPECT_GE(result.candidates, cells_ / 2 - 1);
  EXPECT_GT(result.swaps.size(), 0U);
  std::set<std::uint32_t> touched;
  const double start = texture.energy();
  for (const Swap& swap : result.swaps) {
    EXPECT_TRUE(touched.insert(swap.a).second);
    EXPECT_TRUE(touched.insert(swap.b).second);
    texture.field(SliceIndex(1)).swap(swap.a, swap.b);
    EXPECT_LT(texture.energy(), start);
    texture.field(SliceIndex(1)).swap(swap.a, swap.b);
  }
}

TEST(PartnerDraw, KeepsItsDistanceOnARingAndReflectsOnALine) {
  constexpr std::int32_t n = 1009;
  const PartnerDraw ring(n, {64}, true);
  const PartnerDraw line(n, {64}, false);
  for (std::uint32_t id = 0; id < n; ++id) {
    for (std::int32_t step = -n / 2; step <= n / 2; ++step) {
      const std::int64_t around = std::abs(ring.partner(SampleId(id), step) - SampleId(id));
      ASSERT_EQ(std::min(around, n - around), std::abs(step));
      ASSERT_LT(line.partner(SampleId(id), step).value(), n);
      const std::int64_t straight = std::int64_t{id} + step;
      if (straight >= 0 && straight < n) {
        ASSERT_EQ(line.partner(SampleId(id), step).value(), straight);
      }
    }
  }
}

TEST(PartnerDraw, DrawsBetweenNearAndFar) {
  const PartnerDraw partners(4096, {64, 8}, false);
  EXPECT_EQ(partners.lowest_step(), 64);
  EXPECT_NEAR(partners.log2_ratio(), 3, 1e-6);  // 512 = 8 * 64
  EXPECT_EQ(PartnerDraw(4096, {1e6, 2}, false).lowest_step(), 1);
}

// Also for slices of one, two and three samples.
TEST(PartnerDraw, StaysInRange) {
  for (const std::int64_t n : {1, 2, 3, 5}) {
    for (const bool circular : {false, true}) {
      const PartnerDraw partners(n, {64}, circular);
      for (const SampleId id : first_indices<SampleId>(n)) {
        for (const auto step : {partners.lowest_step(), partners.lowest_step() * std::exp2(partners.log2_ratio())}) {
          EXPECT_LT(partners.partner(id, static_cast<std::int32_t>(step)).value(), n);
          EXPECT_LT(partners.partner(id, -static_cast<std::int32_t>(step)).value(), n);
        }
      }
    }
  }
}

constexpr std::uint64_t seed = 0x123456789abcdefU;

ProposalSource proposal_source() { return {seed, 3, 5, 1009, 16, 5}; }

TEST(Proposals, ArePhiloxBySeedSliceSweepAndIndex) {
  const std::uint64_t first = (std::uint64_t{7} << 32) - 3;  // across a carry into the upper word
  const Proposals proposals = draw_proposals(proposal_source(), first);
  for (std::size_t k = 0; k < proposal_batch; ++k) {
    const RandomBlock block = random_block(seed, Purpose::proposal, 3, 5, first + k);
    EXPECT_EQ(proposals.cell[k], to_below(block[0], 1009));
    const double step = 16 * std::exp2(5 * (static_cast<double>(block[1] >> 9) + 0.5) * 0x1p-23);
    EXPECT_NEAR(proposals.step[k], (block[1] & 1U) != 0 ? -step : step, 1.001);
    EXPECT_NEAR(proposals.threshold[k], -std::log((static_cast<double>(block[2] >> 9) + 0.5) * 0x1p-23), 1e-5);
  }
}

TEST(Proposals, HaveTheSameBitsOnAllInstructionSets) {
  const auto bytes = [](std::int64_t target) {
    hwy::SetSupportedTargetsForTest(target);
    std::vector<std::uint32_t> words;
    for (std::uint64_t first = 0; first < 4096; first += proposal_batch) {
      const Proposals proposals = draw_proposals(proposal_source(), first);
      for (std::size_t k = 0; k < proposal_batch; ++k) {
        words.push_back(proposals.cell[k]);
        words.push_back(static_cast<std::uint32_t>(proposals.step[k]));
        words.push_back(std::bit_cast<std::uint32_t>(proposals.threshold[k]));
      }
    }
    hwy::SetSupportedTargetsForTest(0);
    return words;
  };
  const auto reference = bytes(HWY_STATIC_TARGET);
  for (std::int64_t targets = hwy::SupportedTargets(); targets != 0; targets &= targets - 1) {
    EXPECT_EQ(bytes(targets & -targets), reference) << targets;
  }
}

}  // namespace
}  // namespace noiseloom
