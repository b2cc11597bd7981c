// A texture of one slice is divided among threads as bands of rows.
#pragma once

#include <algorithm>

#include "construct/order/vac_kernel.h"
#include "construct/order/vac_layout.h"

namespace noiseloom {

// How many bands; 1 where the slice is not divided: a group is not over x and y alone, or bands would be hardly wider
// than footprints, or the batches of a small slice are sooner carried out than shared out.
inline int num_bands(const VacLayout& layout, const VacKernel& kernel, int num_threads) {
  constexpr std::int64_t fewest_cells = std::int64_t{1} << 17;
  if (layout.num_slices != 1 || layout.cells < fewest_cells) return 1;
  std::int64_t most = num_threads;
  for (const VacGroupKernel& group : kernel.groups()) {
    if (!group.is_of_plane()) return 1;
    most = std::min(most, layout.size[1] / (8 * (group.reach_y + std::int64_t{1})));
  }
  return static_cast<int>(std::max<std::int64_t>(most, 1));
}

}  // namespace noiseloom
