// The sum of distances that R is made of (problem/score.h), in float: some five times as quick as in double, for the
// many rows of a history. The score at a stop, at the end and in every other program is the one in double.
//
// How far the two differ: a distance in float is off by 6e-8 of itself at random, angles by up to 4e-7; R amplifies
// what is common to all of them by sum(F) / F(0). Where that would show in the third digit of an R of 0.01, fits() says
// no. tests/anneal/float_score_test.cpp measures it.
#pragma once

#include <cstdint>
#include <vector>

#include "noiseloom/anneal/slice_field.h"
#include "noiseloom/anneal/swap_delta.h"
#include "noiseloom/problem/footprint.h"

namespace noiseloom {

class FloatScore {
 public:
  // `layout`: of the fields. Both must outlive the object.
  FloatScore(const Footprint& footprint, DistanceKind kind, const FieldLayout& layout);

  // Whether the sums are exact enough, and the border of the fields is as wide as the footprint reaches.
  static bool fits(const Footprint& footprint, DistanceKind kind, const FieldLayout& layout);

  // What weighted_distance_sum gives with PairEnds::one: the terms of `slice` of a sum over all slices. The same bits
  // on every instruction set.
  double slice_sum(SliceIndex slice, const FieldOf& fields) const;

  struct Tap {
    std::int64_t offset;  // in a plane, relative to the centre
    float weight;
  };
  // The taps from a slice to the one at `offset` of which one end counts, twice.
  struct SlicePlan {
    Extents::SliceCoord offset;
    std::vector<Tap> taps;
  };

 private:
  const Footprint& footprint_;
  DistanceKind kind_;
  const FieldLayout& layout_;
  std::vector<SlicePlan> plans_;
};

}  // namespace noiseloom
