// The lattice that a run begins with (optimizer.start.pattern).
#pragma once

#include "noiseloom/config/config.h"
#include "noiseloom/construct/lattice.h"

namespace noiseloom {

// `channels`: of the samples. Throws UserError where they are not scalars that are compared by their difference.
Lattice start_lattice(const RunConfig& config, int channels);

}  // namespace noiseloom
