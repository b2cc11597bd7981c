// How the pairs of a texture's samples are shared out among tasks, and which of them are looked at: what stands behind
// MeanDistance (problem/score.h), with limits that tests can lower.
#pragma once

#include <cstdint>

#include "noiseloom/problem/score.h"

namespace noiseloom {

// Slices of more pixels are divided without an order in space, which would take longer than the pairs.
inline constexpr std::int64_t largest_ordered_slice = std::int64_t{1} << 22;

struct PairBudget {
  std::int64_t max_sorted_numbers = std::int64_t{1} << 26;  // where mean_is_sorted(): exact up to here
  std::int64_t max_paired_samples = 46340;                  // elsewhere: exact up to here (2^30 pairs, each way)
  std::int64_t pairs_wanted = std::int64_t{1} << 29;        // beyond, between neighbouring blocks
  std::int64_t largest_block = 16384;
  std::int64_t smallest_block = 64;
};

// Blocks are numbered slice by slice, on a ring. Each meets itself and the blocks `stride`, 2 * `stride`, ... after it,
// `neighbours` of them; where slices are divided and there are several, also the next block of its own slice.
struct Division {
  DistanceKind kind = DistanceKind::absolute;
  int channels = 1;
  std::int64_t cells_per_slice = 0;
  std::int64_t num_slices = 0;
  bool exact = false;
  bool sorts_everything = false;  // a single task
  std::int64_t parts = 1;         // blocks per slice
  std::int64_t neighbours = 0;
  std::int64_t stride = 1;  // leads to another slice
  std::int64_t blocks_per_task = 1;

  std::int64_t num_blocks() const { return parts * num_slices; }
  std::int64_t num_tasks() const;
  double num_samples() const { return static_cast<double>(cells_per_slice) * static_cast<double>(num_slices); }
  // Samples of a block. The first of a slice hold one more where the division leaves a rest.
  std::int64_t size(std::int64_t part) const { return cells_per_slice / parts + (part < cells_per_slice % parts); }
  // Blocks of one slice are not independent: pairs within slices and between slices count as many as there are of each.
  bool meets_own_slice() const { return !exact && parts > 1 && num_slices > 1; }

  // What sums of distances between neighbours count in m: those of `stride`, and those in a slice.
  struct PairFactors {
    double between;
    double in_slice;
  };
  PairFactors pair_factors() const;
};

Division divide_pairs(DistanceKind kind, int channels, std::int64_t cells_per_slice, std::int32_t num_slices,
                      const PairBudget& budget = {});

// The share of one task in m.
double run_division_task(const Division& division, std::int64_t task, const SliceList& list);

}  // namespace noiseloom
