// The swap delta in float, vectorised for each instruction set; which one runs is found at run time.
#include "anneal/deltas/swap_delta_float.h"

#include <optional>

#include "anneal/deltas/background.h"
#include "anneal/deltas/delta_fields.h"
#include "anneal/deltas/sieve.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "anneal/deltas/swap_delta_float.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "anneal/deltas/swap_term-inl.h"

HWY_BEFORE_NAMESPACE();
namespace noiseloom::HWY_NAMESPACE {

template <DistanceKind kind, ValueKernelKind value_kind, int C>
class FloatDelta final : public SwapDelta {
 public:
  FloatDelta(const Footprint& footprint, const ValueKernel& kernel, WindowSize window, const FeatureMap* between_slices,
             const FeatureMap* sieve)
      : fields_(footprint, C, window, between_slices == nullptr), pair_cost_(kernel) {
    if (between_slices != nullptr) background_.emplace(footprint, *between_slices, window);
    if (sieve != nullptr) sieve_.emplace(footprint, *sieve, window);
  }

  const FieldLayout& layout() const override { return fields_.layout(); }

  void bind(SliceIndex slice, Corner corner, const SliceField& own, const FieldOf& others) override {
    fields_.bind(slice, corner, own, others);
    if (background_) background_->bind(slice, corner, fields_.own(), others);
    if (sieve_) sieve_->bind(slice, corner, fields_.own(), others);
  }
  void swap(CellPair pair) override {
    fields_.swap(pair.i, pair.j);
    if (background_) background_->swap(pair);
    if (sieve_) sieve_->swap(pair);
  }

  // What lies in the nearer caches without that, planes of samples, is not worth the instructions.
  void prefetch(std::span<const CellPair> pairs) const override {
    for (const CellPair pair : pairs) {
      for (const std::uint32_t cell : {pair.i, pair.j}) {
        fields_.prefetch_stack(cell);
        if (background_) prefetch_floats(background_->at(cell), 2 * background_->num_lanes());
      }
    }
  }

  bool has_estimates() const override { return sieve_.has_value(); }

  void prefetch_estimates(std::span<const CellPair> pairs) const override {
    for (const CellPair pair : pairs) {
      for (const std::uint32_t cell : {pair.i, pair.j}) {
        prefetch_floats(sieve_->features(cell), sieve_->num_lanes());
        prefetch_floats(sieve_->pulls(cell), sieve_->num_lanes());
      }
    }
  }

  void estimate(std::span<const CellPair> pairs, double* out) const override {
    float sums[most_estimates];
    sieve_->estimate(pairs, sums);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      out[k] = 2 * static_cast<double>(sums[k]);
      if (!fields_.may_be_near(pairs[k].i, pairs[k].j)) continue;
      const DeltaFields::Position at_i = fields_.position(pairs[k].i);
      const DeltaFields::Position at_j = fields_.position(pairs[k].j);
      if (const float weight = fields_.pair_weight(at_i, at_j); weight != 0) {
        float a[C];
        float b[C];
        load(at_i, a);
        load(at_j, b);
        out[k] = 2 * static_cast<double>(sums[k] - weight * pair_term(a, b));
      }
    }
  }

  double delta(CellPair pair) const override {
    const DeltaFields::Position at_i = fields_.position(pair.i);
    const DeltaFields::Position at_j = fields_.position(pair.j);
    float a[C];
    float b[C];
    load(at_i, a);
    load(at_j, b);
    const SwapTerm<kind, value_kind, C> swap_term(pair_cost_, a, b);
    V sums[num_parts];
    for (V& sum : sums) sum = hn::Zero(Floats());
    for (const DeltaFields::Part& part : fields_.parts()) {
      add(swap_term, *part.taps, part.samples + at_i.in[part.kind], part.samples + at_j.in[part.kind], part.plane_size,
          sums);
    }
    if (background_) add_background(pair, swap_term.unit(), sums);
    float sum = swap_term.scaled(fold(sums));
    if (const float weight = fields_.pair_weight(at_i, at_j); weight != 0) sum -= weight * pair_term(a, b);
    return 2 * static_cast<double>(sum);
  }

 private:
  HWY_INLINE void load(const DeltaFields::Position& at, float (&sample)[C]) const {
    for (int c = 0; c < C; ++c) sample[c] = fields_.own().plane(c)[at.in[DeltaFields::rows]];
  }

  HWY_INLINE void add(const SwapTerm<kind, value_kind, C>& swap_term, const TapBlocks& taps, const float* at_i,
                      const float* at_j, std::int64_t plane_size, V (&sums)[num_parts]) const {
    V i[C];
    V j[C];
    for (std::size_t k = 0; k < taps.full.size(); ++k) {
      const float* from_i = at_i + taps.full[k];
      const float* from_j = at_j + taps.full[k];
      for (std::size_t p = 0; p < num_parts; ++p) {
        for (int c = 0; c < C; ++c) {
          i[c] = load_full(from_i + c * plane_size, p);
          j[c] = load_full(from_j + c * plane_size, p);
        }
        const V weight = load_full(taps.full_weights[k].lane, p);
        sums[p] = hn::Add(sums[p], hn::Mul(weight, swap_term.term(i, j)));
      }
    }
    for (std::size_t k = 0; k < taps.split.size(); ++k) {
      const auto [low, high] = taps.split[k];
      for (std::size_t p = 0; p < num_parts; ++p) {
        for (int c = 0; c < C; ++c) {
          i[c] = load_split(at_i + low + c * plane_size, at_i + high + c * plane_size, p);
          j[c] = load_split(at_j + low + c * plane_size, at_j + high + c * plane_size, p);
        }
        const V weight = load_full(taps.split_weights[k].lane, p);
        sums[p] = hn::Add(sums[p], hn::Mul(weight, swap_term.term(i, j)));
      }
    }
  }

  HWY_INLINE void add_background(CellPair pair, float unit, V (&sums)[num_parts]) const {
    const auto lanes = static_cast<std::size_t>(background_->num_lanes());
    const float* i = background_->at(pair.i);
    const float* j = background_->at(pair.j);
    for (std::size_t n = 0; n < lanes; n += block_lanes) {
      for (std::size_t p = 0; p < num_parts; ++p) {
        const V features = hn::Sub(load_full(j + n, p), load_full(i + n, p));
        const V pulls = hn::Sub(load_full(i + lanes + n, p), load_full(j + lanes + n, p));
        sums[p] = hn::Add(sums[p], hn::Mul(set(unit), hn::Mul(features, pulls)));
      }
    }
  }

  // What the sums hold of i and j themselves: K(a, a) + K(b, b) - 2 K(a, b).
  HWY_NOINLINE float pair_term(const float (&a)[C], const float (&b)[C]) const {
    V va[C];
    V vb[C];
    for (int c = 0; c < C; ++c) {
      va[c] = set(a[c]);
      vb[c] = set(b[c]);
    }
    const float ab = hn::GetLane(pair_cost_(va, vb));
    return 2 * ab - hn::GetLane(pair_cost_(va, va)) - hn::GetLane(pair_cost_(vb, vb));
  }

  DeltaFields fields_;
  std::optional<Background> background_;
  std::optional<Sieve> sieve_;
  PairCost<kind, value_kind, C> pair_cost_;
};

template <DistanceKind kind, int C>
std::unique_ptr<SwapDelta> with_value_kind(const Footprint& footprint, const ValueKernel& kernel, WindowSize window,
                                           const FeatureMap* map, const FeatureMap* sieve) {
  if (kernel.kind == ValueKernelKind::distance) {
    return std::make_unique<FloatDelta<kind, ValueKernelKind::distance, C>>(footprint, kernel, window, map, sieve);
  }
  return std::make_unique<FloatDelta<kind, ValueKernelKind::stbn, C>>(footprint, kernel, window, map, sieve);
}

template <DistanceKind kind, int C, int last>
std::unique_ptr<SwapDelta> with_channels(const Footprint& footprint, const ValueKernel& kernel, WindowSize window,
                                         const FeatureMap* map, const FeatureMap* sieve) {
  if (kernel.channels == C) return with_value_kind<kind, C>(footprint, kernel, window, map, sieve);
  if constexpr (C < last) return with_channels<kind, C + 1, last>(footprint, kernel, window, map, sieve);
  NOISELOOM_CHECK_LE(kernel.channels, last);
  return nullptr;
}

std::unique_ptr<SwapDelta> make(const Footprint& footprint, const ValueKernel& kernel, WindowSize window,
                                const FeatureMap* map, const FeatureMap* sieve) {
  switch (kernel.distance) {
    case DistanceKind::absolute:
      return with_value_kind<DistanceKind::absolute, 1>(footprint, kernel, window, map, sieve);
    case DistanceKind::circle:
      return with_value_kind<DistanceKind::circle, 1>(footprint, kernel, window, map, sieve);
    case DistanceKind::angle:
      return with_channels<DistanceKind::angle, 2, 4>(footprint, kernel, window, map, sieve);
    case DistanceKind::axis:
      return with_channels<DistanceKind::axis, 3, 4>(footprint, kernel, window, map, sieve);
    case DistanceKind::manhattan:
      return with_channels<DistanceKind::manhattan, 2, 8>(footprint, kernel, window, map, sieve);
    case DistanceKind::chebyshev:
      return with_channels<DistanceKind::chebyshev, 2, 8>(footprint, kernel, window, map, sieve);
    case DistanceKind::cosine:
      return with_channels<DistanceKind::cosine, 2, 4>(footprint, kernel, window, map, sieve);
    case DistanceKind::euclidean:
      break;
  }
  return with_channels<DistanceKind::euclidean, 1, 8>(footprint, kernel, window, map, sieve);
}

}  // namespace noiseloom::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace noiseloom {

HWY_EXPORT(make);

std::unique_ptr<SwapDelta> make_float_delta(const Footprint& footprint, const ValueKernel& kernel, WindowSize window,
                                            const FeatureMap* between_slices, const FeatureMap* sieve) {
  return HWY_DYNAMIC_DISPATCH(make)(footprint, kernel, window, between_slices, sieve);
}

}  // namespace noiseloom
#endif
