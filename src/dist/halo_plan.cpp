#include "noiseloom/dist/halo_plan.h"

#include <algorithm>

namespace noiseloom {
namespace {

// Offsets that follow each other along the first slice axis, so that the slices they lead to are neighbours in memory
// and mostly of one rank: a filter that is a thousand frames deep is one run.
struct Run {
  Extents::SliceCoord row;  // 0 along the first slice axis
  std::int64_t first;       // along it
  std::int64_t length;
};

std::vector<Run> runs_of(std::span<const Extents::SliceCoord> offsets) {
  std::vector<Extents::SliceCoord> sorted(offsets.begin(), offsets.end());
  std::sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) {
    return std::lexicographical_compare(a.rbegin(), a.rend(), b.rbegin(), b.rend());
  });
  std::vector<Run> runs;
  for (const Extents::SliceCoord& offset : sorted) {
    Extents::SliceCoord row = offset;
    row[0] = 0;
    if (runs.empty() || runs.back().row != row || runs.back().first + runs.back().length < offset[0]) {
      runs.push_back({row, offset[0], 1});
    } else {
      runs.back().length = offset[0] + 1 - runs.back().first;
    }
  }
  return runs;
}

// Calls visit(begin, end) for the slices that a run leads to from `slice`: a part of a row, or two where it goes around
// its end.
template <class Visit>
void visit_run(const Extents& extents, SliceIndex slice, const Run& run, const Visit& visit) {
  const std::int64_t size = extents.size(2);
  const std::int64_t t = slice.value() % size;
  const std::int64_t row = extents.slice_at(slice, run.row).value() - t;
  if (run.length >= size) return visit(row, row + size);
  const std::int64_t first = ((t + run.first) % size + size) % size;
  visit(row + first, row + std::min(size, first + run.length));
  if (first + run.length > size) visit(row, row + first + run.length - size);
}

}  // namespace

HaloPlan::HaloPlan(const Extents& extents, std::span<const Extents::SliceCoord> offsets,
                   const Distribution& distribution)
    : distribution_(distribution), listeners_(static_cast<std::size_t>(distribution.num_own())) {
  if (distribution.ranks().size() == 1 || extents.num_slices() == 1) return;
  const IndexRange<SliceIndex> own = distribution.own_slices();
  const std::vector<Run> runs = runs_of(offsets);
  // Of all slices: by how much the number of runs that cover it differs from that of the slice before.
  std::vector<std::int32_t> changes(static_cast<std::size_t>(extents.num_slices()) + 1, 0);
  for (const SliceIndex slice : own) {
    std::vector<Rank>& listeners = listeners_[distribution.local_slice_from_global(slice)];
    for (const Run& run : runs) {
      visit_run(extents, slice, run, [&](std::int64_t from, std::int64_t to) {
        if (from >= own.first().value() && to <= own.past_last().value()) return;
        ++changes[static_cast<std::size_t>(from)];
        --changes[static_cast<std::size_t>(to)];
        // Offsets are symmetric: whoever owns slice + d is coupled with slice through -d.
        const Rank last = distribution.owner(SliceIndex(to - 1));
        for (Rank owner = distribution.owner(SliceIndex(from)); owner <= last; ++owner) {
          if (owner != distribution.rank()) listeners.push_back(owner);
        }
      });
    }
    std::sort(listeners.begin(), listeners.end());
    listeners.erase(std::unique(listeners.begin(), listeners.end()), listeners.end());
  }
  std::int64_t covered = 0;
  for (const SliceIndex slice : extents.slices()) {
    covered += changes[static_cast<std::size_t>(slice)];
    if (covered > 0 && !own.contains(slice)) needed_.push_back(slice);
  }
}

std::int64_t HaloPlan::messages_per_sweep() const {
  std::int64_t count = 0;
  for (const std::vector<Rank>& listeners : listeners_) count += static_cast<std::int64_t>(listeners.size());
  return count;
}

}  // namespace noiseloom
