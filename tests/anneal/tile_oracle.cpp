#include "anneal/tile_oracle.h"

#include <cstddef>
#include <cstdint>

namespace noiseloom::test {

bool a_tap_joins_two_tiles(const Footprint& footprint, const std::vector<int>& tile_of) {
  const std::int64_t width = footprint.extents().width();
  const std::int64_t height = footprint.extents().height();
  for (std::int64_t cell = 0; cell < width * height; ++cell) {
    const int own = tile_of[static_cast<std::size_t>(cell)];
    for (const PlaneTap& tap : footprint.slices()[0].taps) {
      const std::int64_t x = (cell % width + tap.dx + width) % width;
      const std::int64_t y = (cell / width + tap.dy + height) % height;
      const int other = tile_of[static_cast<std::size_t>(y * width + x)];
      if (own != other && own >= 0 && other >= 0) return true;
    }
  }
  return false;
}

}  // namespace noiseloom::test
