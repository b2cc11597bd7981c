// The overlap F of the user's filter on the torus: what the energy and the score weigh pairs with.
//
//   product: F = prod_g F_g        sum: F = sum_g w_g F_g * [offset is zero on the axes not in g]
//   F_g(d) = sum_i f(i) f(i + d)                                                              [FAST24, section 3]
//
// Taps are folded onto the torus, so each offset occurs once; F(d) and F(-d) are the same bits. On an axis that no
// group names, a product or sum couples offset zero only. All filters have unit sum, except tables (taken as they are)
// and gauss_energy:
//
//   box, gauss, binomial   along each axis of the group. gauss: the Gaussian integrated over each pixel, taps added
//                          outward from the centre until their sum reaches 0.995, then normalised.
//   ema                    along each axis of the group [FAST24, eq. 14-17]:
//                            F(d) = sum_{m >= 1} beta (1 - beta)^(m-1) sum_k f^(m)(k) f^(m)(k + d)
//                          i.e. eq. 17 with the history m frames long, m = 1 being the current frame alone: f^(0) is
//                          no filter at all, so the sum starts at 1 and its weights are scaled to add up to one
//                          (R does not depend on that scale). It runs to infinity, wrapped on the torus, where the
//                          paper stops at the length n of the texture: F then has unit sum for every n, tends to
//                          eq. 15 for beta -> 0 and exists for n = 1. The published 64-slice texture has R = 0.08399
//                          under this reading and 0.08400 under the other; sum(F) / F(0) for alpha = beta = 0.1,
//                          n = 32 is 2.485 (62.1 with box 5) against 2.403. beta = 0 is eq. 15.
//   table                  a .npy file: one dimension, the taps along each axis of the group; or as many dimensions as
//                          the group has axes, in file order (the last dimension is the first of these axes in the
//                          texture: [t, y, x] for axes x, y, t, however the group lists them). Any finite taps, not
//                          all zero, nor cancelling each other where they are folded onto a shorter axis.
//   gauss_energy           F_g(d) = exp(-r^2 / 2 sigma^2) itself, r over all axes of the group, images on the torus
//                          added up; left out where that is below 1e-6. F_g(0) = 1 on a wide torus.  [STBN22, eq. 4]
//                          Along its box axes times the overlap of a box over that at 0, folded: (n - |d|) / n for
//                          n = box_size, and 1 everywhere where the box is as long as the axis. Along tile axes there
//                          is no filter: R is that of each tile repeated. Tails are not counted.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "noiseloom/core/extents.h"
#include "noiseloom/problem/spec.h"

namespace noiseloom {

// dx, dy in (-size/2, size/2]: the canonical representative on the torus.
struct PlaneTap {
  std::int32_t dx;
  std::int32_t dy;
  double weight;
};

// All taps that lead from a slice to the slice at `offset` (canonical, along the slice axes).
struct SliceTaps {
  Extents::SliceCoord offset;
  std::vector<PlaneTap> taps;  // ordered by (dy, dx)
};

class Footprint {
 public:
  // Reads and checks table files (UserError). `cutoff` drops taps below cutoff * F(0), of a sum those of each group
  // below cutoff times the group's own F(0), so that a group of little weight counts as it should. Weights of a sum
  // that are all zero stand for equal ones.
  Footprint(const Extents& extents, const FilterSpec& filter, double cutoff = 0);

  const Extents& extents() const { return extents_; }
  // F(0), with what folding adds to it; not among the taps.
  double weight_zero() const { return weight_zero_; }
  // Sum of F over all offsets that are kept, zero included.
  double weight_sum() const { return weight_sum_; }
  // Taps by slice offset; element 0 is offset zero (possibly without taps), the rest ordered by their coordinates, the
  // last axis counting most. All weights non-zero.
  std::span<const SliceTaps> slices() const { return slices_; }
  std::int64_t num_taps() const { return num_taps_; }
  bool couples_slices() const { return slices_.size() > 1; }
  // Largest |offset| with a tap, those included that the cutoff drops, along x or y (axis 0 or 1) or a slice axis:
  // fields that are laid out for the energy serve R, too.
  std::int32_t reach(int axis) const { return reach_[static_cast<std::size_t>(axis)]; }

  // Set where F(dx, dy, slice offset) = plane(dx, dy) * along(slice offset) for all offsets: `plane` includes (0, 0),
  // `along` has offset zero first. Of a product before the cutoff, as a cut one is none. Always set where no two
  // slices are coupled. What the low-rank temporal background is built from.
  struct Factors {
    std::vector<PlaneTap> plane;
    std::vector<std::pair<Extents::SliceCoord, double>> along;
  };
  const std::optional<Factors>& factors() const { return factors_; }

 private:
  Extents extents_;
  double weight_zero_ = 0;
  double weight_sum_ = 0;
  std::vector<SliceTaps> slices_;
  std::int64_t num_taps_ = 0;
  std::array<std::int32_t, Extents::max_axes> reach_{};
  std::optional<Factors> factors_;
};

}  // namespace noiseloom
