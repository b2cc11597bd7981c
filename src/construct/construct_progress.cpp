// Which states of construction a run can have: what comes back from disk is held against it.
#include <vector>

#include "construct/course.h"
#include "noiseloom/construct/slice_construction.h"

namespace noiseloom {
namespace {

// Whether a run of slices of `cells` pixels can be there at all.
bool is_possible(const ConstructProgress& progress, std::int64_t cells) {
  const std::int64_t placed = progress.num_placed;
  const std::int64_t start = progress.num_start_points;
  if (placed < 0 || placed > cells || start < 0 || start > cells || progress.rounds < 0) return false;
  switch (progress.phase) {
    case ConstructPhase::spread:
      return start == cells / 2 && placed == 0;
    case ConstructPhase::relax:
      return placed == 0;
    case ConstructPhase::drain:
      return placed <= start;
    case ConstructPhase::fill:
      return placed >= start;
    case ConstructPhase::exchange:
      return start == cells / 2 && placed % 2 == 0;
    case ConstructPhase::done:
      return placed == cells;
  }
  return false;
}

}  // namespace

bool is_sound(const ConstructProgress& progress, std::span<const std::uint32_t> places) {
  if (!is_possible(progress, std::ssize(places))) return false;
  // The places that are given: first, ..., last - 1, and of an exchange those from half a turn on.
  std::int64_t first = 0;
  std::int64_t last = progress.num_placed;
  std::int64_t upper_first = 0;
  std::int64_t upper_last = 0;
  if (progress.phase == ConstructPhase::drain) {
    last = progress.num_start_points;
    first = last - progress.num_placed;
  } else if (progress.phase == ConstructPhase::exchange) {
    const Exchanged exchanged(progress);
    last = exchanged.off;
    upper_first = progress.num_start_points;
    upper_last = upper_first + exchanged.on;
  }
  // Which scale it is makes no difference to how many are on in a phase.
  std::int64_t on = Course(std::ssize(places), SampleScale::circle).num_on(progress);
  const auto is_given = [&](std::int64_t place) {
    return (place >= first && place < last) || (place >= upper_first && place < upper_last);
  };
  std::vector<bool> seen(places.size());
  std::int64_t found = 0;
  for (const std::uint32_t entry : places) {
    if (entry == pixel_is_on) --on;
    if (entry >= pixel_is_on) continue;
    if (!is_given(entry) || seen[entry]) return false;
    seen[entry] = true;
    ++found;
  }
  return on == 0 && found == last - first + upper_last - upper_first;
}

}  // namespace noiseloom
