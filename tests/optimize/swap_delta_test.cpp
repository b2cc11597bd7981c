#include "noiseloom/optimize/swap_delta.h"

#include <gtest/gtest.h>

#include "optimize/texture_fixture.h"

namespace noiseloom {
namespace {

using test::group;
using test::Space;
using test::Texture;

struct FilterCase {
  std::string name;
  Extents extents;
  FilterSpec filter;
};

std::vector<FilterCase> filters() {
  return {
      {"box5 on 13x11", Extents({13, 11}), {Combine::product, {group({0, 1}, KernelKind::box, 5)}}},
      {"gauss folded on 7x5", Extents({7, 5}), {Combine::product, {group({0, 1}, KernelKind::gauss, 1.5)}}},
      {"length 1 and 2", Extents({1, 2, 3}), {Combine::product, {group({0, 1, 2}, KernelKind::gauss_energy, 1.9)}}},
      {"product with ema",
       Extents({7, 5, 5}),
       {Combine::product, {group({0, 1}, KernelKind::gauss, 0.8), group({2}, KernelKind::ema, 0)}}},
      {"sum with ema",
       Extents({7, 5, 5}),
       {Combine::sum, {group({0, 1}, KernelKind::box, 3), group({2}, KernelKind::ema, 0)}}},
      {"unequal sum over two slice axes",
       Extents({5, 7, 3, 2}),
       {Combine::sum, {group({0, 1}, KernelKind::gauss_energy, 1.9, 0.3), group({2, 3}, KernelKind::box, 3, 0.7)}}},
      {"one group over plane and slices",
       Extents({5, 3, 3}),
       {Combine::product, {group({0, 1, 2}, KernelKind::gauss_energy, 1.1)}}},
      {"product over three slice axes",
       Extents({5, 3, 2, 3, 2}),
       {Combine::product, {group({0, 1}, KernelKind::binomial, 2), group({2, 3, 4}, KernelKind::box, 2)}}},
  };
}

// Largest |dE - oracle| over the sum of the magnitudes of the terms.
double largest_error(const FilterCase& filter, const Space& space, ValueKernelKind kind, Precision precision) {
  const Footprint footprint(filter.extents, filter.filter);
  const ValueKernel kernel = test::kernel_of(space, kind, filter.extents.num_axes());
  Texture texture(footprint, kernel, 7);
  const auto delta = make_swap_delta(footprint, kernel, precision);
  const SliceIndex slice = filter.extents.num_slices() / 2;
  const Cell cells = filter.extents.cells_per_slice();
  delta->bind(slice, texture.field(slice), texture.field_of());
  double worst = 0;
  for (const auto& [i, j] : {std::pair<Cell, Cell>{0, cells - 1}, {cells / 2, cells / 2 - 1}, {cells / 3, 1}}) {
    if (i == j) continue;
    const double before = texture.energy();
    const double change = delta->delta(i, j);
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
    EXPECT_LT(largest_error(filter, GetParam().space, GetParam().kind, Precision::dual), 1e-9) << filter.name;
  }
}

TEST_P(SwapDeltaOfSpace, IsTheChangeOfTheEnergyInFloat) {
  for (const FilterCase& filter : filters()) {
    EXPECT_LT(largest_error(filter, GetParam().space, GetParam().kind, Precision::single), 1e-5) << filter.name;
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
