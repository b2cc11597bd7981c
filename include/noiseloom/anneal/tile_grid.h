// How the visit of a slice is divided into tiles, rectangles that move at the same time.
//
// Tiles do not see each other: between any two lie at least as many cells as the footprint reaches, and these stay
// where they are. The grid is shifted at random from visit to visit, so that every cell moves nearly as often as every
// other. A tile is small enough for the caches, whatever the size of the slice, and a texture of few slices still gives
// work to several threads. A pure function of the problem, never of ranks or threads.
#pragma once

#include "noiseloom/anneal/slice_field.h"

namespace noiseloom {

class TileGrid {
 public:
  // One tile, the whole slice.
  explicit TileGrid(const Footprint& footprint);
  // slices_at_once: how many slices move together; more than a few need no tiles for the threads' sake.
  TileGrid(const Footprint& footprint, std::int64_t slices_at_once);

  int num_tiles() const { return static_cast<int>(x_.count * y_.count); }
  WindowSize window() const { return {x_.window, y_.window}; }
  Corner corner(std::uint64_t seed, SliceIndex slice, std::uint32_t sweep, int tile) const;

 private:
  struct Axis {
    std::int64_t size;
    std::int64_t reach;
    std::int64_t count;
    std::int64_t window;

    std::int64_t pitch() const { return size / count; }
    bool can_split() const;
    void split();
    std::int64_t begin(std::int64_t tile, std::uint32_t random) const;
  };
  bool split();

  Axis x_;
  Axis y_;
};

}  // namespace noiseloom
