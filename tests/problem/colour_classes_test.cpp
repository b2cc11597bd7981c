#include "noiseloom/problem/colour_classes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <set>

#include "support/filter_specs.h"

namespace noiseloom {
namespace {

using namespace testing_support;

Footprint footprint(std::vector<std::int64_t> sizes, std::vector<GroupSpec> groups,
                    Combine combine = Combine::product) {
  FilterSpec filter;
  filter.combine = combine;
  filter.groups = std::move(groups);
  for (GroupSpec& group : filter.groups) group.weight = 1.0 / static_cast<double>(filter.groups.size());
  return Footprint(Extents(std::move(sizes)), filter);
}

std::int64_t ring_distance(std::int64_t a, std::int64_t b, std::int64_t size) {
  const std::int64_t d = std::abs(a - b);
  return std::min(d, size - d);
}

TEST(ColourClasses, HoldEverySliceOnce) {
  for (const std::int64_t t : {1, 2, 3, 7, 8, 13, 64}) {
    for (const std::int64_t z : {1, 5}) {
      const Footprint f =
          footprint({3, 3, t, z}, {group({0, 1}, box(3)), group({2}, ema(0.1, 0.1)), group({3}, box(3))});
      std::set<SliceIndex> seen;
      for (const auto& members : colour_classes(f)) {
        EXPECT_FALSE(members.empty());
        for (const SliceIndex slice : members) EXPECT_TRUE(seen.insert(slice).second);
      }
      EXPECT_EQ(static_cast<std::int64_t>(seen.size()), t * z);
    }
  }
}

TEST(ColourClasses, UncoupledSlicesMoveTogether) {
  EXPECT_EQ(colour_classes(footprint({5, 5, 11}, {group({0, 1}, box(3))})).size(), 1U);
}

TEST(ColourClasses, CoupledMembersStandAtLeastFourApart) {
  for (const std::int64_t t : {8, 9, 11, 30, 64}) {
    for (const auto& members :
         colour_classes(footprint({3, 3, t}, {group({0, 1}, box(3)), group({2}, ema(0.1, 0.1))}))) {
      for (const SliceIndex a : members) {
        for (const SliceIndex b : members) {
          if (a != b) {
            EXPECT_GE(ring_distance(a.value(), b.value(), t), 4);
          }
        }
      }
    }
  }
}

TEST(ColourClasses, ShortReachNeedsNoMoreThanItsOwnDistance) {
  // box 2 overlaps reach 1: every other slice may move.
  for (const auto& members : colour_classes(footprint({3, 3, 12}, {group({0, 1}, box(3)), group({2}, box(2))}))) {
    EXPECT_EQ(members.size(), 6U);
  }
}

// A running mean over all frames: every slice weighs as much as the own one, so at most two may move at once.
TEST(ColourClasses, FlatCouplingLeavesFewSlicesTogether) {
  for (const auto& members : colour_classes(footprint({3, 3, 64}, {group({0, 1}, box(3)), group({2}, box(64))}))) {
    EXPECT_LE(members.size(), 2U);
  }
}

// Over two axes the couplings multiply; what counts is their sum over all members of a class.
TEST(ColourClasses, CouplingIsLimitedOverAllAxesTogether) {
  for (const int size : {4, 8, 10}) {
    const Footprint f = footprint({3, 3, 16, 16}, {group({0, 1}, box(3)), group({2, 3}, box(size))});
    double own = f.weight_zero();
    for (const PlaneTap& tap : f.slices()[0].taps) own += tap.weight;
    for (const auto& members : colour_classes(f)) {
      double others = 0;
      for (const SliceTaps& taps : f.slices()) {
        const SliceIndex other = f.extents().slice_at(members[0], taps.offset);
        if (other == members[0] || std::find(members.begin(), members.end(), other) == members.end()) continue;
        for (const PlaneTap& tap : taps.taps) others += tap.weight;
      }
      EXPECT_LE(others, 1.6 * own) << size;
    }
  }
}

// The classes by their definition, offset by offset and position by position.
std::vector<std::vector<SliceIndex>> classes_by_definition(const Footprint& f) {
  const Extents& extents = f.extents();
  std::vector<std::int64_t> strides;
  for (int axis = 2; axis < extents.num_axes(); ++axis) {
    strides.push_back(std::min<std::int64_t>(4, f.reach(axis) + 1));
  }
  const auto plane = [](const SliceTaps& slice) {
    double sum = 0;
    for (const PlaneTap& tap : slice.taps) sum += std::abs(tap.weight);
    return sum;
  };
  const auto coupling = [&] {
    double sum = 0;
    for (const SliceTaps& slice : f.slices().subspan(1)) {
      bool together = true;
      for (std::size_t k = 0; k < strides.size(); ++k) {
        const std::int64_t d = std::abs(slice.offset[k]);
        together &= d % strides[k] == 0 || (extents.size(static_cast<int>(k) + 2) - d) % strides[k] == 0;
      }
      if (together) sum += plane(slice);
    }
    return sum;
  };
  while (coupling() > 1.6 * (f.weight_zero() + plane(f.slices()[0]))) {
    int widest = -1;
    for (int axis = 2; axis < extents.num_axes(); ++axis) {
      const std::int64_t stride = strides[static_cast<std::size_t>(axis - 2)];
      if (f.reach(axis) == 0 || stride >= extents.size(axis)) continue;
      if (widest < 0 ||
          stride * extents.size(widest) < strides[static_cast<std::size_t>(widest - 2)] * extents.size(axis))
        widest = axis;
    }
    if (widest < 0) break;
    std::int64_t& stride = strides[static_cast<std::size_t>(widest - 2)];
    stride = 2 * (stride + 1) <= extents.size(widest) ? stride + 1 : extents.size(widest);
  }
  std::map<std::vector<std::int64_t>, std::vector<SliceIndex>> classes;  // by colours, the last axis counting most
  for (const SliceIndex slice : extents.slices()) {
    std::vector<std::int64_t> colours;
    for (std::size_t k = strides.size(); k-- > 0;) {
      const std::int64_t size = extents.size(static_cast<int>(k) + 2);
      const std::int64_t at = extents.slice_coord(slice)[k];
      const std::int64_t regular = strides[k] == 1 || size >= 2 * strides[k] ? size - size % strides[k] : 0;
      colours.push_back(at < regular ? at % strides[k] : (regular > 0 ? strides[k] : 0) + at - regular);
    }
    classes[colours].push_back(slice);
  }
  std::vector<std::vector<SliceIndex>> result;
  for (auto& [colours, members] : classes) result.push_back(std::move(members));
  return result;
}

TEST(ColourClasses, AreThoseOfTheDefinition) {
  for (const std::int64_t t : {1, 2, 3, 7, 16, 37}) {
    for (const std::int64_t z : {1, 4, 9}) {
      for (const KernelSpec& kernel : {box(2), box(5), box(64), ema(0.1, 0.1), gauss(1.5)}) {
        const std::vector<std::int64_t> sizes = {3, 3, t, z};
        const Footprint both = footprint(sizes, {group({0, 1}, box(3)), group({2, 3}, kernel)});
        EXPECT_EQ(colour_classes(both), classes_by_definition(both)) << t << " " << z;
        const Footprint apart =
            footprint(sizes, {group({0, 1}, box(3)), group({2}, kernel), group({3}, kernel)}, Combine::sum);
        EXPECT_EQ(colour_classes(apart), classes_by_definition(apart)) << t << " " << z;
      }
    }
  }
}

// In time in proportion to the length: squared, this would take hours.
TEST(ColourClasses, OfAMillionSlicesAreFoundAtOnce) {
  for (const KernelSpec& kernel : {ema(0.1, 0.1), box(60'000)}) {
    const auto classes = colour_classes(footprint({1, 1, 1'000'000}, {group({2}, kernel)}));
    std::size_t slices = 0;
    for (const auto& members : classes) slices += members.size();
    EXPECT_EQ(slices, 1'000'000U);
  }
}

}  // namespace
}  // namespace noiseloom
