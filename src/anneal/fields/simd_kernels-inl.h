// Value kernels in float, a vector of samples at a time. The bits do not depend on the instruction set
// (simd_lanes-inl.h).
#if defined(NOISELOOM_SIMD_KERNELS) == defined(HWY_TARGET_TOGGLE)
#ifdef NOISELOOM_SIMD_KERNELS
#undef NOISELOOM_SIMD_KERNELS
#else
#define NOISELOOM_SIMD_KERNELS
#endif

#include "anneal/fields/simd_lanes-inl.h"
#include "noiseloom/problem/value_kernel.h"

HWY_BEFORE_NAMESPACE();
namespace noiseloom::HWY_NAMESPACE {

template <std::size_t n>
HWY_INLINE V polynomial(V x, const float (&coefficients)[n]) {
  V p = set(coefficients[0]);
  for (std::size_t k = 1; k < n; ++k) p = hn::Add(hn::Mul(p, x), set(coefficients[k]));
  return p;
}

// The angle between unit vectors from the square of their chord, q = 2 - 2 cos: unlike the cosine, a chord is exact for
// vectors that nearly agree. acos(1 - u) = sqrt(u) p(1 - u): [AbramowitzStegun64, 4.4.46], absolute error below 4e-7
// after rounding, save within 1e-3 of the antipode.
HWY_INLINE V angle_of_chord(V q) {
  constexpr float coefficients[] = {-0.0012624911F, 0.0066700901F, -0.0170881256F, 0.0308918810F,
                                    -0.0501743046F, 0.0889789874F, -0.2145988016F, 1.5707963050F};
  const auto obtuse = hn::Gt(q, set(2));
  const V folded = hn::IfThenElse(obtuse, hn::Max(hn::Sub(set(4), q), set(0)), q);
  const V u = hn::Mul(set(0.5F), folded);
  const V r = hn::Mul(hn::Sqrt(u), polynomial(hn::Sub(set(1), u), coefficients));
  return hn::IfThenElse(obtuse, hn::Sub(set(3.14159265F), r), r);
}

// 2^x, 0 below -126, 2^126 above 126: Taylor series of degree 6 around the nearest integer, relative error below 2e-7.
HWY_INLINE V exp2(V x) {
  constexpr float coefficients[] = {1.0F / 720, 1.0F / 120, 1.0F / 24, 1.0F / 6, 0.5F, 1, 1};
  const hn::RebindToSigned<Floats> ints;
  const V clamped = hn::Min(hn::Max(x, set(-126)), set(126));
  const auto whole = hn::ConvertTo(ints, hn::Add(clamped, hn::CopySign(set(0.5F), clamped)));
  const V f = hn::Mul(hn::Sub(clamped, hn::ConvertTo(Floats(), whole)), set(0.69314718F));
  const V scale = hn::BitCast(Floats(), hn::ShiftLeft<23>(hn::Add(whole, hn::Set(ints, 127))));
  return hn::IfThenZeroElse(hn::Lt(x, set(-126)), hn::Mul(polynomial(f, coefficients), scale));
}

// log2 of normal x > 0: mantissa in [sqrt(1/2), sqrt(2)), odd series of (m - 1)/(m + 1), absolute error below 3e-7 *
// max(1, |log2 x|).
HWY_INLINE V log2(V x) {
  constexpr float coefficients[] = {1.0F / 9, 1.0F / 7, 1.0F / 5, 1.0F / 3, 1};
  const hn::RebindToSigned<Floats> ints;
  const auto bits = hn::BitCast(ints, x);
  const auto exponent = hn::ShiftRight<23>(hn::Sub(bits, hn::Set(ints, 0x3f3504f3)));
  const V m = hn::BitCast(Floats(), hn::Sub(bits, hn::ShiftLeft<23>(exponent)));
  const V z = hn::Div(hn::Sub(m, set(1)), hn::Add(m, set(1)));
  const V series = hn::Mul(hn::Mul(set(2.88539008F), z), polynomial(hn::Mul(z, z), coefficients));
  return hn::Add(hn::ConvertTo(Floats(), exponent), series);
}

// Distance between a sample v, the same in all lanes, and the samples s; for the stbn kernel its square is enough.
template <DistanceKind kind, int C>
HWY_INLINE V square_of_difference(const V (&v)[C], const V (&s)[C]) {
  V sum = hn::Zero(Floats());
  for (int c = 0; c < C; ++c) {
    const V d = hn::Sub(v[c], s[c]);
    sum = c == 0 ? hn::Mul(d, d) : hn::Add(sum, hn::Mul(d, d));
  }
  return sum;
}

// The square of the sine of the angle, from the chords to s and to its opposite: where one is short it is exact.
template <int C>
HWY_INLINE V square_of_sine(const V (&v)[C], const V (&s)[C]) {
  V opposite[C];
  for (int c = 0; c < C; ++c) opposite[c] = hn::Neg(s[c]);
  return hn::Mul(hn::Mul(set(0.25F), square_of_difference<DistanceKind::axis, C>(v, s)),
                 square_of_difference<DistanceKind::axis, C>(v, opposite));
}

template <DistanceKind kind, int C>
HWY_INLINE V distance(const V (&v)[C], const V (&s)[C]) {
  if constexpr (kind == DistanceKind::absolute) {
    return hn::Abs(hn::Sub(v[0], s[0]));
  } else if constexpr (kind == DistanceKind::circle) {
    const V d = hn::Abs(hn::Sub(v[0], s[0]));
    return hn::Min(d, hn::Sub(set(1), d));
  } else if constexpr (kind == DistanceKind::angle) {
    return angle_of_chord(square_of_difference<kind, C>(v, s));
  } else if constexpr (kind == DistanceKind::axis) {
    return hn::Sqrt(square_of_sine<C>(v, s));
  } else if constexpr (kind == DistanceKind::manhattan || kind == DistanceKind::chebyshev) {
    V d = hn::Abs(hn::Sub(v[0], s[0]));
    for (int c = 1; c < C; ++c) {
      const V along = hn::Abs(hn::Sub(v[c], s[c]));
      d = kind == DistanceKind::manhattan ? hn::Add(d, along) : hn::Max(d, along);
    }
    return d;
  } else if constexpr (kind == DistanceKind::cosine) {
    return hn::Mul(set(0.5F), square_of_difference<kind, C>(v, s));
  } else {
    return hn::Sqrt(square_of_difference<kind, C>(v, s));
  }
}

// -exp(-(d^2)^(exponent / 2) / sigma_s^2), of the square of a distance.
class StbnCost {
 public:
  explicit StbnCost(const ValueKernel& kernel)
      : half_exponent_(static_cast<float>(kernel.exponent / 2)),
        scale_(static_cast<float>(-1.4426950408889634 * kernel.inverse_sigma_s2)) {}

  HWY_INLINE V operator()(V d2) const {
    const V tiny = set(1e-30F);
    const V power = exp2(hn::Mul(set(half_exponent_), log2(hn::Max(d2, tiny))));
    return hn::Neg(exp2(hn::Mul(set(scale_), hn::IfThenZeroElse(hn::Lt(d2, tiny), power))));
  }

 private:
  float half_exponent_;
  float scale_;
};

// What the energy counts a pair of samples with, -K of ValueKernel: the distance, or its StbnCost.
template <DistanceKind kind, ValueKernelKind value_kind, int C>
class PairCost {
 public:
  explicit PairCost(const ValueKernel& kernel) : stbn_(kernel) {}

  HWY_INLINE V operator()(const V (&v)[C], const V (&s)[C]) const {
    if constexpr (value_kind == ValueKernelKind::distance) {
      return distance<kind, C>(v, s);
    } else if constexpr (kind == DistanceKind::absolute || kind == DistanceKind::euclidean) {
      return stbn_(square_of_difference<kind, C>(v, s));
    } else if constexpr (kind == DistanceKind::axis) {
      return stbn_(square_of_sine<C>(v, s));
    } else {
      const V d = distance<kind, C>(v, s);
      return stbn_(hn::Mul(d, d));
    }
  }
  float between(const float (&a)[C], const float (&b)[C]) const {
    V va[C];
    V vb[C];
    for (int c = 0; c < C; ++c) {
      va[c] = set(a[c]);
      vb[c] = set(b[c]);
    }
    return hn::GetLane((*this)(va, vb));
  }

 private:
  StbnCost stbn_;
};

// The same of any number of channels: `all` is what those before have come to, 0 at the beginning, and `cost` makes of
// all of them what PairCost returns, bit for bit. To compile a class for each number takes longer than it is worth.
template <DistanceKind kind, ValueKernelKind value_kind>
class ChannelwisePairCost {
  static_assert(kind == DistanceKind::euclidean || kind == DistanceKind::manhattan || kind == DistanceKind::chebyshev);

 public:
  explicit ChannelwisePairCost(const ValueKernel& kernel) : channels_(kernel.channels), stbn_(kernel) {}

  int channels() const { return channels_; }
  HWY_INLINE V with_channel(V all, V v, V s) const {
    const V along = hn::Sub(v, s);
    if constexpr (kind == DistanceKind::euclidean) return hn::Add(all, hn::Mul(along, along));
    return kind == DistanceKind::manhattan ? hn::Add(all, hn::Abs(along)) : hn::Max(all, hn::Abs(along));
  }
  HWY_INLINE V cost(V all) const {
    if constexpr (kind == DistanceKind::euclidean) {
      return value_kind == ValueKernelKind::distance ? hn::Sqrt(all) : stbn_(all);
    } else {
      return value_kind == ValueKernelKind::distance ? all : stbn_(hn::Mul(all, all));
    }
  }
  float between(const float* a, const float* b) const {
    V all = set(0);
    for (int c = 0; c < channels_; ++c) all = with_channel(all, set(a[c]), set(b[c]));
    return hn::GetLane(cost(all));
  }

 private:
  int channels_;
  StbnCost stbn_;
};

}  // namespace noiseloom::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
