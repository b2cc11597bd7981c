// A row of things, cut into parts: contiguous blocks. A plain value, computed without MPI.
#pragma once

#include "noiseloom/core/extents.h"

namespace noiseloom {

// The parts are those of ranks, or of the threads of one. The first num_slices % num_ranks of them have one slice more
// than the rest; where there are more parts than slices, the last ones have none. Requires num_ranks >= 1. What belongs
// to which rank is asked of a Distribution (core/distribution.h), which takes nothing for a rank that is none.
class Partition {
 public:
  Partition(std::int32_t num_slices, int num_ranks);

  std::int32_t num_slices() const { return num_slices_; }
  int num_ranks() const { return num_ranks_; }
  std::int32_t begin(int part) const;
  std::int32_t end(int part) const { return begin(part + 1); }
  std::int32_t count(int part) const { return end(part) - begin(part); }
  int part_of(std::int32_t item) const;

  std::int32_t begin(Rank rank) const { return begin(rank.value()); }
  std::int32_t end(Rank rank) const { return end(rank.value()); }
  std::int32_t count(Rank rank) const { return count(rank.value()); }

 private:
  std::int32_t num_slices_;
  int num_ranks_;
};

}  // namespace noiseloom
