// The swap delta in float, vectorised for each instruction set; which one runs is found at run time.
#include "anneal/deltas/swap_delta_float.h"

#include "anneal/deltas/delta_in_fields.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "anneal/deltas/swap_delta_float.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "anneal/deltas/swap_term-inl.h"

HWY_BEFORE_NAMESPACE();
namespace noiseloom::HWY_NAMESPACE {

// A part of a block of samples, channel by channel: 16 in a row, or 8 and 8.
struct RowOfSamples {
  const float* first;
  std::int64_t plane_size;
  std::size_t part;
  HWY_INLINE V operator()(int c) const { return load_full(first + c * plane_size, part); }
};
struct SplitSamples {
  const float* low;
  const float* high;
  std::int64_t plane_size;
  std::size_t part;
  HWY_INLINE V operator()(int c) const { return load_split(low + c * plane_size, high + c * plane_size, part); }
};

// Term: a SwapTerm, or what stands for one.
template <class Term>
class FloatDelta final : public DeltaInFields {
 public:
  FloatDelta(const Footprint& footprint, const ValueKernel& kernel, WindowSize window, const FeatureMap* between_slices,
             const FeatureMap* sieve)
      : DeltaInFields(footprint, kernel.channels, window, between_slices, sieve), pair_cost_(kernel) {}

  double delta(CellPair pair) const override {
    const DeltaFields::Position at_i = fields_.position(pair.i);
    const DeltaFields::Position at_j = fields_.position(pair.j);
    float a[Term::most_channels];
    float b[Term::most_channels];
    load(at_i, a);
    load(at_j, b);
    const Term swap_term(pair_cost_, a, b);
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
  HWY_INLINE void load(const DeltaFields::Position& at, float (&sample)[Term::most_channels]) const {
    for (int c = 0; c < Term::channels(pair_cost_); ++c) sample[c] = fields_.own().plane(c)[at.in[DeltaFields::rows]];
  }

  HWY_INLINE void add(const Term& swap_term, const TapBlocks& taps, const float* at_i, const float* at_j,
                      std::int64_t plane_size, V (&sums)[num_parts]) const {
    for (std::size_t k = 0; k < taps.full.size(); ++k) {
      for (std::size_t p = 0; p < num_parts; ++p) {
        const RowOfSamples around_i{at_i + taps.full[k], plane_size, p};
        const RowOfSamples around_j{at_j + taps.full[k], plane_size, p};
        const V weight = load_full(taps.full_weights[k].lane, p);
        sums[p] = hn::Add(sums[p], hn::Mul(weight, swap_term.term(around_i, around_j)));
      }
    }
    for (std::size_t k = 0; k < taps.split.size(); ++k) {
      const auto [low, high] = taps.split[k];
      for (std::size_t p = 0; p < num_parts; ++p) {
        const SplitSamples around_i{at_i + low, at_i + high, plane_size, p};
        const SplitSamples around_j{at_j + low, at_j + high, plane_size, p};
        const V weight = load_full(taps.split_weights[k].lane, p);
        sums[p] = hn::Add(sums[p], hn::Mul(weight, swap_term.term(around_i, around_j)));
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

  float pair_term(const DeltaFields::Position& at_i, const DeltaFields::Position& at_j) const override {
    float a[Term::most_channels];
    float b[Term::most_channels];
    load(at_i, a);
    load(at_j, b);
    return pair_term(a, b);
  }
  HWY_NOINLINE float pair_term(const float (&a)[Term::most_channels], const float (&b)[Term::most_channels]) const {
    return 2 * pair_cost_.between(a, b) - pair_cost_.between(a, a) - pair_cost_.between(b, b);
  }

  typename Term::Cost pair_cost_;
};

// What make() is asked with.
struct Asked {
  const Footprint& footprint;
  const ValueKernel& kernel;
  WindowSize window;
  const FeatureMap* between_slices;
  const FeatureMap* sieve;

  template <class Term>
  std::unique_ptr<SwapDelta> make() const {
    return std::make_unique<FloatDelta<Term>>(footprint, kernel, window, between_slices, sieve);
  }
};

template <DistanceKind kind, int C>
std::unique_ptr<SwapDelta> with_value_kind(const Asked& asked) {
  if (asked.kernel.kind == ValueKernelKind::distance) {
    return asked.make<SwapTerm<kind, ValueKernelKind::distance, C>>();
  }
  return asked.make<SwapTerm<kind, ValueKernelKind::stbn, C>>();
}

template <DistanceKind kind>
std::unique_ptr<SwapDelta> with_any_channels(const Asked& asked) {
  using Term = ChannelwiseSwapTerm<kind, ValueKernelKind::distance>;
  NOISELOOM_CHECK_LE(asked.kernel.channels, Term::most_channels);
  if (asked.kernel.kind == ValueKernelKind::distance) return asked.make<Term>();
  return asked.make<ChannelwiseSwapTerm<kind, ValueKernelKind::stbn>>();
}

template <DistanceKind kind, int C, int last>
std::unique_ptr<SwapDelta> with_channels(const Asked& asked) {
  if (asked.kernel.channels == C) return with_value_kind<kind, C>(asked);
  if constexpr (C < last) return with_channels<kind, C + 1, last>(asked);
  NOISELOOM_CHECK_LE(asked.kernel.channels, last);
  return nullptr;
}

std::unique_ptr<SwapDelta> make(const Footprint& footprint, const ValueKernel& kernel, WindowSize window,
                                const FeatureMap* map, const FeatureMap* sieve) {
  const Asked asked{footprint, kernel, window, map, sieve};
  switch (kernel.distance) {
    case DistanceKind::absolute:
      return with_value_kind<DistanceKind::absolute, 1>(asked);
    case DistanceKind::circle:
      return with_value_kind<DistanceKind::circle, 1>(asked);
    case DistanceKind::angle:
      return with_channels<DistanceKind::angle, 2, 4>(asked);
    case DistanceKind::axis:
      return with_channels<DistanceKind::axis, 3, 4>(asked);
    case DistanceKind::manhattan:
      return with_any_channels<DistanceKind::manhattan>(asked);
    case DistanceKind::chebyshev:
      return with_any_channels<DistanceKind::chebyshev>(asked);
    case DistanceKind::cosine:
      return with_channels<DistanceKind::cosine, 2, 4>(asked);
    case DistanceKind::euclidean:
      break;
  }
  if (kernel.channels > 4) return with_any_channels<DistanceKind::euclidean>(asked);
  return with_channels<DistanceKind::euclidean, 1, 4>(asked);
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
