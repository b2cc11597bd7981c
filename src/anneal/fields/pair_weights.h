// F between two cells of one slice, as a table over (dx, dy) within the reach.
#pragma once

#include <cstdint>
#include <vector>

#include "noiseloom/anneal/slice_field.h"

namespace noiseloom {

// The representative of an offset |d| < size that is nearest to zero; d itself where the axis does not wrap.
inline std::int64_t nearest_offset(std::int64_t d, std::int64_t size, bool wraps) {
  return !wraps ? d : 2 * d > size ? d - size : 2 * d < -size ? d + size : d;
}

// Element (dy + reach_y) * (2 reach_x + 1) + dx + reach_x. Where half a period lies within the reach, both of its signs
// are filled.
template <class Real>
std::vector<Real> pair_weight_table(const Footprint& footprint, const FieldLayout& layout) {
  const auto images = [](std::int64_t d, std::int64_t size, std::int64_t reach) {
    std::vector<std::int64_t> found;
    for (const std::int64_t image : {d - size, d, d + size}) {
      if (image >= -reach && image <= reach) found.push_back(image);
    }
    return found;
  };
  const std::int64_t table_width = 2 * layout.reach_x + 1;
  std::vector<Real> table(static_cast<std::size_t>(table_width * (2 * layout.reach_y + 1)));
  for (const PlaneTap& tap : footprint.slices()[0].taps) {
    for (const std::int64_t dx : images(tap.dx, footprint.extents().width(), layout.reach_x)) {
      for (const std::int64_t dy : images(tap.dy, footprint.extents().height(), layout.reach_y)) {
        table[static_cast<std::size_t>((dy + layout.reach_y) * table_width + dx + layout.reach_x)] =
            static_cast<Real>(tap.weight);
      }
    }
  }
  return table;
}

}  // namespace noiseloom
