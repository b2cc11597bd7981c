// The change of the energy when two samples of a slice change places.
//
//   E = sum over ordered pairs j != k of F(j - k) K(s_j, s_k)
//   dE = 2 sum_{k != i, j} (F(i - k) - F(j - k)) (K(s_j, s_k) - K(s_i, s_k))          [FAST24, eq. 8, for any K]
//
// for the samples a = s_i and b = s_j that change places, evaluated as two sums over the footprint, centred at i and at
// j, less the term of the pair itself:
//
//   dE / 2 = sum_d F(d) (K(b, s_{i+d}) - K(a, s_{i+d}))  +  sum_d F(d) (K(a, s_{j+d}) - K(b, s_{j+d}))
//            - F(i - j) (K(a, a) + K(b, b) - 2 K(a, b))
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "noiseloom/anneal/feature_map.h"
#include "noiseloom/anneal/slice_field.h"
#include "noiseloom/anneal/spec.h"
#include "noiseloom/problem/footprint.h"
#include "noiseloom/problem/value_kernel.h"

namespace noiseloom {

// The field of another slice of the texture, by index. Must stay valid and unchanged while a SwapDelta is bound.
using FieldOf = std::function<const SliceField&(SliceIndex)>;

struct CellPair {
  std::uint32_t i;
  std::uint32_t j;
};

// Evaluates one window of a slice at a time; one object per thread. Cells are those of the window, row after row.
class SwapDelta {
 public:
  virtual ~SwapDelta() = default;
  virtual const FieldLayout& layout() const = 0;  // of the window
  // Copies the window at `corner` of the slice whose samples move, and takes a view of the slices around it.
  virtual void bind(SliceIndex slice, Corner corner, const SliceField& own, const FieldOf& others) = 0;
  void bind(SliceIndex slice, const SliceField& own, const FieldOf& others) { bind(slice, {}, own, others); }
  // dE for swapping the samples of two cells. Where i = j: any finite number.
  virtual double delta(CellPair pair) const = 0;
  // Says that delta() of these will be asked for soon.
  virtual void prefetch(std::span<const CellPair> /*pairs*/) const {}
  // Whether dE can be estimated in less time than delta() takes.
  virtual bool has_estimates() const { return false; }
  // Estimates of dE, one for each pair, of which there are at most most_estimates. Requires has_estimates().
  virtual void estimate(std::span<const CellPair> /*pairs*/, double* /*out*/) const {}
  static constexpr std::size_t most_estimates = 16;
  // Says that estimate() of these will be asked for soon.
  virtual void prefetch_estimates(std::span<const CellPair> /*pairs*/) const {}
  // Carries the swap out in the copy.
  virtual void swap(CellPair pair) = 0;
};

// float64: from the definitions. float32: vectorised; the same bits on every machine. It resolves angles between
// directions to 4e-7, save within 1e-3 of the antipode.
// between_slices: where given, slices other than the moving one act through these features (float64 takes all taps all
// the same; requires footprint.factors()); otherwise through all their taps. window: the whole slice if not given.
// sieve: the features that estimates are made with; without them, or in double, there are none. Requires
// Sieve::serves(footprint), which swap_choices.h knows of.
// Footprint and maps must outlive the object.
std::unique_ptr<SwapDelta> make_swap_delta(const Footprint& footprint, const ValueKernel& kernel, Precision precision,
                                           const FeatureMap* between_slices = nullptr,
                                           std::optional<WindowSize> window = std::nullopt,
                                           const FeatureMap* sieve = nullptr);

}  // namespace noiseloom
