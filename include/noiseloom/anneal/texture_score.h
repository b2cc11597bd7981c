// R of a texture that is spread over ranks (problem/score.h says what R is): every rank sums over its own slices, and
// all add the sums up in the order of the slices, so that R has the same bits on any number of ranks and threads.
#pragma once

#include <functional>
#include <vector>

#include "noiseloom/core/distribution.h"
#include "noiseloom/core/parallel.h"
#include "noiseloom/dist/communicator.h"
#include "noiseloom/problem/footprint.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {

// m, the mean distance over all pairs of the texture's samples: the same for every arrangement of them. *Collective*
double mean_distance(const SampleSource& source, const Communicator& communicator, ThreadPool& pool);

// R of a texture of which this rank holds the slices `held`: its own (of `distribution`) first, then all that the
// footprint couples with them. `planar(slice)`: their samples, [channel][y][x]. *Collective*
double texture_error(const Footprint& footprint, const SampleSource& source, double mean_distance,
                     const Distribution& distribution, const std::vector<SliceIndex>& held,
                     const std::function<std::vector<float>(SliceIndex)>& planar, const Communicator& communicator,
                     ThreadPool& pool);

}  // namespace noiseloom
