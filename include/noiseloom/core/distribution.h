// Which rank owns which slice, as one of the ranks sees it: contiguous blocks along the flattened slice axes. A plain
// value, the rank being an argument; computed without MPI.
//
// A slice has a number in the texture (global) and, for its owner, one among the owner's slices (local).
#pragma once

#include "noiseloom/core/partition.h"

namespace noiseloom {

class Distribution {
 public:
  // Of so many slices over so many ranks; with more ranks than slices the last ranks own none. Requires
  // rank < num_ranks.
  Distribution(std::int32_t num_slices, int num_ranks, Rank rank)
      : Distribution(Partition(num_slices, num_ranks), rank) {}
  Distribution(const Partition& partition, Rank rank);

  const Partition& partition() const { return partition_; }
  Rank rank() const { return rank_; }  // whose view this is
  std::int32_t num_slices() const { return partition_.num_slices(); }
  IndexRange<Rank> ranks() const { return first_indices<Rank>(partition_.num_ranks()); }

  Rank owner(SliceIndex slice) const { return Rank(partition_.part_of(slice.value())); }
  IndexRange<SliceIndex> slices_of(Rank rank) const {
    return {SliceIndex(partition_.begin(rank)), SliceIndex(partition_.end(rank))};
  }

  // Of the rank whose view this is.
  IndexRange<SliceIndex> own_slices() const { return slices_of(rank_); }
  std::int32_t num_own() const { return partition_.count(rank_); }
  bool owns(SliceIndex slice) const { return own_slices().contains(slice); }
  // Requires an own slice.
  LocalSlice local_slice_from_global(SliceIndex slice) const {
    return LocalSlice(slice.value() - partition_.begin(rank_));
  }
  SliceIndex global_slice_from_local(LocalSlice slice) const {
    return SliceIndex(partition_.begin(rank_) + slice.value());
  }

 private:
  Partition partition_;
  Rank rank_;
};

}  // namespace noiseloom
