// Both ways to find the candidates in reach of a pick find the same.
#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <utility>

#include "construct/bins/vac_bins.h"
#include "construct/bins/vac_plane_bins.h"
#include "support/vac_specs.h"

namespace noiseloom {
namespace {

using namespace testing_support;

void expect_same_energies(const VacSpec& spec) {
  const VacKernel kernel(spec);
  const VacLayout layout(spec, 0, spec.extents.num_slices());
  std::mt19937_64 random(7);
  const auto draw = [&] {
    VacBins::Coord at{};
    for (int axis = 0; axis < layout.num_axes; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      at[a] = static_cast<std::int32_t>(random() % static_cast<std::uint64_t>(layout.size[a]));
    }
    return at;
  };
  VacBins bins(layout, kernel.groups()[0]);
  VacPlaneBins plane_bins(layout, kernel.groups()[0]);
  for (const std::size_t count : {1U, 40U, 700U}) {  // fewer than a vector and many in each plane
    std::vector<VacBins::Coord> at(count);
    std::generate(at.begin(), at.end(), draw);
    bins.assign(at);
    plane_bins.assign(at);
    std::vector<std::uint32_t> one(count);
    std::vector<std::uint32_t> other(count);
    for (int pick = 0; pick < 300; ++pick) {
      const VacBins::Coord from = pick % 2 == 0 ? draw() : at[random() % count];
      bins.visit(from, [&](std::uint32_t i, std::uint32_t weight) { one[i] += weight; });
      plane_bins.raise(from, other);
    }
    EXPECT_EQ(one, other) << spec.extents.to_string() << " " << count;
    EXPECT_TRUE(count == 1 || std::accumulate(one.begin(), one.end(), std::uint64_t{0}) > 0);
  }
}

void expect_same_energies_everywhere() {
  expect_same_energies(vac_spec({100, 90}, {{0, 1}}));
  expect_same_energies(vac_spec({67, 61, 2}, {{0, 1}}, 1.3));
  expect_same_energies(vac_spec({300, 70}, {{0, 1}}));         // several tiles both ways
  expect_same_energies(vac_spec({131, 259}, {{0, 1}}, 5));     // wide footprints
  expect_same_energies(vac_spec({140, 33, 2}, {{0, 1}}, 10));  // that meet a tile from both sides
  expect_same_energies(vac_spec({3, 2, 50, 64}, {{2, 3}}));
  expect_same_energies(vac_spec({7, 5, 11, 3}, {{1, 3}}, 8));  // a footprint as large as the plane
  VacSpec bounded = vac_spec({40, 50}, {{0, 1}});
  bounded.toroidal = {false, true};
  expect_same_energies(bounded);
  bounded.toroidal = {true, false};
  expect_same_energies(bounded);
  for (const auto& [x, y] : {std::pair{false, true}, {true, false}, {false, false}}) {  // several tiles both ways
    bounded = vac_spec({256, 70}, {{0, 1}});
    bounded.toroidal = {x, y};
    expect_same_energies(bounded);
  }
}

TEST(VacPlaneBins, FindWhatBinsOfTheFootprintsSizeFind) { expect_same_energies_everywhere(); }

TEST(VacPlaneBins, DoNotDependOnTheWidthOfVectors) {
  for (std::int64_t rest = hwy::SupportedTargets() & HWY_TARGETS; rest != 0; rest &= rest - 1) {
    const std::int64_t target = rest & -rest;
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().DeInit();
    SCOPED_TRACE(hwy::TargetName(target));
    expect_same_energies_everywhere();
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().DeInit();
}

}  // namespace
}  // namespace noiseloom
