// R of the slices that the optimiser by swaps holds.
#pragma once

#include "anneal/float_score.h"
#include "anneal/held_slices.h"
#include "noiseloom/anneal/texture_score.h"

namespace noiseloom {

// R of the texture as it is now: in double, or by `in_float` where that is given. Needs no swap to be on its way
// (HeldSlices::hear). *Collective*
double texture_error(const Footprint& footprint, const SampleSource& source, double mean_distance,
                     const HeldSlices& slices, const FloatScore* in_float, const Communicator& communicator,
                     ThreadPool& pool);

}  // namespace noiseloom
