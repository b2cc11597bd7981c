// Distances inside and between blocks of samples: all pairs, by sorting where distances add up over the channels.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "noiseloom/problem/spec.h"

namespace noiseloom {

// A block of samples, planar: [channel][sample]. Each channel ascending where mean_is_sorted().
struct SampleBlock {
  std::size_t size = 0;
  std::vector<double> values;
};

// From interleaved samples [sample][channel].
SampleBlock make_block(DistanceKind kind, int channels, std::span<const float> samples);
// Puts the channels of a block into ascending order, each by itself.
void sort_channels(int channels, SampleBlock& block);

// Sum over all ordered pairs of one block, a sample with itself included.
double self_distance_sum(DistanceKind kind, int channels, const SampleBlock& block);
// Sum over all pairs of a sample of `a` and one of `b`.
double cross_distance_sum(DistanceKind kind, int channels, const SampleBlock& a, const SampleBlock& b);

}  // namespace noiseloom
