// Sums of distances over contiguous runs of samples: the inner loops of problem/score.h.
#pragma once

#include <cstddef>

#include "noiseloom/problem/spec.h"

namespace noiseloom {

// A run of samples as planar doubles: channel c of sample i is values[c * stride + i].
struct SampleRun {
  const double* values;
  std::size_t stride;
  SampleRun from(std::size_t sample) const { return {values + sample, stride}; }
};

// sum_{i < count} of a distance, by the formulas of distance() in samples/sample_space.h. Eight partial sums in a fixed
// order: the same bits whatever vector width the machine has.
using RunSum = double (*)(SampleRun a, SampleRun b, std::size_t count, std::size_t channels);

// Which instructions may be used, where the machine has them.
enum class Widest { avx512, avx2, portable };

// d(a_i, b_i)
RunSum sum_of_pairs(DistanceKind kind, Widest widest = Widest::avx512);
// d(a_0, b_i)
RunSum sum_to_first(DistanceKind kind, Widest widest = Widest::avx512);

}  // namespace noiseloom
