// Scalar spaces: sorted strata by the inverse of the distribution function.
#pragma once

#include <cstdint>

#include "noiseloom/samples/spec.h"

namespace noiseloom {

// kind: uniform, circle, tent or gauss; the edges of stratum k are scalar_edge(k) and scalar_edge(k + 1), 0 <= k <= n.
double scalar_edge(SampleKind kind, std::int64_t n, std::int64_t k);
// The sample of stratum k = [low, high) at `jitter` in (0, 1), rounded into it.
float scalar_sample(SampleKind kind, std::int64_t n, std::int64_t k, double jitter, double low, double high);
double scalar_pdf(SampleKind kind, double x);
std::int64_t scalar_invert(SampleKind kind, std::int64_t n, double x);

}  // namespace noiseloom
