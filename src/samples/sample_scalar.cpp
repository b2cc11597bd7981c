#include "samples/sample_scalar.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "noiseloom/core/math.h"

namespace noiseloom {
namespace {

// The quantile with `below` of the measure on its low side and `above` on its high side; both are given because 1 -
// below has lost its digits where it is small.
double quantile(SampleKind kind, double below, double above) {
  const bool low_half = below <= above;
  if (kind == SampleKind::tent) return low_half ? std::sqrt(0.5 * below) : 1 - std::sqrt(0.5 * above);
  if (kind == SampleKind::gauss) return low_half ? math::inverse_normal_cdf(below) : -math::inverse_normal_cdf(above);
  return below;
}

double quantile_at(SampleKind kind, std::int64_t n, std::int64_t k, double jitter) {
  const double count = static_cast<double>(n);
  return quantile(kind, (static_cast<double>(k) + jitter) / count, (static_cast<double>(n - k) - jitter) / count);
}

double cdf(SampleKind kind, double x) {
  if (kind == SampleKind::tent) return x < 0.5 ? 2 * x * x : 1 - 2 * (1 - x) * (1 - x);
  if (kind == SampleKind::gauss) return 0.5 * (1 + math::erf(x * std::sqrt(0.5)));
  return x;
}

}  // namespace

double scalar_edge(SampleKind kind, std::int64_t n, std::int64_t k) { return quantile_at(kind, n, k, 0); }

float scalar_sample(SampleKind kind, std::int64_t n, std::int64_t k, double jitter, double low, double high) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  float sample = static_cast<float>(quantile_at(kind, n, k, jitter));
  if (sample < low) sample = std::nextafter(sample, infinity);
  // Last, so that the end of the space is never reached, not even where a stratum holds no float.
  if (sample >= high) sample = std::nextafter(sample, -infinity);
  return sample;
}

double scalar_pdf(SampleKind kind, double x) {
  if (kind == SampleKind::gauss) return math::exp(-0.5 * x * x) / std::sqrt(math::two_pi);
  if (x < 0 || x >= 1) return 0;
  return kind == SampleKind::tent ? 4 * std::min(x, 1 - x) : 1;
}

std::int64_t scalar_invert(SampleKind kind, std::int64_t n, double x) {
  const double rank = cdf(kind, x) * static_cast<double>(n);
  std::int64_t k = rank >= static_cast<double>(n) ? n - 1 : rank > 0 ? static_cast<std::int64_t>(rank) : 0;
  while (k > 0 && x < scalar_edge(kind, n, k)) --k;
  while (k + 1 < n && x >= scalar_edge(kind, n, k + 1)) ++k;
  return k;
}

}  // namespace noiseloom
