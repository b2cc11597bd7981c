// What features make of a texture, by double loops.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "anneal/texture_fixture.h"
#include "noiseloom/anneal/feature_map.h"

namespace noiseloom::test {

// The samples of the first slices.
std::vector<float> samples_of(const Texture& texture, int slices);

// K of two samples: of all of it, and of what features keep; the map must outlive the function.
using PairKernel = std::function<double(const float* a, const float* b)>;
PairKernel full_kernel(const ValueKernel& kernel);
PairKernel kernel_by_features(const FeatureMap& map, int channels);

// dE by the taps of `slices`, by a double loop, with `kernel(a, b)` of samples; the term of the pair itself counts like
// any other. What lies around the pair is that of `around`, where it is given.
double change_by(std::span<const SliceTaps> slices, const Extents& extents, const Texture& texture, SliceIndex slice,
                 CellPair pair, const PairKernel& kernel, const Texture* around = nullptr);

// The share of K', the kernel less its terms of one sample, that f^T A f gets wrong over all pairs of the list: 0 to 1
// of a fit that is of use, and anything above it of one that is not.
double share_wrong(const ValueKernel& kernel, const FeatureMap& map, const std::vector<float>& list);

}  // namespace noiseloom::test
