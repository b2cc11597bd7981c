// What plan prints for a method of its own.
#pragma once

#include "noiseloom/config/config.h"

namespace noiseloom {

// Void and cluster. MPI must be initialised.
void print_order_plan(const RunConfig& config, int ranks, int threads);

}  // namespace noiseloom
