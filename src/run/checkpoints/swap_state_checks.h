// Whether the state and history of a run by swaps, as a run file has them, make sense under the config of the run.
#pragma once

#include "noiseloom/anneal/swap_state.h"
#include "noiseloom/config/config.h"
#include "run/checkpoints/checkpoint_parts.h"

namespace noiseloom {

// Adds what no such run can have.
void check_swap_state(const SwapState& state, const RunConfig& config, ContentFaults& faults);

}  // namespace noiseloom
