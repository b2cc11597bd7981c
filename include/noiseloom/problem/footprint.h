// The overlap F of the user's filter on the torus: what the energy and the score weigh pairs with.
//
//   product: F = prod_g F_g        sum: F = sum_g w_g F_g * [offset is zero on the axes not in g]
//   F_g(d) = sum_i f(i) f(i + d)   (gauss_energy: exp(-r^2 / 2 sigma^2) itself; ema: eq. 17)   [FAST24, section 3]
//
// Taps are folded onto the torus, so each offset occurs once; F is symmetric. On an axis that no group names, a product
// or sum couples offset zero only.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
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
  // Reads and checks table files (UserError). `cutoff` drops taps below cutoff * F(0).
  Footprint(const Extents& extents, const FilterSpec& filter, double cutoff = 0);

  const Extents& extents() const { return extents_; }
  // F(0), with what folding adds to it; not among the taps.
  double weight_zero() const { return weight_zero_; }
  // Sum of F over all offsets, zero included.
  double weight_sum() const { return weight_sum_; }
  // Taps by slice offset; element 0 is offset zero (possibly without taps), the rest ordered by offset. All weights
  // non-zero.
  std::span<const SliceTaps> slices() const { return slices_; }
  std::int64_t num_taps() const;
  bool couples_slices() const { return slices_.size() > 1; }
  // Largest |offset| with a tap, along x or y (axis 0 or 1) or a slice axis.
  std::int32_t reach(int axis) const;

  // Set where F(dx, dy, slice offset) = plane(dx, dy) * along(slice offset) for all offsets: `plane` includes (0, 0),
  // `along` includes offset zero. What the low-rank temporal background is built from.
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
  std::optional<Factors> factors_;
};

}  // namespace noiseloom
