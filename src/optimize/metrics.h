// Value kernels for the inner loops, in float and in double, on planar samples.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <type_traits>

#include "noiseloom/core/math.h"
#include "noiseloom/problem/value_kernel.h"

namespace noiseloom::metrics {

// The angle between unit vectors from the square of their chord, q = 2 - 2 cos: unlike the cosine, a chord is exact for
// vectors that nearly agree. acos(1 - u) = sqrt(u) p(1 - u): Abramowitz and Stegun 4.4.46 (1964), absolute error below
// 4e-7 after rounding, save within 1e-3 of the antipode.
inline float angle_of_chord(float q) {
  const bool obtuse = q > 2;
  const float u = 0.5F * (obtuse ? (q < 4 ? 4 - q : 0) : q);
  const float a = 1 - u;
  float p = -0.0012624911F;
  p = p * a + 0.0066700901F;
  p = p * a - 0.0170881256F;
  p = p * a + 0.0308918810F;
  p = p * a - 0.0501743046F;
  p = p * a + 0.0889789874F;
  p = p * a - 0.2145988016F;
  p = p * a + 1.5707963050F;
  const float r = std::sqrt(u) * p;
  return obtuse ? 3.14159265F - r : r;
}

// 2^x, 0 below -126, 2^126 above 126: Taylor series of degree 6 around the nearest integer, relative error below 2e-7.
inline float exp2(float x) {
  const float low = x < -126 ? -126 : x;
  const float clamped = low > 126 ? 126 : low;
  const float whole = static_cast<float>(static_cast<std::int32_t>(clamped + (clamped < 0 ? -0.5F : 0.5F)));
  const float f = (clamped - whole) * 0.69314718F;
  float p = 1.0F / 720;
  p = p * f + 1.0F / 120;
  p = p * f + 1.0F / 24;
  p = p * f + 1.0F / 6;
  p = p * f + 0.5F;
  p = p * f + 1;
  p = p * f + 1;
  const float scale = std::bit_cast<float>((static_cast<std::int32_t>(whole) + 127) << 23);
  return x < -126 ? 0 : p * scale;
}

// log2 for normal x > 0: mantissa in [sqrt(1/2), sqrt(2)), odd series of (m - 1)/(m + 1), absolute error below 3e-7 *
// max(1, |log2 x|).
inline float log2(float x) {
  const auto bits = std::bit_cast<std::int32_t>(x);
  const std::int32_t exponent = (bits - 0x3f3504f3) >> 23;
  const float m = std::bit_cast<float>(bits - exponent * (1 << 23));
  const float z = (m - 1) / (m + 1);
  const float z2 = z * z;
  float p = 1.0F / 9;
  p = p * z2 + 1.0F / 7;
  p = p * z2 + 1.0F / 5;
  p = p * z2 + 1.0F / 3;
  p = p * z2 + 1;
  return static_cast<float>(exponent) + 2.88539008F * z * p;
}

// exp(-scale * d2^half_exponent), d2 >= 0 a squared distance.
inline double stretched_exponential(double d2, double half_exponent, double scale) {
  return math::exp(-scale * math::pow(d2, half_exponent));
}
inline float stretched_exponential(float d2, float half_exponent, float scale) {
  const float tiny = 1e-30F;
  const float power = d2 < tiny ? 0 : exp2(half_exponent * log2(d2 < tiny ? tiny : d2));
  return exp2(-1.44269504F * scale * power);
}

// Distance between a sample v and a sample s, C channels each.
template <class Real, DistanceKind kind, int C>
inline Real distance(const Real* v, const Real* s) {
  if constexpr (kind == DistanceKind::absolute) {
    return std::abs(v[0] - s[0]);
  } else if constexpr (kind == DistanceKind::circle) {
    const Real d = std::abs(v[0] - s[0]);
    return d < 1 - d ? d : 1 - d;
  } else if constexpr (kind == DistanceKind::angle && std::is_same_v<Real, double>) {
    double dot = 0;
    for (int c = 0; c < C; ++c) dot += v[c] * s[c];
    return math::acos(dot);
  } else {
    Real sum = 0;
    for (int c = 0; c < C; ++c) sum += (v[c] - s[c]) * (v[c] - s[c]);
    if constexpr (kind == DistanceKind::angle) return angle_of_chord(sum);
    return std::sqrt(sum);
  }
}

// K of ValueKernel.
template <class Real, DistanceKind kind, ValueKernelKind value_kind, int C>
struct Metric {
  Real half_exponent = 0;
  Real scale = 0;

  explicit Metric(const ValueKernel& kernel)
      : half_exponent(static_cast<Real>(kernel.exponent / 2)), scale(static_cast<Real>(kernel.inverse_sigma_s2)) {}

  Real operator()(const Real* v, const Real* s) const {
    const Real d = distance<Real, kind, C>(v, s);
    if constexpr (value_kind == ValueKernelKind::distance) return -d;
    return stretched_exponential(d * d, half_exponent, scale);
  }
};

}  // namespace noiseloom::metrics
