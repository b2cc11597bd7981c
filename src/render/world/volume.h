// Volumes: a density in the unit cube, the light that reaches its places, and both along the rays of all pixels. The
// camera looks along z, so that a ray is a column, and what it meets is the same in every frame.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "noiseloom/core/parallel.h"
#include "noiseloom/render/scene.h"

namespace noiseloom::render {

// Values at the corners of cells, [z][y][x], over the unit cube.
struct Grid {
  int size = 0;  // along each axis, at least 2
  std::vector<float> values;

  float at(int x, int y, int z) const {
    const auto n = static_cast<std::size_t>(size);
    return values[(static_cast<std::size_t>(z) * n + static_cast<std::size_t>(y)) * n + static_cast<std::size_t>(x)];
  }
};

// The density, by which light is extinguished over a unit of length: from 0 to spec.extinction.
Grid make_density(const VolumeSpec& spec);
// What the sun, straight above, and the sky give a place that scatters: 0 to 1.
Grid make_light(const VolumeSpec& spec, const Grid& density);

// Density and light at `nodes` places of equal distance along the ray of each pixel, from z = 0 to 1; linear between.
struct Node {
  float density = 0;
  float light = 0;
};
struct Columns {
  int nodes = 0;
  std::vector<Node> values;  // [pixel][node]
};
Columns make_columns(const Grid& density, const Grid& light, int width, int height, ThreadPool& pool);

// For free flights through `steps` steps of equal length: the share of light that is scattered before the end of each,
// 1 - exp(-optical depth), and the light in its middle.
struct Flights {
  int steps = 0;
  std::vector<float> scattered;  // [pixel][step]
  std::vector<float> light;
};
Flights make_flights(const Columns& columns, int steps);

// What is between the nodes of a column, at 0 <= z <= 1.
inline Node along(const Node* column, int nodes, float z) {
  const float place = z * static_cast<float>(nodes - 1);
  const int node = std::min(static_cast<int>(place), nodes - 2);
  const float part = place - static_cast<float>(node);
  const Node a = column[node];
  const Node b = column[node + 1];
  return {a.density + part * (b.density - a.density), a.light + part * (b.light - a.light)};
}

// exp(-x), x >= 0, to a relative error of 4e-7 and the same bits everywhere; exp(0) = 1.
inline float exp_minus(float x) {
  if (!(x < 87)) return x != x ? x : 0;
  // 2^-k e^-r with |r| <= ln 2 / 2.
  const auto whole = static_cast<std::int32_t>(x * 0x1.715476p+0F + 0.5F);
  const auto k = static_cast<float>(whole);
  const float r = (k * 0x1.62e4p-1F - x) + k * 0x1.7f7d1cp-20F;
  float tail = 1.0F / 5040;
  tail = tail * r + 1.0F / 720;
  tail = tail * r + 1.0F / 120;
  tail = tail * r + 1.0F / 24;
  tail = tail * r + 1.0F / 6;
  tail = tail * r + 0.5F;
  const float value = 1 + (r + r * r * tail);
  return value * std::bit_cast<float>(static_cast<std::uint32_t>(127 - whole) << 23);
}

// The light behind the volume.
double background(int y, int height);

}  // namespace noiseloom::render
