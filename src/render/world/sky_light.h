// Light from all sides above the plane: a sky of so many directions, each with its radiance.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "noiseloom/render/scene.h"
#include "render/world/kernel.h"
#include "render/world/surface.h"

namespace noiseloom::render {

// The upper half of an equirectangular image, y up, in so many columns of cells and a quarter as many rows, or as many
// as the image has texels: column b and row a look along (sin a cos b, cos a, sin a sin b). Radiance is scaled so that
// an open plane is of the brightness 0.8.
//
// A sky that turns does so by whole cells, each of which is then where another one was: what a pixel sees of each is
// the same in all frames.

struct SkyLight {
  MassTable cells;                           // by their brightness times their solid angle
  int fine_width = 1;                        // of the image: its texels are those of cells, not what cuts these
  int fine_height = 1;                       // the rows of it that reach above the horizon
  int image_height = 2;                      // of all of it
  std::vector<Vector> directions;            // [row][column], of the middles of cells
  std::vector<std::array<double, 3>> light;  // radiance times solid angle over pi
  std::vector<double> solid_angles;

  std::size_t index(Texel cell) const {
    return static_cast<std::size_t>(cell.y) * static_cast<std::size_t>(cells.width()) +
           static_cast<std::size_t>(cell.x);
  }
  Texel cell_of(Vector direction) const;
  // Where the cell is when the sky has turned by so many columns, of any sign; and which cell is there then.
  Texel turned(Texel cell, std::int64_t columns) const;
};

// No more than so many: an image may have fewer.
std::int64_t most_columns(const SkySpec& spec);
std::int64_t most_cells(const SkySpec& spec);

SkyLight make_sky(const SkySpec& spec);

// Throws UserError unless the directions that a texture holds may have been drawn by the brightness of this sky: each
// cell has its share of them, within what chance makes of independent ones.
void check_directions(const Noise& noise, const SkyLight& sky);

}  // namespace noiseloom::render
