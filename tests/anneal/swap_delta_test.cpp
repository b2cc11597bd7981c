#include "noiseloom/anneal/swap_delta.h"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

#include "anneal/texture_fixture.h"

namespace noiseloom {
namespace {

using namespace testing_support;
using test::Space;
using test::Texture;

struct FilterCase {
  std::string name;
  Extents extents;
  FilterSpec filter;
};

std::vector<FilterCase> filters() {
  return {
      {"box5 on 13x11", Extents({13, 11}), product({group({0, 1}, box(5))})},
      {"gauss folded on 7x5", Extents({7, 5}), product({group({0, 1}, gauss(1.5))})},
      {"length 1 and 2", Extents({1, 2, 3}), product({group({0, 1, 2}, gauss_energy(1.9))})},
      {"product with ema", Extents({7, 5, 5}), product({group({0, 1}, gauss(0.8)), group({2}, ema(0.1, 0.1))})},
      {"sum with ema", Extents({7, 5, 5}), sum({group({0, 1}, box(3)), group({2}, ema(0.1, 0.1))})},
      {"unequal sum over two slice axes", Extents({5, 7, 3, 2}),
       sum({group({0, 1}, gauss_energy(1.9), 0.3), group({2, 3}, box(3), 0.7)})},
      {"one group over plane and slices", Extents({5, 3, 3}), product({group({0, 1, 2}, gauss_energy(1.1))})},
      {"product over three slice axes", Extents({5, 3, 2, 3, 2}),
       product({group({0, 1}, binomial(2)), group({2, 3, 4}, box(2))})},
  };
}

// Largest |dE - oracle| over the sum of the magnitudes of the terms.
double largest_error(const FilterCase& filter, const Space& space, ValueKernelKind kind, Precision precision) {
  const Footprint footprint(filter.extents, filter.filter);
  const ValueKernel kernel = test::kernel_of(space, kind, filter.extents.num_axes());
  Texture texture(footprint, kernel, 7);
  const auto delta = make_swap_delta(footprint, kernel, precision);
  const SliceIndex slice(filter.extents.num_slices() / 2);
  const Cell cells = filter.extents.cells_per_slice();
  delta->bind(slice, texture.field(slice), texture.field_of());
  double worst = 0;
  for (const auto& [i, j] : {std::pair<Cell, Cell>{0, cells - 1}, {cells / 2, cells / 2 - 1}, {cells / 3, 1}}) {
    if (i == j) continue;
    const double before = texture.energy();
    const double change = delta->delta(test::pair(i, j));
    const double magnitude = texture.magnitude(slice, i, j);
    texture.field(slice).swap(i, j);
    worst = std::max(worst, std::abs(change - (texture.energy() - before)) / magnitude);
    texture.field(slice).swap(i, j);
  }
  return worst;
}

struct DeltaCase {
  Space space;
  ValueKernelKind kind;
};

class SwapDeltaOfSpace : public ::testing::TestWithParam<DeltaCase> {};

TEST_P(SwapDeltaOfSpace, IsTheChangeOfTheEnergyInDouble) {
  for (const FilterCase& filter : filters()) {
    EXPECT_LT(largest_error(filter, GetParam().space, GetParam().kind, Precision::float64), 1e-9) << filter.name;
  }
}

TEST_P(SwapDeltaOfSpace, IsTheChangeOfTheEnergyInFloat) {
  // Directions of the plane nearly oppose each other often, where a float chord resolves 5e-4 radians.
  const double tolerance = GetParam().space.name == "direction2" ? 1e-4 : 1e-5;
  for (const FilterCase& filter : filters()) {
    EXPECT_LT(largest_error(filter, GetParam().space, GetParam().kind, Precision::float32), tolerance) << filter.name;
  }
}

// dE of pairs that touch every cell of one slice, on one instruction set.
std::vector<double> all_deltas(const FilterCase& filter, const DeltaCase& delta_case, std::int64_t target) {
  hwy::SetSupportedTargetsForTest(target);
  const Footprint footprint(filter.extents, filter.filter);
  const ValueKernel kernel = test::kernel_of(delta_case.space, delta_case.kind, filter.extents.num_axes());
  const Texture texture(footprint, kernel, 11);
  const auto delta = make_swap_delta(footprint, kernel, Precision::float32);
  hwy::SetSupportedTargetsForTest(0);
  delta->bind(SliceIndex(0), texture.field(SliceIndex(0)), texture.field_of());
  std::vector<double> values;
  for (Cell i = 0; i < filter.extents.cells_per_slice(); ++i) {
    for (const Cell j : {i / 2, i - 1}) {
      if (j >= 0) values.push_back(delta->delta(test::pair(i, j)));
    }
  }
  return values;
}

TEST_P(SwapDeltaOfSpace, HasTheSameBitsOnAllInstructionSets) {
  for (const FilterCase& filter : filters()) {
    const std::vector<double> reference = all_deltas(filter, GetParam(), HWY_STATIC_TARGET);
    for (std::int64_t targets = hwy::SupportedTargets(); targets != 0; targets &= targets - 1) {
      EXPECT_EQ(all_deltas(filter, GetParam(), targets & -targets), reference) << filter.name << " " << targets;
    }
  }
}

TEST_P(SwapDeltaOfSpace, FollowsTheSwapsThatItMakes) {
  for (const FilterCase& filter : filters()) {
    const Cell cells = filter.extents.cells_per_slice();
    const Footprint footprint(filter.extents, filter.filter);
    const ValueKernel kernel = test::kernel_of(GetParam().space, GetParam().kind, filter.extents.num_axes());
    Texture texture(footprint, kernel, 13);
    const auto swapped = make_swap_delta(footprint, kernel, Precision::float32);
    const auto bound = make_swap_delta(footprint, kernel, Precision::float32);
    swapped->bind(SliceIndex(0), texture.field(SliceIndex(0)), texture.field_of());
    for (const auto& [i, j] : {std::pair<Cell, Cell>{0, cells - 1}, {cells / 2, 0}, {cells / 3, cells - 1}}) {
      swapped->swap(test::pair(i, j));
      texture.field(SliceIndex(0)).swap(i, j);
    }
    bound->bind(SliceIndex(0), texture.field(SliceIndex(0)), texture.field_of());
    for (Cell j = 1; j < cells; ++j)
      EXPECT_EQ(swapped->delta(test::pair(0, j)), bound->delta(test::pair(0, j))) << filter.name;
  }
}

std::vector<DeltaCase> delta_cases() {
  std::vector<DeltaCase> cases;
  for (const Space& space : test::all_spaces()) {
    cases.push_back({space, ValueKernelKind::distance});
    cases.push_back({space, ValueKernelKind::stbn});
  }
  return cases;
}

INSTANTIATE_TEST_SUITE_P(All, SwapDeltaOfSpace, ::testing::ValuesIn(delta_cases()), [](const auto& test) {
  return test.param.space.name + (test.param.kind == ValueKernelKind::distance ? "_distance" : "_stbn");
});

}  // namespace
}  // namespace noiseloom
