// Value kernels in double, on planar samples.
#pragma once

#include <cmath>

#include "noiseloom/core/math.h"
#include "noiseloom/problem/value_kernel.h"

namespace noiseloom::metrics {

// Distance between two samples of C channels.
template <DistanceKind kind, int C>
inline double distance(const double* v, const double* s) {
  if constexpr (kind == DistanceKind::absolute) {
    return std::abs(v[0] - s[0]);
  } else if constexpr (kind == DistanceKind::circle) {
    const double d = std::abs(v[0] - s[0]);
    return d < 1 - d ? d : 1 - d;
  } else if constexpr (kind == DistanceKind::angle) {
    double dot = 0;
    for (int c = 0; c < C; ++c) dot += v[c] * s[c];
    return math::acos(dot);
  } else if constexpr (kind == DistanceKind::manhattan || kind == DistanceKind::chebyshev) {
    double d = 0;
    for (int c = 0; c < C; ++c) {
      const double along = std::abs(v[c] - s[c]);
      d = kind == DistanceKind::manhattan ? d + along : along > d ? along : d;
    }
    return d;
  } else {
    double sum = 0;
    for (int c = 0; c < C; ++c) sum += (v[c] - s[c]) * (v[c] - s[c]);
    if constexpr (kind == DistanceKind::cosine) return 0.5 * sum;
    if constexpr (kind == DistanceKind::axis) {
      double to_opposite = 0;
      for (int c = 0; c < C; ++c) to_opposite += (v[c] + s[c]) * (v[c] + s[c]);
      return 0.5 * std::sqrt(sum * to_opposite);
    }
    return std::sqrt(sum);
  }
}

// K of ValueKernel.
template <DistanceKind kind, ValueKernelKind value_kind, int C>
struct Metric {
  double exponent;
  double inverse_sigma_s2;

  explicit Metric(const ValueKernel& kernel) : exponent(kernel.exponent), inverse_sigma_s2(kernel.inverse_sigma_s2) {}

  double operator()(const double* v, const double* s) const {
    const double d = distance<kind, C>(v, s);
    if constexpr (value_kind == ValueKernelKind::distance) return -d;
    return math::exp(-inverse_sigma_s2 * math::pow(d, exponent));
  }
};

}  // namespace noiseloom::metrics
