#pragma once

#include <memory>

#include "noiseloom/anneal/swap_delta.h"

namespace noiseloom {

// make_swap_delta for Precision::float32.
std::unique_ptr<SwapDelta> make_float_delta(const Footprint& footprint, const ValueKernel& kernel, WindowSize window,
                                            const FeatureMap* between_slices, const FeatureMap* sieve);

}  // namespace noiseloom
