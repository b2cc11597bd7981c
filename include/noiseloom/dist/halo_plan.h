// Which slices a rank must hear of, and who must hear of its own. Pure: a function of (extents, coupling offsets,
// distribution), the same on every rank, computed once and replayed at every exchange.
#pragma once

#include <span>
#include <vector>

#include "noiseloom/core/distribution.h"
#include "noiseloom/core/extents.h"

namespace noiseloom {

class HaloPlan {
 public:
  // For the rank of the distribution. `offsets`: the slice offsets that couple, symmetric (with d also -d); offset zero
  // is ignored. Footprints deeper than a rank's own slices reach several neighbours; a rank without slices needs and
  // tells nothing.
  HaloPlan(const Extents& extents, std::span<const Extents::SliceCoord> offsets, const Distribution& distribution);

  // Slices of other ranks that the own ones are coupled with, ascending.
  const std::vector<SliceIndex>& needed() const { return needed_; }
  // Ranks other than this one that need an own slice, ascending. Requires that the slice is own.
  const std::vector<Rank>& listeners(SliceIndex slice) const {
    return listeners_[distribution_.local_slice_from_global(slice)];
  }
  // Number of (own slice, listener) pairs: messages that one sweep sends.
  std::int64_t messages_per_sweep() const;

 private:
  Distribution distribution_;
  std::vector<SliceIndex> needed_;
  IndexedVector<LocalSlice, std::vector<Rank>> listeners_;
};

}  // namespace noiseloom
