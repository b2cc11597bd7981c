// What void and cluster is made of, part by part.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <new>
#include <numeric>
#include <thread>
#include <utility>

#include "construct/fields/vac_field.h"
#include "construct/fields/vac_kernel.h"
#include "construct/full_scans.h"
#include "construct/order/vac_exchange.h"
#include "construct/order/vac_order.h"
#include "construct/order/vac_slices.h"
#include "construct/order/vac_start.h"
#include "support/vac_specs.h"
#include "support/void_and_cluster_oracle.h"

namespace noiseloom {
namespace {

using namespace testing_support;

TEST(VacStartPattern, DrawsEachPixelAtMostOnce) {
  VacSpec spec = vac_spec({97, 89}, {{0, 1}});
  spec.density = 0.5;
  const auto points = vac_start_pattern(spec);
  EXPECT_EQ(points.size(), 97U * 89U / 2U);
  EXPECT_TRUE(std::is_sorted(points.begin(), points.end()));
  EXPECT_EQ(std::adjacent_find(points.begin(), points.end()), points.end());
  EXPECT_LT(points.back(), 97U * 89U);
}

TEST(VacKernel, LeavesRoomForAllNeighboursAndAFlag) {
  for (const double sigma : {0.3, 1.0, 1.9, 8.0, 30.0}) {
    for (const auto& groups : std::vector<std::vector<std::vector<int>>>{
             {{0, 1}}, {{0, 1, 2}}, {{0, 1}, {2}}, {{0, 1}, {2, 3}}, {{0, 1}, {2}, {3}}}) {
      const VacKernel kernel(vac_spec({32, 31, 16, 17}, groups, sigma));
      std::uint64_t sum = 0;
      for (const VacGroupKernel& group : kernel.groups()) {
        for (const std::uint32_t weight : group.weights) sum += weight;
      }
      EXPECT_EQ(sum, kernel.weight_sum());
      EXPECT_LT(sum, std::uint64_t{vac_flag}) << sigma;
      if (kernel.scale_log2() < 30) {  // and no more room than one bit
        EXPECT_GE(sum * 2 + 32 * 31 * 16 * 17, std::uint64_t{vac_flag}) << sigma;
      }
    }
  }
}

TEST(VacKernel, ScalesByTheLargestPowerOfTwoThatFits) {
  for (const double sigma : {0.6, 1.9, 8.0}) {
    for (const auto& groups : std::vector<std::vector<std::vector<int>>>{{{0, 1}}, {{0, 1}, {2}}, {{0, 1, 2}}}) {
      const VacSpec spec = vac_spec({9, 7, 5}, groups, sigma);
      const int scale_log2 = VacKernel(spec).scale_log2();
      EXPECT_LT(oracle::VoidAndClusterOracle(spec, scale_log2).largest_energy(), std::int64_t{vac_flag});
      EXPECT_TRUE(scale_log2 == 30 ||
                  oracle::VoidAndClusterOracle(spec, scale_log2 + 1).largest_energy() >= std::int64_t{vac_flag});
    }
  }
}

TEST(VacField, EnergyOfTheLastPixelIsTheSumOfAllWeightsAtTheLimits) {
  for (const double sigma : {0.3, 1.9, 8.0}) {
    const VacSpec spec = vac_spec({29, 23, 7, 5}, {{0, 1}, {2, 3}}, sigma);
    const VacKernel kernel(spec);
    VacField field(spec, kernel, 0, spec.extents.num_slices());
    std::vector<std::uint64_t> all(static_cast<std::size_t>(spec.extents.num_cells()));
    std::iota(all.begin(), all.end(), 0U);
    field.turn(true, all);
    for (const std::uint64_t p : all) ASSERT_EQ(field.word(p), vac_flag + kernel.weight_sum());
    field.turn(false, all);
    for (const std::uint64_t p : all) ASSERT_EQ(field.word(p), 0U);
  }
}

TEST(VacField, SlicesOfItsOwnGetTheSameEnergiesFromPicksAnywhere) {
  for (const auto& groups :
       std::vector<std::vector<std::vector<int>>>{{{0, 1}, {2, 3}}, {{0, 1}, {2}, {3}}, {{0, 1, 2, 3}}, {{1, 3}}}) {
    const VacSpec spec = vac_spec({13, 11, 5, 3}, groups, 1.3);
    const VacKernel kernel(spec);
    VacField whole(spec, kernel, 0, 15);
    const auto points = vac_start_pattern(spec);
    whole.turn(true, points);
    for (const auto& [begin, end] :
         std::vector<std::pair<std::int32_t, std::int32_t>>{{0, 4}, {4, 5}, {5, 15}, {7, 7}}) {
      VacField part(spec, kernel, begin, end);
      part.turn(true, points);
      for (std::uint64_t p = 0; p < 13U * 11U * 15U; ++p) {
        if (!part.has(p)) continue;
        ASSERT_EQ(part.word(p), whole.word(p));
      }
    }
  }
}

// What follows slice by slice is what a call of its own finds afterwards; also where it is too much, and some slices
// are not looked at.
TEST(VacField, AScanThatFollowsFindsWhatOneOfItsOwnFinds) {
  for (const std::size_t most : {std::size_t{100000}, std::size_t{300}}) {
    for (const auto& groups :
         std::vector<std::vector<std::vector<int>>>{{{0, 1}, {2, 3}}, {{0, 1}, {2}}, {{0, 1, 2}}}) {
      const VacSpec spec = vac_spec({16, 18, 6, 3}, groups, 1.3);
      const VacKernel kernel(spec);
      VacField at_once(spec, kernel, 0, 18);
      VacField apart(spec, kernel, 0, 18);
      std::vector<std::uint64_t> points = vac_start_pattern(spec);
      const std::vector<std::uint64_t> second(points.begin() + static_cast<std::ptrdiff_t>(points.size() / 2),
                                              points.end());
      points.resize(points.size() / 2);
      for (VacField* field : {&at_once, &apart}) {
        field->turn(true, points);
        field->refresh_bounds(VacView::voids);
        field->scan({VacView::voids, VacTieHash(1), std::uint64_t{20} << 32, 100000});
      }
      ASSERT_EQ(at_once.found().size(), apart.found().size());
      VacPortion portion;
      portion.positions = second;
      portion.divide(at_once.layout());
      ASSERT_TRUE(portion.is_divided());
      const std::uint64_t limit = std::uint64_t{kernel.weight_sum() / 8} << 32;
      const VacScan then{VacView::voids, VacTieHash(1), limit, most};
      at_once.turn(true, portion, &then);
      apart.turn(true, portion);
      apart.scan(then);
      ASSERT_FALSE(apart.found().empty());
      ASSERT_EQ(at_once.found_all(), most > 300);
      ASSERT_EQ(apart.found_all(), at_once.found_all());
      ASSERT_EQ(at_once.found().size(), apart.found().size());
      for (std::size_t i = 0; i < apart.found().size(); ++i) {
        ASSERT_EQ(at_once.found()[i].position, apart.found()[i].position);
        ASSERT_EQ(at_once.found()[i].key(), apart.found()[i].key());
      }
      ASSERT_TRUE(std::ranges::equal(at_once.bounds(), apart.bounds()));
      for (std::uint64_t p = 0; p < 16U * 18U * 18U; ++p) ASSERT_EQ(at_once.word(p), apart.word(p));
    }
  }
}

// A thread that fails must not leave the others waiting for it.
TEST(VacSlices, AFailureOfAHelperReachesTheCaller) {
  const VacSpec spec = vac_spec({16, 16, 16}, {{0, 1}, {2}}, 1.3);
  const VacKernel kernel(spec);
  ThreadPool pool(2);
  VacSlices slices(spec, kernel, 0, 16, pool);
  ASSERT_GT(slices.num_parts(), 2U);
  const auto caller = std::this_thread::get_id();
  std::atomic<bool> failed{false};
  VacPortion picks;
  for (std::uint32_t i = 0; i < 16; ++i) {
    picks.positions.push_back(257 * i);
    picks.numbers.push_back(i);
  }
  const auto turned = [&](std::size_t, std::size_t) {
    if (std::this_thread::get_id() == caller) {
      while (!failed) std::this_thread::yield();
      return;
    }
    failed = true;
    throw std::bad_alloc();
  };
  EXPECT_THROW(slices.turn_batch(true, picks, turned, true, nullptr), std::bad_alloc);
  EXPECT_TRUE(failed);
}

TEST(VacLayout, IndexesBeyondFourBillionPixels) {
  const VacSpec spec = vac_spec({65536, 32768, 4, 3}, {{0, 1}, {2, 3}});
  const VacLayout layout(spec, 0, 12);
  const std::uint64_t position = 65535 + 65536ULL * (32767 + 32768ULL * (3 + 4 * 2));
  EXPECT_THAT(layout.coord(position), testing::ElementsAre(65535, 32767, 3, 2, 0, 0, 0, 0));
  EXPECT_EQ(position, static_cast<std::uint64_t>(spec.extents.num_cells()) - 1);
  EXPECT_EQ(layout.leaves, 65536LL * 32768 / 64);
}

// The last slices of a texture of 2^42 pixels get the energies and candidates of the last ones of a small texture.
TEST(VacField, HoldsSlicesBeyondFourBillionPixels) {
  const VacSpec small = vac_spec({64, 64, 64}, {{0, 1}, {2}}, 0.9);
  const VacSpec large = vac_spec({64, 64, std::int64_t{1} << 30}, {{0, 1}, {2}}, 0.9);
  const VacKernel small_kernel(small);
  const VacKernel large_kernel(large);
  ASSERT_EQ(small_kernel.scale_log2(), large_kernel.scale_log2());
  VacField few(small, small_kernel, 61, 64);
  VacField many(large, large_kernel, (1 << 30) - 3, 1 << 30);
  const std::uint64_t shift = ((std::uint64_t{1} << 30) - 64) << 12;
  std::vector<std::uint64_t> near{5, 4100, 4096 * 58 + 77, 4096 * 61 + 63, 4096 * 62, 4096 * 63 + 4095};
  std::vector<std::uint64_t> far = near;
  for (std::uint64_t& position : far) position += position < 8192 ? 0 : shift;  // slices 0 and 1 touch the last ones
  few.turn(true, near);
  many.turn(true, far);
  few.refresh_bounds(VacView::voids);
  many.refresh_bounds(VacView::voids);
  for (std::uint64_t p = 61 * 4096; p < 64 * 4096; ++p) ASSERT_EQ(many.word(p + shift), few.word(p));
  EXPECT_GT(few.word(5 + 63 * 4096), 0U);  // around the torus
  many.scan({VacView::voids, VacTieHash(1), std::uint64_t{1} << 32, 100000});
  ASSERT_TRUE(many.found_all());
  const std::vector<VacCandidate>& found = many.found();
  ASSERT_FALSE(found.empty());
  for (const VacCandidate& c : found) ASSERT_EQ(c.hash, VacTieHash(1)(c.position));
  EXPECT_GT(found.front().position, std::uint64_t{1} << 41);
}

TEST(VacOrder, HoldsPlacesBeyondFourBillion) {
  const Extents extents({64, 64, std::int64_t{1} << 30});
  VacOrder order(extents, (1 << 30) - 2, 1 << 30);
  ASSERT_EQ(order.codec().type(), ElementType::uint64);
  EXPECT_EQ(order.end(), std::uint64_t{1} << 42);
  EXPECT_FALSE(order.has(order.begin() - 1));
  const std::uint64_t last = order.end() - 1;
  order.set_on(last);
  EXPECT_TRUE(order.is_on(last));
  order.set_place(last, (std::uint64_t{1} << 41) + 3);
  EXPECT_TRUE(order.has_place(last));
  EXPECT_FALSE(order.has_place(last - 1));
  const auto bytes = order.bytes(SliceIndex((1 << 30) - 1));
  ASSERT_EQ(bytes.size(), 4096U * 8);
  std::uint64_t place = 0;
  std::memcpy(&place, bytes.data() + 4095 * 8, 8);
  EXPECT_EQ(place, (std::uint64_t{1} << 41) + 3);
  VacOrder again(extents, (1 << 30) - 2, 1 << 30);
  again.set_bytes(SliceIndex((1 << 30) - 1), bytes);
  EXPECT_EQ(again.bytes(SliceIndex((1 << 30) - 1)), bytes);
}

TEST(VacStartPattern, DrawsAllOverMoreThanFourBillionPixels) {
  const VacSpec spec = vac_spec({64, 64, std::int64_t{1} << 30}, {{0, 1}});
  std::array<int, 4> quarter{};
  for (std::uint64_t draw = 0; draw < 4000; ++draw) {
    const std::uint64_t position = vac_start_draw(spec, draw);
    ASSERT_LT(position, std::uint64_t{1} << 42);
    ++quarter[position >> 40];
  }
  for (const int count : quarter) EXPECT_NEAR(count, 1000, 150);  // more than 5 standard deviations
}

TEST(VacPacker, GivesBackWhatItTook) {
  const VacTieHash hash(3);
  for (const VacView view : {VacView::voids, VacView::clusters}) {
    std::vector<VacCandidate> first;
    std::vector<VacCandidate> second;
    for (const std::uint64_t position : {0ULL, 1ULL, 130ULL, 16384ULL, (1ULL << 42) - 1}) {
      const std::uint32_t tie = hash(position) ^ static_cast<std::uint32_t>(view);
      first.push_back({position, static_cast<std::uint32_t>(position % 1000), tie});
      second.push_back({position + 7, 0x7FFFFFFF, hash(position + 7) ^ static_cast<std::uint32_t>(view)});
    }
    const VacPacker packer((std::uint64_t{0x7FFFFFFF} << 32) | 5);
    std::vector<std::byte> bytes;
    packer.pack(first, bytes);
    packer.pack({}, bytes);
    packer.pack(second, bytes);
    std::vector<VacCandidate> back;
    packer.unpack(bytes, view, hash, back);
    first.insert(first.end(), second.begin(), second.end());
    ASSERT_EQ(back.size(), first.size());
    for (std::size_t i = 0; i < back.size(); ++i) {
      EXPECT_EQ(back[i].position, first[i].position);
      EXPECT_EQ(back[i].key(), first[i].key());
    }
  }
}

TEST(VacTieHash, HasNoEqualsAmongSmallPositionsAndDependsOnTheHighWord) {
  const VacTieHash hash(7);
  EXPECT_FALSE(oracle::has_equals(hash, 1U << 20));
  EXPECT_NE(hash(5), hash(5 + (1ULL << 32)));
}

}  // namespace
}  // namespace noiseloom
