// The slow twins of the problem layer: overlaps by brute force on the infinite lattice, energies and scores by double
// loops over all pairs of cells, in double or better, with the C library's functions. For small textures.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "noiseloom/core/extents.h"
#include "noiseloom/problem/footprint.h"
#include "noiseloom/problem/spec.h"

namespace noiseloom::oracle {

using Coord = std::array<std::int64_t, Extents::max_axes>;  // one entry per axis; zero beyond the last

Coord coord_of(const Extents& extents, std::int64_t flat);
// The position of a coordinate, wrapped, among all cells (x fastest).
std::size_t flat_of(const Extents& extents, const Coord& coord);
Coord difference(const Coord& a, const Coord& b);

// F at every offset of the torus, by the position of the offset among all cells.
using Overlaps = std::vector<double>;
Overlaps overlaps(const Extents& extents, const FilterSpec& filter);
// The same table from a footprint.
Overlaps overlaps(const Footprint& footprint);

// A small texture of random samples of a space, planar like everywhere: [slice][channel][y][x].
struct Texture {
  Extents extents;
  int channels = 1;
  DistanceKind distance = DistanceKind::absolute;
  std::vector<float> values;

  std::size_t slice_size() const { return static_cast<std::size_t>(extents.cells_per_slice() * channels); }
  const float* slice(SliceIndex s) const { return values.data() + static_cast<std::size_t>(s) * slice_size(); }
  std::vector<float> list(SliceIndex s) const;         // interleaved
  std::vector<double> sample(std::size_t cell) const;  // cell among all cells
  void swap(std::size_t a, std::size_t b);
};

// Uniform in [0, 1)^channels; between unit vectors: uniform directions.
Texture random_texture(const Extents& extents, DistanceKind distance, int channels, std::uint64_t seed);

// Of all pairs, those of a sample and itself too.
double mean_over_all_pairs(const Texture& texture);
// The same of points on a line, by sorting them.
double mean_distance_on_a_line(std::vector<double> points);

// sum_{j in slice, k != j} F(j - k) d(s_j, s_k) of every slice.
std::vector<double> distance_sums(const Overlaps& f, const Texture& texture);

// E = sum_{j != k} F(j - k) K(s_j, s_k)
double energy(const Overlaps& f, const Texture& texture, const ValueKernelSpec& spec);

// E after the samples of cells a and b have changed places, minus E before: the pairs with a or b, both ways round.
double swap_delta(const Overlaps& f, const Texture& texture, const ValueKernelSpec& spec, std::size_t a, std::size_t b);

// R by its definition: every m_d from all pairs d apart, m from all pairs.
double relative_error(const Overlaps& f, const Texture& texture);

}  // namespace noiseloom::oracle
