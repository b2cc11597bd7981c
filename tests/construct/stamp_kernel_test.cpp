#include "construct/stamp_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "support/construct_problems.h"
#include "support/oracle.h"
#include "support/slice_construction_oracle.h"

namespace noiseloom {
namespace {

using namespace testing_support;

// The weights at every offset, by position among all cells; checks what each row promises on the way.
std::vector<std::int64_t> weights_of(const StampKernel& kernel) {
  const Extents& extents = kernel.extents();
  std::vector<std::int64_t> result(static_cast<std::size_t>(extents.num_cells()));
  std::vector<bool> seen(result.size());
  EXPECT_EQ(kernel.weights().size() % StampKernel::vector_words, 0U);
  for (const SliceStamp& stamp : kernel.stamps()) {
    EXPECT_EQ(stamp.is_narrow, stamp.left + stamp.right < static_cast<std::int32_t>(StampKernel::vector_words));
    for (const StampRow& row : stamp.rows) {
      EXPECT_LE(-stamp.up, row.dy);
      EXPECT_LE(row.dy, stamp.down);
      EXPECT_LE(row.lo, stamp.left);
      EXPECT_LE(row.hi, stamp.right);
      EXPECT_LT(row.lo + row.hi, extents.width());
      if (stamp.is_narrow) {
        EXPECT_EQ(row.lo, stamp.left);
        EXPECT_EQ(row.hi, stamp.right);
      }
      const std::size_t vector = StampKernel::vector_words;
      const std::size_t padded = (static_cast<std::size_t>(row.lo + row.hi) / vector + 1) * vector;
      EXPECT_LE(row.first + padded + vector, kernel.weights().size()) << "a part of the row is read past the end";
      for (std::size_t k = 0; k < padded; ++k) {
        const auto weight = static_cast<std::int32_t>(kernel.weights().at(row.first + k));
        const std::int64_t dx = static_cast<std::int64_t>(k) - row.lo;
        if (dx > row.hi) {
          EXPECT_EQ(weight, 0);  // what fills the vector up
          continue;
        }
        oracle::Coord at{dx, row.dy};
        for (std::size_t axis = 0; axis < stamp.offset.size(); ++axis) at[axis + 2] = stamp.offset[axis];
        const std::size_t flat = oracle::flat_of(extents, at);
        EXPECT_FALSE(seen[flat]) << "an offset occurs twice";
        seen[flat] = true;
        result[flat] = weight;
      }
    }
  }
  return result;
}

StampKernel kernel_of(const ConstructProblem& problem) {
  return StampKernel(problem.extents, problem.filter, problem.spec.sharpness);
}

TEST(StampKernel, HoldsTheWeightsOfItsFormula) {
  for (const ConstructProblem& problem : construct_problems()) {
    for (const double sharpness : {0.7, 1.0, 1.5}) {
      const StampKernel kernel = kernel_of(problem.with_sharpness(sharpness));
      const oracle::FullKernel full = oracle::full_kernel(problem.extents, problem.filter, sharpness);
      EXPECT_EQ(kernel.scale_log2(), full.scale_log2) << problem.name;
      EXPECT_EQ(kernel.bias(), full.bias) << problem.name;
      EXPECT_EQ(weights_of(kernel), full.weights) << problem.name;
    }
  }
}

// By hand: box 3 along x has the overlap 1, 2/3, 1/3 of F(0) at 0, 1, 2.
TEST(StampKernel, HoldsWeightsThatAreKnown) {
  const FilterSpec filter = product({group({0}, box(3))});
  const StampKernel kernel(Extents({11, 3}), filter, 2);
  ASSERT_EQ(kernel.scale_log2(), 30);  // 2 (4/9 + 1/9) of 2^30
  const std::vector<std::int64_t> weights = weights_of(kernel);
  const auto share = [](double of) { return static_cast<std::int64_t>(std::llround(std::ldexp(of, 30))); };
  EXPECT_EQ(weights[0], 0);
  EXPECT_NEAR(static_cast<double>(weights[1]), static_cast<double>(share(4. / 9)), 1);
  EXPECT_NEAR(static_cast<double>(weights[2]), static_cast<double>(share(1. / 9)), 1);
  EXPECT_EQ(weights[10], weights[1]);
  EXPECT_EQ(weights[9], weights[2]);
  for (std::size_t at = 3; at < weights.size(); ++at) EXPECT_TRUE(weights[at] == 0 || at == 9 || at == 10);
}

TEST(StampKernel, IsSymmetric) {
  for (const ConstructProblem& problem : construct_problems()) {
    const std::vector<std::int64_t> weights = weights_of(kernel_of(problem));
    EXPECT_EQ(weights[0], 0);
    for (std::size_t at = 0; at < weights.size(); ++at) {
      const oracle::Coord d = oracle::coord_of(problem.extents, static_cast<std::int64_t>(at));
      const std::size_t opposite = oracle::flat_of(problem.extents, oracle::difference({}, d));
      ASSERT_EQ(weights[at], weights[opposite]) << problem.name;
    }
  }
}

TEST(StampKernel, LeavesRoomForAllNeighboursAndAFlag) {
  std::vector<ConstructProblem> problems = construct_problems();
  for (const double sigma : {0.05, 0.5, 8.0, 30.0}) {
    problems.push_back(
        construct_problem("sigma", {32, 31, 5}, product({group({0, 1}, gauss(sigma)), group({2}, ema(1e-6, 0.1))})));
  }
  for (const ConstructProblem& problem : problems) {
    for (const double sharpness : {0.25, 1.0, 3.0}) {
      const StampKernel kernel = kernel_of(problem.with_sharpness(sharpness));
      std::int64_t magnitude = 0;
      std::int64_t negative = 0;
      for (const std::int64_t weight : weights_of(kernel)) {
        magnitude += std::abs(weight);
        negative -= std::min<std::int64_t>(weight, 0);
      }
      EXPECT_LT(magnitude, std::int64_t{1} << 31) << problem.name;
      EXPECT_EQ(kernel.bias(), negative) << problem.name;
      EXPECT_EQ(kernel.is_monotone(), negative == 0) << problem.name;
      if (kernel.scale_log2() < 30) {  // and no more room than one bit
        EXPECT_GE(2 * magnitude + problem.extents.num_cells(), std::int64_t{1} << 31) << problem.name;
      }
    }
  }
}

TEST(StampKernel, HasABiasOnlyWhereWeightsAreNegative) {
  const Extents extents({13, 12, 5});
  EXPECT_EQ(StampKernel(extents, product({group({0, 1}, gauss(1))}), 1.4).bias(), 0U);
  EXPECT_GT(StampKernel(extents, product({group({0, 1}, taps_with_negative_ones())}), 1.4).bias(), 0U);
  // A product of two negative weights is none.
  const StampKernel both(extents, product({group({0, 1}, taps({2}, {1, -0.5})), group({2}, taps({2}, {1, -0.5}))}), 1);
  const std::vector<std::int64_t> weights = weights_of(both);
  EXPECT_LT(weights[1], 0);
  EXPECT_GT(weights[1 + 13 * 12], 0);
}

TEST(StampKernel, IsTheOverlapItselfAtSharpnessOne) {
  for (const ConstructProblem& problem : construct_problems()) {
    const StampKernel kernel = kernel_of(problem.with_sharpness(1));
    const std::vector<double> overlap = oracle::overlaps(Footprint(problem.extents, problem.filter));
    const std::vector<std::int64_t> weights = weights_of(kernel);
    for (std::size_t at = 1; at < weights.size(); ++at) {
      const double share = std::ldexp(static_cast<double>(weights[at]), -kernel.scale_log2());
      // Half a unit, and each group's cut at 2^-12 of its own F(0).
      EXPECT_NEAR(share, overlap[at] / overlap[0], std::ldexp(1, -kernel.scale_log2()) + 0x1p-12) << problem.name;
    }
  }
}

TEST(StampKernel, SharpensSpaceAndNotTime) {
  const Extents extents({16, 15, 9});
  const auto cells = static_cast<std::size_t>(extents.cells_per_slice());
  const FilterSpec filter = product({group({0, 1}, gauss(1)), group({2}, ema(0.1, 0.1))});
  const std::vector<double> overlap = oracle::overlaps(Footprint(extents, filter));
  const StampKernel kernel(extents, filter, 2);
  const std::vector<std::int64_t> weights = weights_of(kernel);
  const auto share = [&](std::size_t at) { return std::ldexp(static_cast<double>(weights[at]), -kernel.scale_log2()); };
  const double unit = std::ldexp(1, -kernel.scale_log2());
  for (std::size_t t = 1; t < 9; ++t) EXPECT_NEAR(share(t * cells), overlap[t * cells] / overlap[0], 2 * unit);
  for (std::size_t x = 1; x < 4; ++x) {
    const double ratio = overlap[x] / overlap[0];
    EXPECT_NEAR(share(x), ratio * ratio, 2 * unit);
    EXPECT_NEAR(share(cells + x), ratio * ratio * overlap[cells] / overlap[0], 2 * unit);
  }
  const StampKernel time(extents, product({group({2}, ema(0.1, 0.1))}), 2);
  EXPECT_EQ(weights_of(time), weights_of(StampKernel(extents, product({group({2}, ema(0.1, 0.1))}), 1)));
}

TEST(StampKernel, NamesOffsetsOfOtherSlicesOnlyWhereWeightsAreLeft) {
  for (const ConstructProblem& problem : construct_problems()) {
    const StampKernel kernel = kernel_of(problem);
    ASSERT_EQ(kernel.stamps().at(0).offset, Extents::SliceCoord{});
    for (std::size_t k = 1; k < kernel.stamps().size(); ++k) {
      EXPECT_NE(kernel.stamps()[k].offset, Extents::SliceCoord{});
      EXPECT_FALSE(kernel.stamps()[k].rows.empty());
    }
  }
  // So weak a coupling that it is cut.
  const FilterSpec weak = product({group({0, 1}, gauss(1)), group({2}, taps({2}, {1, 1e-5}))});
  EXPECT_EQ(StampKernel(Extents({7, 5, 3}), weak, 1).stamps().size(), 1U);
}

TEST(StampKernel, MayReachSlicesThatTheOverlapDoesNot) {
  const Extents extents({11, 5, 7});
  EXPECT_FALSE(Footprint(extents, planes_that_cancel()).couples_slices());
  EXPECT_EQ(StampKernel(extents, planes_that_cancel(), 1).stamps().size(), 1U);
  EXPECT_EQ(StampKernel(extents, planes_that_cancel(), 1.4).stamps().size(), 3U);
}

}  // namespace
}  // namespace noiseloom
