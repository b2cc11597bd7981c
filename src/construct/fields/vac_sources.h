// Which slices act on a slice through a group that is over slice axes alone: a pixel that is turned on there adds the
// weight to the pixel of the same cell here.
#pragma once

#include <algorithm>
#include <cstdint>

#include "construct/fields/vac_kernel.h"
#include "construct/fields/vac_layout.h"

namespace noiseloom {

inline bool is_of_slices(const VacGroupKernel& group) { return group.axis0 >= 2; }
// Whether slices act on each other through such groups only.
inline bool acts_by_slices(const VacKernel& kernel) {
  return std::ranges::all_of(kernel.groups(),
                             [](const VacGroupKernel& group) { return group.stays_in_slice() || is_of_slices(group); });
}

// Calls visit(first, last, weights, middle) for the runs of slices [first, last] that act on slice `to`: slice s by
// weights[middle - s]. Requires is_of_slices(group).
template <class Visit>
void each_run_of_sources(const VacLayout& layout, const VacGroupKernel& group, std::int64_t to, const Visit& visit) {
  const auto a0 = static_cast<std::size_t>(group.axis0);
  const std::int64_t size0 = layout.size[a0];
  const std::int64_t step0 = layout.slice_step[a0];
  const std::int64_t at0 = to / step0 % size0;
  for (const VacRow& row : group.rows) {
    std::int64_t origin = to - at0 * step0;  // the slice at coordinate 0 of axis0
    bool inside = true;
    for (std::size_t i = 0; i < group.others.size() && inside; ++i) {
      const int axis = group.others[i];
      const auto a = static_cast<std::size_t>(axis);
      const std::int64_t at = to / layout.slice_step[a] % layout.size[a];
      std::int64_t from = at;
      inside = layout.move(from, axis, -row.offset[i]);
      origin += (from - at) * layout.slice_step[a];
    }
    if (!inside) continue;
    // Coordinates [first, last] of axis0 act by what they are away from `at`; `at` may lie beyond the axis, for those
    // that act around its end.
    const std::uint32_t* const weights = group.weights.data() + row.first + row.lo;  // [0]: of no distance
    const auto part = [&](std::int64_t first, std::int64_t last, std::int64_t at) {
      if (first > last) return;
      if (step0 == 1) {
        visit(origin + first, origin + last, weights, origin + at);
        return;
      }
      for (std::int64_t c = first; c <= last; ++c) {
        const std::int64_t slice = origin + c * step0;
        visit(slice, slice, weights, at - c + slice);
      }
    };
    const std::int64_t first = at0 - row.hi;
    const std::int64_t last = at0 + row.lo;
    part(std::max<std::int64_t>(first, 0), std::min(last, size0 - 1), at0);
    if (!layout.toroidal[a0]) continue;
    part(first + size0, size0 - 1, at0 + size0);
    part(0, last - size0, at0 - size0);
  }
}

}  // namespace noiseloom
