// What a swap would change, estimated through features (feature_map.h) of all slices, the moving one included: a sieve,
// so that only those candidates are judged by all their taps that may be accepted. When a run has cooled, that is one
// in ten.
//
//   sum_k F(i - k) K(s, s_k)  ~  f(s) . B_i  +  terms of one sample,       B_i = A sum_{k != i} F(i - k) f(s_k)
//   dE / 2                    ~  (f(b) - f(a)) . (B_i - B_j)  -  F(i - j) (K(a, a) + K(b, b) - 2 K(a, b))
//
// for a sample a at i and b at j. Unlike the background's, this B holds the moving slice, so that a swap changes it
// within the footprints of both cells: a cost for each swap, not for each candidate. Where F is small it is left as it
// was until the next visit.
#pragma once

#include <span>
#include <vector>

#include "anneal/deltas/background_simd.h"
#include "anneal/deltas/sieve_simd.h"

namespace noiseloom {

class Sieve {
 public:
  // A swap is told where F is at least that share of the largest tap of the own slice. Measured at as many iterations:
  // R is the same within its scatter (0.03 % of vector2 gauss 1 + ema, 0.1 % of vector2 gauss 1 x gauss 1) from 0.004
  // to 0.3, and a run takes 11 to 17 % less time.
  static constexpr double least_change_told = 0.08;
  // What is not told comes to no more than that share of all taps, where a kernel has a wide foot of small ones. (Of a
  // Gaussian, 0.08 of its largest leaves out 0.06.)
  static constexpr double most_untold = 0.1;
  // From those two: the least weight, as a magnitude, that is told. 0 without taps.
  static double least_weight_told(std::span<const PlaneTap> taps);

  // Whether other slices count by the plane of the moving slice or by the same pixel alone; a sieve serves no other
  // footprint.
  static bool serves(const Footprint& footprint);

  // Requires serves(footprint). Both must outlive the object.
  Sieve(const Footprint& footprint, const FeatureMap& map, WindowSize window);

  // `own`: the window at `corner` itself.
  void bind(SliceIndex slice, Corner corner, const SliceField& own, const FieldOf& others);
  // (f(b) - f(a)) . (B_i - B_j) of each pair: dE / 2, but for the term of the pair itself.
  void estimate(std::span<const CellPair> pairs, float* out) const;
  void swap(CellPair pair);

  // A multiple of block_lanes; lanes past the map's features are zero.
  std::int64_t num_lanes() const { return num_lanes_; }
  const float* features(Cell cell) const { return values_of(features_) + cell * num_lanes_; }
  const float* pulls(Cell cell) const { return values_of(pulls_) + cell * num_lanes_; }

 private:
  void plan_own(const Footprint& footprint);
  void plan_others(const Footprint& footprint);
  void add_at(Cell cell, float sign);

  const FeatureMap& map_;
  FieldLayout layout_;  // of the window
  std::int64_t num_lanes_;
  bool others_by_planes_;
  SlicesAround around_;             // by planes: their weights over that of the own slice
  Background::Filter filter_;       // of the own slice, with a centre
  float centre_ = 0;                // which counts no more than it should: see bind()
  std::vector<FootprintRow> rows_;  // of the own slice, without a centre
  std::vector<float> weights_;
  std::vector<float> mixing_;           // A, rows of num_lanes
  std::vector<float> sums_;             // [feature][plane with border]
  std::vector<float> scratch_;          // as many
  std::vector<float> stack_;            // as many, where others count by the same pixel
  std::vector<BlockWeights> features_;  // f by cell
  std::vector<BlockWeights> pulls_;     // B by cell
  std::vector<BlockWeights> change_;    // of B by a swap, for a weight of 1
};

}  // namespace noiseloom
