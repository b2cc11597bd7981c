// Value kernel K: how alike two samples are.
//   distance: K(a, b) = -d(a, b)                          [FAST24, eq. 7]
//   stbn:     K(a, b) = exp(-d(a, b)^(D/n) / sigma_s^2)    [STBN22, eq. 5], D channels, n axes of the texture
#pragma once

#include "noiseloom/problem/spec.h"

namespace noiseloom {

struct ValueKernel {
  ValueKernelKind kind = ValueKernelKind::distance;
  DistanceKind distance = DistanceKind::absolute;
  int channels = 1;
  double exponent = 1;  // D / n
  double inverse_sigma_s2 = 1;

  // In double, with the bit-stable functions of core/math.h: the reference for every fast path.
  double operator()(const float* a, const float* b) const;
};

ValueKernel make_value_kernel(const ProblemSpec& problem, int channels, DistanceKind distance);

}  // namespace noiseloom
