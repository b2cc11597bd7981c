#include "noiseloom/anneal/colour_classes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
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
            EXPECT_GE(ring_distance(a, b, t), 4);
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

}  // namespace
}  // namespace noiseloom
