// Overlaps F_g of single groups on the torus, as lists of offsets: what problem/footprint.cpp combines.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "noiseloom/core/extents.h"
#include "noiseloom/problem/spec.h"

namespace noiseloom {

// Canonical on the torus, one entry per axis of the texture; zero on the axes that an overlap does not couple.
using Offset = std::array<std::int32_t, Extents::max_axes>;

struct OverlapTap {
  Offset offset;
  double weight;
};

// F over some axes: each offset once, never with weight zero, and F(d) and F(-d) the same bits.
struct Overlap {
  std::vector<int> axes;
  std::vector<OverlapTap> taps;
};

// The representative of `offset` in (-size/2, size/2].
std::int32_t canonical_offset(std::int64_t offset, std::int64_t size);

// The taps of a box, gauss or binomial filter along one axis, sum 1. A box longer than `size` comes folded onto it.
std::vector<double> filter_taps(const KernelSpec& kernel, std::int64_t size);

// The overlap along one axis, wrapped onto a ring of `size`, is given by its values for d = 0, 1, ..., size / 2 at
// most: F(-d) is F(d), and what lies past the end of the list is zero. So its length is that of the filter, and a long
// axis costs nothing.

// sum_i f(i) f(i + d) for d = 0 .. taps.size() - 1, each sum in ascending order of i. Takes time in proportion to the
// square of the number of taps, except where all taps are equal.
std::vector<double> autocorrelation(std::span<const double> taps);
// The same for the filter `taps` wrapped onto a ring.
std::vector<double> ring_overlap(std::span<const double> taps, std::int64_t size);
// Eq. 17 of [FAST24], summed to infinity and wrapped onto a ring of `size` (footprint.h says how it is read).
std::vector<double> ema_ring_overlap(double alpha, double beta, std::int64_t size);

// A filter given as a full array over several axes. `sizes`: taps per axis, of the same length as `axes`; axes[0]
// varies fastest in `taps`.
Overlap array_overlap(const Extents& extents, const std::vector<int>& axes, const std::vector<std::int64_t>& sizes,
                      std::span<const double> taps);

// The overlaps whose product is F_g: one per axis where the kernel is separable, else one over all axes of the group.
// Throws UserError for a table that cannot be used.
std::vector<Overlap> group_overlaps(const Extents& extents, const GroupSpec& group);
// The same for a table: footprint_table.cpp.
std::vector<Overlap> table_overlaps(const Extents& extents, const GroupSpec& group);

// An overlap along one axis from its values on the ring (1 to size / 2 + 1 of them).
Overlap axis_overlap(const Extents& extents, int axis, std::span<const double> ring);

// Sorted (the same slice first, then by the coordinates from the last axis down to x), taps of equal offset added up in
// the order in which they came, zeros left out.
std::vector<OverlapTap> ordered(std::vector<OverlapTap> taps);

// Pointwise product. On an axis that both name, offsets must agree.
Overlap multiply(const Overlap& a, const Overlap& b);

}  // namespace noiseloom
