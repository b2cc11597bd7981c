// What tiles promise, cell by cell.
#pragma once

#include <vector>

#include "noiseloom/problem/footprint.h"

namespace noiseloom::test {

// Whether a cell of one tile has a tap in another, of a single slice; `tile_of` of cells that stand still: -1.
bool a_tap_joins_two_tiles(const Footprint& footprint, const std::vector<int>& tile_of);

}  // namespace noiseloom::test
