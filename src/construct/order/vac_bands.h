// A texture of one slice is divided among threads as bands of rows.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "construct/order/vac_kernel.h"
#include "construct/order/vac_layout.h"
#include "noiseloom/core/partition.h"

namespace noiseloom {

// The first row of each band, and then the number of rows: one band, of all of them, where the slice is not divided, as
// a group is not over x and y alone, or bands would be hardly wider than footprints, or the batches of a small slice
// are sooner carried out than shared out.
inline std::vector<std::int32_t> band_rows(const VacLayout& layout, const VacKernel& kernel, int num_threads) {
  constexpr std::int64_t fewest_cells = std::int64_t{1} << 17;
  std::int64_t most = layout.num_slices == 1 && layout.cells >= fewest_cells ? num_threads : 1;
  for (const VacGroupKernel& group : kernel.groups()) {
    if (!group.is_of_plane()) most = 1;
    most = std::min(most, layout.size[1] / (8 * (group.reach_y + std::int64_t{1})));
  }
  const Partition split(narrow<std::int32_t>(layout.size[1]), static_cast<int>(std::max<std::int64_t>(most, 1)));
  std::vector<std::int32_t> rows;
  for (int band = 0; band <= split.num_ranks(); ++band) rows.push_back(split.begin(band));
  return rows;
}

}  // namespace noiseloom
