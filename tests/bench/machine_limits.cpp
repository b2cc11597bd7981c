#include "bench/machine_limits.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <vector>

#include "noiseloom/core/random.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "bench/machine_limits.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "anneal/deltas/swap_term-inl.h"

HWY_BEFORE_NAMESPACE();
namespace noiseloom::HWY_NAMESPACE {

// The samples around one of the two centres, channel by channel: blocks of one lie between those of the other.
struct EverySecond {
  const BlockWeights* first;
  std::size_t part;
  HWY_INLINE V operator()(int c) const {
    return load_full(first[2 * static_cast<std::size_t>(c) * limit_blocks].lane, part);
  }
};

template <class Term>
double sum_blocks(const ValueKernel& kernel, const BlockWeights* samples, std::size_t rounds) {
  const typename Term::Cost pair_cost(kernel);
  float a[Term::most_channels];
  float b[Term::most_channels];
  for (int c = 0; c < Term::most_channels; ++c) {
    a[c] = samples[0].lane[c];
    b[c] = samples[0].lane[c + Term::most_channels];
  }
  const Term swap_term(pair_cost, a, b);
  // Two sums, so that none waits for itself.
  V sums[2] = {hn::Zero(Floats()), hn::Zero(Floats())};
  for (std::size_t round = 0; round < rounds; ++round) {
    for (std::size_t k = 0; k < limit_blocks; ++k) {
      for (std::size_t p = 0; p < num_parts; ++p) {
        // None twice, or its part of the term would be found once.
        const EverySecond i{samples + k + limit_blocks, p};
        const EverySecond j{samples + k + 2 * limit_blocks, p};
        sums[k % 2] = hn::Add(sums[k % 2], hn::Mul(load_full(samples[k].lane, p), swap_term.term(i, j)));
      }
    }
    // Not to be taken out of the loop.
    asm volatile("" ::: "memory");
  }
  return static_cast<double>(fold(Floats(), hn::Add(sums[0], sums[1])));
}

template <DistanceKind kind, int C>
double of_channels(const ValueKernel& kernel, const BlockWeights* samples, std::size_t rounds) {
  if (kernel.channels > C) {
    if constexpr (C < 4) return of_channels<kind, C + 1>(kernel, samples, rounds);
  }
  return sum_blocks<SwapTerm<kind, ValueKernelKind::distance, C>>(kernel, samples, rounds);
}

template <DistanceKind kind>
double of_any_channels(ValueKernel kernel, const BlockWeights* samples, std::size_t rounds) {
  kernel.channels = std::min(kernel.channels, 4);  // of more there are no samples
  return sum_blocks<ChannelwiseSwapTerm<kind, ValueKernelKind::distance>>(kernel, samples, rounds);
}

double run_blocks(const ValueKernel& kernel, const BlockWeights* samples, std::size_t rounds) {
  switch (kernel.distance) {
    case DistanceKind::absolute:
      return of_channels<DistanceKind::absolute, 1>(kernel, samples, rounds);
    case DistanceKind::circle:
      return of_channels<DistanceKind::circle, 1>(kernel, samples, rounds);
    case DistanceKind::angle:
      return of_channels<DistanceKind::angle, 3>(kernel, samples, rounds);
    case DistanceKind::axis:
      return of_channels<DistanceKind::axis, 3>(kernel, samples, rounds);
    case DistanceKind::manhattan:
      return of_any_channels<DistanceKind::manhattan>(kernel, samples, rounds);
    case DistanceKind::chebyshev:
      return of_any_channels<DistanceKind::chebyshev>(kernel, samples, rounds);
    case DistanceKind::cosine:
      return of_channels<DistanceKind::cosine, 2>(kernel, samples, rounds);
    case DistanceKind::euclidean:
      break;
  }
  return of_channels<DistanceKind::euclidean, 2>(kernel, samples, rounds);
}

// One vector of every line, in the order given.
double run_lines(const BlockWeights* lines, const std::uint32_t* order, std::size_t count) {
  V sums[4] = {hn::Zero(Floats()), hn::Zero(Floats()), hn::Zero(Floats()), hn::Zero(Floats())};
  for (std::size_t k = 0; k < count; k += 4) {
    for (std::size_t s = 0; s < 4; ++s) sums[s] = hn::Add(sums[s], hn::LoadU(Floats(), lines[order[k + s]].lane));
  }
  return static_cast<double>(fold(Floats(), hn::Add(hn::Add(sums[0], sums[1]), hn::Add(sums[2], sums[3]))));
}

}  // namespace noiseloom::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace noiseloom {
namespace {

HWY_EXPORT(run_blocks);
HWY_EXPORT(run_lines);

template <class Run>
double best_seconds(const Run& run) {
  double best = std::numeric_limits<double>::infinity();
  volatile double keep = 0;
  for (int round = 0; round < 20; ++round) {
    const auto begun = std::chrono::steady_clock::now();
    keep = keep + run();
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count());
  }
  return best;
}

}  // namespace

double seconds_per_block(const ValueKernel& kernel) {
  std::vector<BlockWeights> samples(limit_blocks * (2 * static_cast<std::size_t>(kernel.channels) + 1));
  for (std::size_t k = 0; k < samples.size(); ++k) {
    for (std::size_t lane = 0; lane < block_lanes; ++lane) {
      samples[k].lane[lane] =
          static_cast<float>(to_unit_double(random_block(1, Purpose::proposal, 0, 0, 16 * k + lane)[0], 0));
    }
  }
  constexpr std::size_t rounds = 2000;
  return best_seconds([&] { return HWY_DYNAMIC_DISPATCH(run_blocks)(kernel, samples.data(), rounds); }) /
         static_cast<double>(limit_blocks * rounds);
}

double seconds_per_line() {
  constexpr std::size_t num_lines = 4096;  // 256 KiB: several times the first cache, well inside the second
  std::vector<BlockWeights> lines(num_lines);
  std::vector<std::uint32_t> order(8 * num_lines);
  for (std::size_t k = 0; k < order.size(); ++k) {
    order[k] = to_below(random_block(1, Purpose::proposal, 0, 0, k)[0], num_lines);
  }
  return best_seconds([&] { return HWY_DYNAMIC_DISPATCH(run_lines)(lines.data(), order.data(), order.size()); }) /
         static_cast<double>(order.size());
}

}  // namespace noiseloom
#endif
