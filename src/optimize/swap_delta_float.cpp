// The swap delta in float, vectorised for each instruction set; which one runs is found at run time.
#include "optimize/swap_delta_float.h"

#include <optional>

#include "optimize/background.h"
#include "optimize/delta_fields.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "optimize/swap_delta_float.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "optimize/simd_kernels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace noiseloom::HWY_NAMESPACE {

// sum over taps of F (K(b, s) - K(a, s)), at the centre i less at the centre j, for a at i and b at j: dE is twice
// that.
template <DistanceKind kind, ValueKernelKind value_kind, int C>
class Judge {
 public:
  Judge(const Unlikeness<kind, value_kind, C>& unlike, const float (&a)[C], const float (&b)[C]) : unlike_(unlike) {
    for (int c = 0; c < C; ++c) {
      a_[c] = set(a[c]);
      b_[c] = set(b[c]);
    }
  }
  HWY_INLINE V term(const V (&at_i)[C], const V (&at_j)[C]) const {
    const V i = hn::Sub(unlike_(a_, at_i), unlike_(b_, at_i));
    return hn::Sub(i, hn::Sub(unlike_(a_, at_j), unlike_(b_, at_j)));
  }
  // What a sum of terms stands for, and the value that stands for 1.
  HWY_INLINE float scaled(float sum) const { return sum; }
  HWY_INLINE float unit() const { return 1; }

 private:
  const Unlikeness<kind, value_kind, C>& unlike_;
  V a_[C];
  V b_[C];
};

// For a < b: |a - s| - |b - s| = 2 clamp(s, a, b) - a - b, and a + b cancels between the centres.
template <>
class Judge<DistanceKind::absolute, ValueKernelKind::distance, 1> {
 public:
  Judge(const Unlikeness<DistanceKind::absolute, ValueKernelKind::distance, 1>&, const float (&a)[1],
        const float (&b)[1])
      : low_(set(a[0] < b[0] ? a[0] : b[0])), high_(set(a[0] < b[0] ? b[0] : a[0])), scale_(a[0] < b[0] ? 2 : -2) {}
  HWY_INLINE V term(const V (&at_i)[1], const V (&at_j)[1]) const {
    return hn::Sub(hn::Min(hn::Max(at_i[0], low_), high_), hn::Min(hn::Max(at_j[0], low_), high_));
  }
  HWY_INLINE float scaled(float sum) const { return scale_ * sum; }
  HWY_INLINE float unit() const { return 1 / scale_; }

 private:
  V low_;
  V high_;
  float scale_;
};

template <DistanceKind kind, ValueKernelKind value_kind, int C>
class FloatDelta final : public SwapDelta {
 public:
  FloatDelta(const Footprint& footprint, const ValueKernel& kernel, WindowSize window, const FeatureMap* between_slices)
      : fields_(footprint, C, window, between_slices == nullptr), unlike_(kernel) {
    if (between_slices != nullptr) background_.emplace(footprint, *between_slices, window);
  }

  const FieldLayout& layout() const override { return fields_.layout(); }

  void bind(SliceIndex slice, Corner corner, const SliceField& own, const FieldOf& others) override {
    fields_.bind(slice, corner, own, others);
    if (background_) background_->bind(slice, corner, fields_.own(), others);
  }
  void swap(CellPair pair) override {
    fields_.swap(pair.i, pair.j);
    if (background_) background_->swap(pair);
  }

  // What lies in the nearer caches without that, planes of samples, is not worth the instructions.
  void prefetch(CellPair pair) const override {
    if (!background_) return;
    const std::int64_t floats = 2 * background_->num_lanes();
    for (const std::uint32_t cell : {pair.i, pair.j}) {
      const float* at = background_->at(cell);
      for (std::int64_t k = 0; k < floats; k += std::int64_t{block_lanes}) hwy::Prefetch(at + k);
    }
  }

  double delta(CellPair pair) const override {
    const DeltaFields::Position at_i = fields_.position(pair.i);
    const DeltaFields::Position at_j = fields_.position(pair.j);
    float a[C];
    float b[C];
    for (int c = 0; c < C; ++c) {
      a[c] = fields_.own().plane(c)[at_i.in[DeltaFields::rows]];
      b[c] = fields_.own().plane(c)[at_j.in[DeltaFields::rows]];
    }
    const Judge<kind, value_kind, C> judge(unlike_, a, b);
    V sums[num_parts];
    for (V& sum : sums) sum = hn::Zero(Floats());
    for (const DeltaFields::Part& part : fields_.parts()) {
      add(judge, *part.taps, part.samples + at_i.in[part.kind], part.samples + at_j.in[part.kind], part.plane_size,
          sums);
    }
    if (background_) add_background(pair, judge.unit(), sums);
    float sum = judge.scaled(fold(sums));
    if (const float weight = fields_.pair_weight(at_i, at_j); weight != 0) sum -= weight * pair_term(a, b);
    return 2 * static_cast<double>(sum);
  }

 private:
  HWY_INLINE void add(const Judge<kind, value_kind, C>& judge, const TapBlocks& taps, const float* at_i,
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
        sums[p] = hn::Add(sums[p], hn::Mul(weight, judge.term(i, j)));
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
        sums[p] = hn::Add(sums[p], hn::Mul(weight, judge.term(i, j)));
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
    const float ab = hn::GetLane(unlike_(va, vb));
    return 2 * ab - hn::GetLane(unlike_(va, va)) - hn::GetLane(unlike_(vb, vb));
  }

  DeltaFields fields_;
  std::optional<Background> background_;
  Unlikeness<kind, value_kind, C> unlike_;
};

template <DistanceKind kind, int C>
std::unique_ptr<SwapDelta> with_value_kind(const Footprint& footprint, const ValueKernel& kernel, WindowSize window,
                                           const FeatureMap* map) {
  if (kernel.kind == ValueKernelKind::distance) {
    return std::make_unique<FloatDelta<kind, ValueKernelKind::distance, C>>(footprint, kernel, window, map);
  }
  return std::make_unique<FloatDelta<kind, ValueKernelKind::stbn, C>>(footprint, kernel, window, map);
}

template <DistanceKind kind, int C, int last>
std::unique_ptr<SwapDelta> with_channels(const Footprint& footprint, const ValueKernel& kernel, WindowSize window,
                                         const FeatureMap* map) {
  if (kernel.channels == C) return with_value_kind<kind, C>(footprint, kernel, window, map);
  if constexpr (C < last) return with_channels<kind, C + 1, last>(footprint, kernel, window, map);
  NOISELOOM_CHECK_LE(kernel.channels, last);
  return nullptr;
}

std::unique_ptr<SwapDelta> make(const Footprint& footprint, const ValueKernel& kernel, WindowSize window,
                                const FeatureMap* map) {
  switch (kernel.distance) {
    case DistanceKind::absolute:
      return with_value_kind<DistanceKind::absolute, 1>(footprint, kernel, window, map);
    case DistanceKind::circle:
      return with_value_kind<DistanceKind::circle, 1>(footprint, kernel, window, map);
    case DistanceKind::angle:
      return with_channels<DistanceKind::angle, 2, 4>(footprint, kernel, window, map);
    case DistanceKind::euclidean:
      break;
  }
  return with_channels<DistanceKind::euclidean, 1, 8>(footprint, kernel, window, map);
}

}  // namespace noiseloom::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace noiseloom {

HWY_EXPORT(make);

std::unique_ptr<SwapDelta> make_float_delta(const Footprint& footprint, const ValueKernel& kernel, WindowSize window,
                                            const FeatureMap* between_slices) {
  return HWY_DYNAMIC_DISPATCH(make)(footprint, kernel, window, between_slices);
}

}  // namespace noiseloom
#endif
