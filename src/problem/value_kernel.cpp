#include "noiseloom/problem/value_kernel.h"

#include "noiseloom/core/math.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {

double ValueKernel::operator()(const float* a, const float* b) const {
  const double d = noiseloom::distance(distance, channels, a, b);
  if (kind == ValueKernelKind::distance) return -d;
  return math::exp(-math::pow(d, exponent) * inverse_sigma_s2);
}

ValueKernel make_value_kernel(const ProblemSpec& problem, int channels, DistanceKind distance) {
  ValueKernel kernel;
  kernel.kind = problem.value_kernel.kind;
  kernel.distance = distance;
  kernel.channels = channels;
  kernel.exponent = static_cast<double>(channels) / problem.extents.num_axes();
  kernel.inverse_sigma_s2 = 1 / (problem.value_kernel.sigma_s * problem.value_kernel.sigma_s);
  return kernel;
}

}  // namespace noiseloom
