// The square roots vectorise only under -fno-math-errno; without it this is right but three times slower.
#include "problem/distances/score_distance.h"

#include <algorithm>
#include <cmath>

#include "noiseloom/core/math.h"

namespace noiseloom {
namespace {

constexpr std::size_t lanes = 8;
constexpr std::size_t chunk = 128;  // distances that are found before they are added up

// Distances of `length` pairs. `step` is 1, or 0 where one sample a meets all of b.
template <DistanceKind kind, std::size_t step>
[[gnu::always_inline]] inline void find_distances(SampleRun a, SampleRun b, std::size_t length, std::size_t channels,
                                                  double* distances) {
  if constexpr (kind == DistanceKind::absolute || kind == DistanceKind::circle) {
    for (std::size_t i = 0; i < length; ++i) {
      const double d = std::abs(a.values[i * step] - b.values[i]);
      distances[i] = kind == DistanceKind::circle && 1 - d < d ? 1 - d : d;
    }
    return;
  }
  if constexpr (kind == DistanceKind::angle) {
    if (channels == 3) {  // directions: no array between the loops
      const double* x = a.values;
      const double* y = b.values;
      for (std::size_t i = 0; i < length; ++i) {
        const double dot = x[i * step] * y[i] + x[a.stride + i * step] * y[b.stride + i] +
                           x[2 * a.stride + i * step] * y[2 * b.stride + i];
        distances[i] = math::acos(dot);
      }
      return;
    }
  }
  double to_opposites[kind == DistanceKind::axis ? chunk : 1] = {};
  std::fill_n(distances, length, 0.0);
  for (std::size_t c = 0; c < channels; ++c) {
    const double* x = a.values + c * a.stride;
    const double* y = b.values + c * b.stride;
    for (std::size_t i = 0; i < length; ++i) {
      const double difference = x[i * step] - y[i];
      if constexpr (kind == DistanceKind::manhattan) {
        distances[i] += std::abs(difference);
      } else if constexpr (kind == DistanceKind::chebyshev) {
        distances[i] = distances[i] < std::abs(difference) ? std::abs(difference) : distances[i];
      } else {
        distances[i] += kind == DistanceKind::angle ? x[i * step] * y[i] : difference * difference;
      }
    }
    if constexpr (kind == DistanceKind::axis) {
      for (std::size_t i = 0; i < length; ++i) to_opposites[i] += (x[i * step] + y[i]) * (x[i * step] + y[i]);
    }
  }
  if constexpr (kind == DistanceKind::manhattan || kind == DistanceKind::chebyshev) return;
  for (std::size_t i = 0; i < length; ++i) {
    if constexpr (kind == DistanceKind::cosine) {
      distances[i] *= 0.5;
      continue;
    }
    if constexpr (kind == DistanceKind::axis) distances[i] *= 0.25 * to_opposites[i];
    distances[i] = kind == DistanceKind::angle ? math::acos(distances[i]) : std::sqrt(distances[i]);
  }
}

template <DistanceKind kind, std::size_t step>
[[gnu::always_inline]] inline double run_sum(SampleRun a, SampleRun b, std::size_t count, std::size_t channels) {
  double sums[lanes] = {};
  double distances[chunk];
  for (std::size_t begin = 0; begin < count; begin += chunk) {
    const std::size_t length = std::min(chunk, count - begin);
    find_distances<kind, step>(a.from(begin * step), b.from(begin), length, channels, distances);
    for (std::size_t i = length; i % lanes != 0; ++i) distances[i] = 0;
    for (std::size_t i = 0; i < length; i += lanes) {
      for (std::size_t lane = 0; lane < lanes; ++lane) sums[lane] += distances[i + lane];
    }
  }
  return ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]));
}

template <DistanceKind kind, std::size_t step>
double run_sum_portable(SampleRun a, SampleRun b, std::size_t count, std::size_t channels) {
  return run_sum<kind, step>(a, b, count, channels);
}

#if defined(__x86_64__)
template <DistanceKind kind, std::size_t step>
[[gnu::target("avx2")]] double run_sum_avx2(SampleRun a, SampleRun b, std::size_t count, std::size_t channels) {
  return run_sum<kind, step>(a, b, count, channels);
}

template <DistanceKind kind, std::size_t step>
[[gnu::target("avx512f,avx512vl,avx512dq")]] double run_sum_avx512(SampleRun a, SampleRun b, std::size_t count,
                                                                   std::size_t channels) {
  return run_sum<kind, step>(a, b, count, channels);
}
#endif

template <DistanceKind kind, std::size_t step>
RunSum best(Widest widest) {
#if defined(__x86_64__)
  const bool has_avx512 =
      __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq");
  if (widest == Widest::avx512 && has_avx512) return run_sum_avx512<kind, step>;
  if (widest != Widest::portable && __builtin_cpu_supports("avx2")) return run_sum_avx2<kind, step>;
#else
  static_cast<void>(widest);
#endif
  return run_sum_portable<kind, step>;
}

template <std::size_t step>
RunSum run_sum_for(DistanceKind kind, Widest widest) {
  switch (kind) {
    case DistanceKind::absolute:
      return best<DistanceKind::absolute, step>(widest);
    case DistanceKind::circle:
      return best<DistanceKind::circle, step>(widest);
    case DistanceKind::euclidean:
      return best<DistanceKind::euclidean, step>(widest);
    case DistanceKind::angle:
      return best<DistanceKind::angle, step>(widest);
    case DistanceKind::axis:
      return best<DistanceKind::axis, step>(widest);
    case DistanceKind::manhattan:
      return best<DistanceKind::manhattan, step>(widest);
    case DistanceKind::chebyshev:
      return best<DistanceKind::chebyshev, step>(widest);
    case DistanceKind::cosine:
      return best<DistanceKind::cosine, step>(widest);
  }
  return nullptr;
}

}  // namespace

RunSum sum_of_pairs(DistanceKind kind, Widest widest) { return run_sum_for<1>(kind, widest); }
RunSum sum_to_first(DistanceKind kind, Widest widest) { return run_sum_for<0>(kind, widest); }

}  // namespace noiseloom
