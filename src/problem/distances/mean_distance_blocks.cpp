#include "problem/distances/mean_distance_blocks.h"

#include <algorithm>
#include <cstddef>

#include "noiseloom/core/compensated_sum.h"
#include "noiseloom/problem/score.h"
#include "problem/distances/score_distance.h"

namespace noiseloom {
namespace {

// sum_{i, j} |x_i - x_j|: each gap between neighbours, times the pairs that it separates. All terms are positive.
double sorted_absolute_sum(std::span<const double> x) {
  CompensatedSum sum;
  for (std::size_t below = 1; below < x.size(); ++below) {
    sum.add((x[below] - x[below - 1]) * static_cast<double>(below) * static_cast<double>(x.size() - below));
  }
  return 2 * sum.value();
}

// sum_{i, j} min(d, 1 - d) with d = |x_i - x_j|. As i rises, so does the first j with d > 1/2.
double sorted_circle_sum(std::span<const double> x) {
  CompensatedSum sum;
  CompensatedSum before_i;  // x_0 + ... + x_i
  CompensatedSum before_j;  // x_0 + ... + x_(j-1)
  CompensatedSum all;
  for (const double value : x) all.add(value);
  std::size_t j = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    before_i.add(x[i]);
    for (; j < x.size() && (j <= i || x[j] - x[i] <= 0.5); ++j) before_j.add(x[j]);
    const auto near = static_cast<double>(j - i - 1);
    const auto far = static_cast<double>(x.size() - j);
    sum.add((before_j.value() - before_i.value()) - near * x[i]);
    sum.add(far * (1 + x[i]) - (all.value() - before_j.value()));
  }
  return 2 * sum.value();
}

double sorted_sum(DistanceKind kind, std::span<const double> x) {
  return kind == DistanceKind::circle ? sorted_circle_sum(x) : sorted_absolute_sum(x);
}

std::span<const double> channel_of(const SampleBlock& block, std::size_t c) {
  return std::span(block.values).subspan(c * block.size, block.size);
}

// Samples of b are taken in pieces that stay in the nearest cache.
constexpr std::size_t piece = 1024;

}  // namespace

SampleBlock make_block(DistanceKind kind, int channels, std::span<const float> samples) {
  const auto count = static_cast<std::size_t>(channels);
  SampleBlock block{samples.size() / count, std::vector<double>(samples.size())};
  for (std::size_t i = 0; i < block.size; ++i) {
    for (std::size_t c = 0; c < count; ++c) block.values[c * block.size + i] = samples[i * count + c];
  }
  if (mean_is_sorted(kind)) sort_channels(channels, block);
  return block;
}

void sort_channels(int channels, SampleBlock& block) {
  const auto size = static_cast<std::ptrdiff_t>(block.size);
  for (int c = 0; c < channels; ++c) std::sort(block.values.begin() + c * size, block.values.begin() + (c + 1) * size);
}

double self_distance_sum(DistanceKind kind, int channels, const SampleBlock& block) {
  const auto num_channels = static_cast<std::size_t>(channels);
  if (mean_is_sorted(kind)) {
    double total = 0;
    for (std::size_t c = 0; c < num_channels; ++c) total += sorted_sum(kind, channel_of(block, c));
    return total;
  }
  const RunSum sum = sum_to_first(kind);
  const auto at = [&](std::size_t i) { return SampleRun{block.values.data() + i, block.size}; };
  CompensatedSum with_itself;
  CompensatedSum with_later;
  for (std::size_t begin = 0; begin < block.size; begin += piece) {
    const std::size_t end = std::min(begin + piece, block.size);
    for (std::size_t i = 0; i < end; ++i) {
      const std::size_t first = std::max(begin, i + 1);
      with_later.add(sum(at(i), at(first), end - std::min(first, end), num_channels));
    }
  }
  for (std::size_t i = 0; i < block.size; ++i) {
    with_itself.add(sum(at(i), at(i), 1, num_channels));
  }
  return with_itself.value() + 2 * with_later.value();
}

double cross_distance_sum(DistanceKind kind, int channels, const SampleBlock& a, const SampleBlock& b) {
  if (mean_is_sorted(kind)) {
    double total = 0;
    std::vector<double> both(a.size + b.size);
    for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c) {
      const std::span<const double> of_a = channel_of(a, c);
      const std::span<const double> of_b = channel_of(b, c);
      std::merge(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(), both.begin());
      total += (sorted_sum(kind, both) - sorted_sum(kind, of_a) - sorted_sum(kind, of_b)) / 2;
    }
    return total;
  }
  const RunSum sum = sum_to_first(kind);
  CompensatedSum total;
  for (std::size_t begin = 0; begin < b.size; begin += piece) {
    const std::size_t count = std::min(piece, b.size - begin);
    for (std::size_t i = 0; i < a.size; ++i) {
      total.add(sum({a.values.data() + i, a.size}, {b.values.data() + begin, b.size}, count,
                    static_cast<std::size_t>(channels)));
    }
  }
  return total.value();
}

}  // namespace noiseloom
