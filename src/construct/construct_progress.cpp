// Which states of construction a run can have: what comes back from disk is held against it.
#include <vector>

#include "noiseloom/construct/slice_construction.h"

namespace noiseloom {
namespace {

// Whether a run of slices of `cells` pixels can be there at all.
bool is_possible(const ConstructProgress& progress, std::int64_t cells) {
  const std::int64_t placed = progress.num_placed;
  const std::int64_t start = progress.num_start_points;
  if (placed < 0 || placed > cells || start < 0 || start > cells || progress.rounds < 0) return false;
  switch (progress.phase) {
    case ConstructPhase::relax:
      return placed == 0;
    case ConstructPhase::drain:
      return placed <= start;
    case ConstructPhase::fill:
      return placed >= start;
    case ConstructPhase::done:
      return placed == cells;
  }
  return false;
}

}  // namespace

bool is_sound(const ConstructProgress& progress, std::span<const std::uint32_t> places) {
  if (!is_possible(progress, std::ssize(places))) return false;
  // The places that are given: first, ..., last - 1.
  std::int64_t first = 0;
  std::int64_t last = progress.num_placed;
  std::int64_t on = progress.phase == ConstructPhase::relax ? progress.num_start_points : 0;
  if (progress.phase == ConstructPhase::drain) {
    last = progress.num_start_points;
    first = on = last - progress.num_placed;
  }
  std::vector<bool> seen(places.size());
  std::int64_t found = 0;
  for (const std::uint32_t entry : places) {
    if (entry == pixel_is_on) --on;
    if (entry >= pixel_is_on) continue;
    if (std::int64_t{entry} < first || std::int64_t{entry} >= last || seen[entry]) return false;
    seen[entry] = true;
    ++found;
  }
  return on == 0 && found == last - first;
}

}  // namespace noiseloom
