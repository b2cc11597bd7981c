// The lattice that a run begins with (optimizer.start.pattern).
#pragma once

#include <functional>
#include <optional>

#include "noiseloom/config/config.h"
#include "noiseloom/construct/lattice.h"

namespace noiseloom {

// `channels`: of the samples. Throws UserError where they are not scalars that are compared by their difference, or the
// filter has no tap within a slice. Nothing once goes_on() returns false.
std::optional<Lattice> start_lattice(
    const RunConfig& config, int channels, const std::function<bool()>& goes_on = [] { return true; });

}  // namespace noiseloom
