// Who owns which slice: contiguous blocks along the flattened slice axes. A plain value, computed without MPI.
#pragma once

#include "noiseloom/core/extents.h"

namespace noiseloom {

// The first num_slices % num_ranks ranks own one slice more than the rest; with more ranks than slices the last ranks
// own none. Requires num_ranks >= 1.
class Partition {
 public:
  Partition(SliceIndex num_slices, int num_ranks);

  SliceIndex num_slices() const { return num_slices_; }
  int num_ranks() const { return num_ranks_; }
  SliceIndex begin(int rank) const;
  SliceIndex end(int rank) const { return begin(rank + 1); }
  SliceIndex count(int rank) const { return end(rank) - begin(rank); }
  int owner(SliceIndex slice) const;

 private:
  SliceIndex num_slices_;
  int num_ranks_;
};

}  // namespace noiseloom
