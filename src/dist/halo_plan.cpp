#include "noiseloom/dist/halo_plan.h"

#include <algorithm>

namespace noiseloom {
namespace {

template <class T>
void sort_unique(std::vector<T>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

}  // namespace

HaloPlan::HaloPlan(const Extents& extents, std::span<const Extents::SliceCoord> offsets, const Partition& partition,
                   int rank)
    : begin_(partition.begin(rank)), listeners_(static_cast<std::size_t>(partition.count(rank))) {
  for (SliceIndex slice = begin_; slice < partition.end(rank); ++slice) {
    std::vector<int>& listeners = listeners_[static_cast<std::size_t>(slice - begin_)];
    for (const Extents::SliceCoord& offset : offsets) {
      const SliceIndex other = extents.slice_at(slice, offset);
      const int owner = partition.owner(other);
      if (owner == rank) continue;
      needed_.push_back(other);
      // Offsets are symmetric: whoever owns slice + d is coupled with slice through -d.
      listeners.push_back(owner);
    }
    sort_unique(listeners);
  }
  sort_unique(needed_);
}

std::int64_t HaloPlan::messages_per_sweep() const {
  std::int64_t count = 0;
  for (const std::vector<int>& listeners : listeners_) count += static_cast<std::int64_t>(listeners.size());
  return count;
}

}  // namespace noiseloom
