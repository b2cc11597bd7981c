// Relative error R (mean squared error after the filter over random step integrands, white noise = 1).
//
//   R = ( m * sum_d F(d)  -  sum_{d != 0} F(d) m_d ) / ( m * F(0) )
//
// m_d is the mean distance between samples d apart, m the mean over all n^2 ordered pairs of the texture's samples. R
// is a small difference of large sums, so every sum is in double and in a fixed order.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "noiseloom/core/parallel.h"
#include "noiseloom/problem/footprint.h"
#include "noiseloom/problem/spec.h"

namespace noiseloom {

// The values of one slice, planar: [channel][y][x]. Must stay valid while the function that was given it runs.
using SliceValues = std::function<const float*(SliceIndex)>;
// The samples of one slice in any order, interleaved [sample][channel].
using SliceList = std::function<std::vector<float>(SliceIndex)>;

// Which end of a pair of cells in two slices counts it.
enum class PairEnds {
  both,
  one  // twice: half the cost; only the sum over all slices is the same
};

// sum over the cells j of `slice` and over all taps d of F(d) * d(s_j, s_{j+d}). Asks `values` only for slices that the
// footprint couples with `slice`. The same bits whatever else runs.
double weighted_distance_sum(const Footprint& footprint, DistanceKind kind, int channels, SliceIndex slice,
                             const SliceValues& values, PairEnds ends = PairEnds::both);

// Whether m is found by sorting each channel, as a sum over the channels: of scalars, circles and sums of differences.
constexpr bool mean_is_sorted(DistanceKind kind) {
  return kind == DistanceKind::absolute || kind == DistanceKind::circle || kind == DistanceKind::manhattan;
}

// m, split into tasks so that ranks and threads can share them: m is the sum of what the tasks return, added up in
// order by combine(). Exact (all n^2 pairs) by sorting up to 2^26 numbers, and for other distances up to 2^31
// pairs; beyond, exact in first order, from all pairs inside blocks and between neighbouring blocks of a random
// division of each slice that parts samples near each other (error stated in mean_distance.cpp).
class MeanDistance {
 public:
  MeanDistance(DistanceKind kind, int channels, std::int64_t cells_per_slice, std::int32_t num_slices);
  std::int64_t num_tasks() const;
  // Tasks do not depend on each other; each asks for the lists that it needs.
  double run_task(std::int64_t task, const SliceList& list) const;
  double combine(std::span<const double> task_results) const;
  bool exact() const;
  // How many pairs of samples are looked at, where samples are not sorted.
  std::int64_t num_pairs() const;
  // The most memory that a task takes for its time, in bytes, where it does not sort all numbers.
  double task_bytes() const;
  // All tasks on this process.
  double compute(const SliceList& list, ThreadPool& pool) const;

 private:
  DistanceKind kind_;
  int channels_;
  std::int64_t cells_per_slice_;
  std::int32_t num_slices_;
};

// `slice_sums`: weighted_distance_sum of every slice, in slice order. 1 where all samples are equal (m = 0).
double relative_error(const Footprint& footprint, double mean_distance, std::span<const double> slice_sums);

}  // namespace noiseloom
