// What plan prints for every method, and for a method of its own.
#pragma once

#include "noiseloom/config/config.h"

namespace noiseloom {

// The line about the run file, of `bytes`.
void print_run_file(double bytes);

// Void and cluster. MPI must be initialised.
void print_order_plan(const RunConfig& config, int ranks, int threads);

}  // namespace noiseloom
