#include "noiseloom/core/partition.h"

#include <algorithm>

#include "noiseloom/core/distribution.h"

namespace noiseloom {

Partition::Partition(SliceIndex num_slices, int num_ranks) : num_slices_(num_slices), num_ranks_(num_ranks) {
  NOISELOOM_CHECK_LE(1, num_ranks);
  NOISELOOM_CHECK_LE(0, num_slices);
}

SliceIndex Partition::begin(int part) const {
  const SliceIndex each = num_slices_ / num_ranks_;
  const SliceIndex extra = num_slices_ % num_ranks_;
  return each * part + std::min<SliceIndex>(part, extra);
}

int Partition::part_of(SliceIndex slice) const {
  NOISELOOM_CHECK(slice >= 0 && slice < num_slices_);
  const SliceIndex each = num_slices_ / num_ranks_;
  const SliceIndex extra = num_slices_ % num_ranks_;
  const SliceIndex long_part = (each + 1) * extra;
  return slice < long_part ? slice / (each + 1) : extra + (slice - long_part) / each;
}

Distribution::Distribution(const Partition& partition, Rank rank) : partition_(partition), rank_(rank) {
  NOISELOOM_CHECK(ranks().contains(rank));
}

}  // namespace noiseloom
