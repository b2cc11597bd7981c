#include "noiseloom/anneal/tile_grid.h"

#include <algorithm>

#include "noiseloom/core/random.h"

namespace noiseloom {
namespace {

// What a second-level cache holds with all that a cell needs.
constexpr std::int64_t most_cells = 20'000;
constexpr std::int64_t wanted_units = 4;
// Cells that stay cost a little quality: at most about an eighth along each axis.
constexpr std::int64_t reaches_per_pitch = 8;
constexpr std::int64_t least_pitch = 32;

}  // namespace

bool TileGrid::Axis::can_split() const {
  return size / (count + 1) >= std::max(least_pitch, reaches_per_pitch * reach);
}

void TileGrid::Axis::split() {
  ++count;
  window = pitch() - reach;
}

std::int64_t TileGrid::Axis::begin(std::int64_t tile, std::uint32_t random) const {
  return count == 1 ? 0 : (to_below(random, static_cast<std::uint64_t>(size)) + tile * size / count) % size;
}

TileGrid::TileGrid(const Footprint& footprint)
    : x_{footprint.extents().width(), footprint.reach(0), 1, footprint.extents().width()},
      y_{footprint.extents().height(), footprint.reach(1), 1, footprint.extents().height()} {}

TileGrid::TileGrid(const Footprint& footprint, std::int64_t slices_at_once) : TileGrid(footprint) {
  while ((x_.pitch() * y_.pitch() > most_cells || slices_at_once * num_tiles() < wanted_units) && split()) {
  }
}

// The axis whose tiles are longer, y first: its rows stay whole.
bool TileGrid::split() {
  Axis& longer = y_.pitch() >= x_.pitch() ? y_ : x_;
  Axis& other = &longer == &y_ ? x_ : y_;
  Axis* const axis = longer.can_split() ? &longer : other.can_split() ? &other : nullptr;
  if (axis == nullptr) return false;
  axis->split();
  return true;
}

Corner TileGrid::corner(std::uint64_t seed, SliceIndex slice, std::uint32_t sweep, int tile) const {
  const RandomBlock bits = random_block(seed, Purpose::tile_shift, static_cast<std::uint32_t>(slice), sweep, 0);
  return {x_.begin(tile % x_.count, bits[0]), y_.begin(tile / x_.count, bits[1])};
}

}  // namespace noiseloom
