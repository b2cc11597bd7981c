#include "samples/scalar_space.h"

#include <cmath>
#include <limits>

#include "noiseloom/core/error.h"

namespace noiseloom {

double ScalarSpace::quantile_at(std::int64_t n, std::int64_t k, double jitter) const {
  const double count = static_cast<double>(n);
  return map_.quantile((static_cast<double>(k) + jitter) / count, (static_cast<double>(n - k) - jitter) / count);
}

float ScalarSpace::sample_between(std::int64_t n, std::int64_t k, double jitter, double low, double high) const {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  float sample = static_cast<float>(quantile_at(n, k, jitter));
  if (sample < low) sample = std::nextafter(sample, infinity);
  // Last, so that the end of the space is never reached, not even where a stratum holds no float.
  if (sample >= high) sample = std::nextafter(sample, -infinity);
  return sample;
}

void ScalarSpace::sample(std::int64_t n, std::int64_t id, const double* jitter, float* sample) const {
  NOISELOOM_CHECK(id >= 0 && id < n);
  *sample = sample_between(n, id, *jitter, edge(n, id), edge(n, id + 1));
}

void ScalarSpace::list(std::int64_t n, const JitterOf& jitter, float* samples) const {
  double low = edge(n, 0);
  for (std::int64_t id = 0; id < n; ++id) {
    double at = 0;
    jitter(id, &at);
    const double high = edge(n, id + 1);
    *samples++ = sample_between(n, id, at, low, high);
    low = high;
  }
}

std::int64_t ScalarSpace::invert(std::int64_t n, const float* sample) const {
  const double x = *sample;
  const double stratum = map_.cumulative(x) * static_cast<double>(n);
  std::int64_t k = stratum >= static_cast<double>(n) ? n - 1 : stratum > 0 ? static_cast<std::int64_t>(stratum) : 0;
  while (k > 0 && x < edge(n, k)) --k;
  while (k + 1 < n && x >= edge(n, k + 1)) ++k;
  return k;
}

}  // namespace noiseloom
