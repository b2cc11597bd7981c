#include "noiseloom/core/partition.h"

#include <algorithm>

#include "noiseloom/core/distribution.h"

namespace noiseloom {

Partition::Partition(std::int32_t num_slices, int num_ranks) : num_slices_(num_slices), num_ranks_(num_ranks) {
  NOISELOOM_CHECK_LE(1, num_ranks);
  NOISELOOM_CHECK_LE(0, num_slices);
}

std::int32_t Partition::begin(int part) const {
  const std::int32_t each = num_slices_ / num_ranks_;
  const std::int32_t extra = num_slices_ % num_ranks_;
  return each * part + std::min<std::int32_t>(part, extra);
}

int Partition::part_of(std::int32_t item) const {
  NOISELOOM_CHECK(item >= 0 && item < num_slices_);
  const std::int32_t each = num_slices_ / num_ranks_;
  const std::int32_t extra = num_slices_ % num_ranks_;
  const std::int32_t long_part = (each + 1) * extra;
  return item < long_part ? item / (each + 1) : extra + (item - long_part) / each;
}

Distribution::Distribution(const Partition& partition, Rank rank) : partition_(partition), rank_(rank) {
  NOISELOOM_CHECK(ranks().contains(rank));
}

}  // namespace noiseloom
