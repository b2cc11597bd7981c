// The plans of the methods, and what they share.
#pragma once

#include <vector>

#include "noiseloom/files/run_file.h"
#include "noiseloom/run/plan.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {

// Whether a run begins with an arrangement that it is given, or at random.
enum class Start { random, given };
RunPlan plan_swaps(const RunConfig& config, const PlanRequest& request, Start start);  // anneal and fast
RunPlan plan_order(const RunConfig& config, const PlanRequest& request);               // void and cluster
RunPlan plan_construct(const RunConfig& config, const PlanRequest& request);           // without a stop rule
// Adds the trials of how hot annealing may begin (src/run/jobs/joining.h), which every rank makes for itself.
void add_trials(const RunConfig& config, RunPlan& plan);
// Strata over time are constructed first, by every rank for itself.
RunPlan plan_strata(const RunConfig& config, const PlanRequest& request);
RunPlan plan_construct_and_anneal(const RunConfig& config, const PlanRequest& request);

// What needs no more than the config.
RunPlan plan_basis(const RunConfig& config, const PlanRequest& request);
// All ranks, or some that stand for the rest, the first and the last among them: by symmetry all others are like them.
std::vector<Rank> ranks_to_look_at(int ranks);
// Adds a rank that needs that memory; after the last, the bytes of the node follow from them (rank 0 is the first, and
// writes).
void add_rank(PlanRank rank, PlanMemory memory, RunPlan& plan);
void add_node_bytes(RunPlan& plan);
// The run file, and what is on disk at a save.
void add_file_sizes(const RunConfig& config, const std::vector<SliceDataset>& datasets, RunPlan& plan);
double save_seconds(double run_file_bytes);

}  // namespace noiseloom
