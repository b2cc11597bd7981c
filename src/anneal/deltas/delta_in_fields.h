// A swap delta in float, but for the distance of two samples: its fields, its background and its sieve.
#pragma once

#include <optional>

#include "anneal/deltas/background.h"
#include "anneal/deltas/delta_fields.h"
#include "anneal/deltas/sieve.h"
#include "noiseloom/anneal/swap_delta.h"

namespace noiseloom {

class DeltaInFields : public SwapDelta {
 public:
  const FieldLayout& layout() const final { return fields_.layout(); }
  void bind(SliceIndex slice, Corner corner, const SliceField& own, const FieldOf& others) final;
  void swap(CellPair pair) final;
  void prefetch(std::span<const CellPair> pairs) const final;
  bool has_estimates() const final { return sieve_.has_value(); }
  void estimate(std::span<const CellPair> pairs, double* out) const final;
  void prefetch_estimates(std::span<const CellPair> pairs) const final;

 protected:
  // between_slices, sieve: may be null, see make_swap_delta().
  DeltaInFields(const Footprint& footprint, int channels, WindowSize window, const FeatureMap* between_slices,
                const FeatureMap* sieve);

  // What sums over the taps hold of the two samples themselves: K(a, a) + K(b, b) - 2 K(a, b).
  virtual float pair_term(const DeltaFields::Position& at_i, const DeltaFields::Position& at_j) const = 0;

  DeltaFields fields_;
  std::optional<Background> background_;

 private:
  std::optional<Sieve> sieve_;
};

}  // namespace noiseloom
