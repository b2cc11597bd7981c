// The plan of a construction that is annealed afterwards.
#include <algorithm>
#include <utility>

#include "noiseloom/anneal/cooling.h"
#include "run/jobs/joining.h"
#include "run/plans/plan_memory.h"
#include "run/plans/plan_swap.h"

namespace noiseloom {
namespace {

PlanEffect annealing(const StopSpec& stop) {
  const char* const rule = stop.iterations > 0 ? "stop.iterations"
                           : stop.time_s > 0   ? "stop.time"
                           : stop.score > 0    ? "stop.score"
                                               : "stop.improvement";
  return {
      "annealing", true,
      std::string("of what was constructed, until ") + rule + "; trials at its begin say from where in its schedule"};
}

}  // namespace

// A small texture of the same filter: features, taps and threads are those of the run, slices as much less as they are
// smaller.
void add_trials(const RunConfig& config, RunPlan& plan) {
  const OptimizerSpec& optimizer = config.optimizer;
  if (has_given_temperature(optimizer)) return;
  const double slices = as_double(plan.ranks.front().slices);
  const double cells = std::max(1.0, slices) * as_double(config.problem.extents.cells_per_slice());
  const double share = as_double(extents_of_trials(config).num_cells()) / cells;
  PlanMemory& most = plan.most;
  const double before = most.peak();
  most.at_start = std::max(most.at_start,
                           share * (most.texture + std::max(most.at_score, most.at_move)) + most.filter + most.threads);
  for (PlanRank& rank : plan.ranks) rank.bytes += most.peak() - before;
  add_node_bytes(plan);
  plan.time.moves *= 1 + share_of_trials;
}

RunPlan plan_strata(const RunConfig& config, const PlanRequest& request) {
  RunPlan plan = plan_swaps(config, request, Start::given);
  plan.effects.push_back(
      {"strata over time", true, "constructed first, by every rank alone and on one thread; swaps keep to them"});
  // Energies, places, a tenth of both for bounds, and what fills a pixel of a stack (construct/time_strata.h).
  // Measured: 8 us a pixel of 64x64x16, 15 us of 128x128x64.
  constexpr double bytes_a_pixel = 9;
  constexpr double seconds_a_pixel = 15e-6;
  const double pixels = as_double(config.problem.extents.num_cells());
  PlanMemory& most = plan.most;
  const double before = most.peak();
  most.at_start = std::max(most.at_start, bytes_a_pixel * pixels);
  for (PlanRank& rank : plan.ranks) rank.bytes += most.peak() - before;
  add_node_bytes(plan);
  plan.time.start += seconds_a_pixel * pixels;
  return plan;
}

// One part after the other: the memory of that which needs more, and the time of both.
RunPlan plan_construct_and_anneal(const RunConfig& config, const PlanRequest& request) {
  RunConfig second = config;
  second.optimizer.method = Method::anneal;
  const RunPlan construction = plan_construct(config, request);
  RunPlan plan = plan_swaps(second, request, Start::given);
  add_trials(config, plan);
  plan.method = construction.method;
  for (const PlanEffect& effect : construction.effects) {
    const bool there = std::any_of(plan.effects.begin(), plan.effects.end(),
                                   [&](const PlanEffect& other) { return other.name == effect.name; });
    if (!there) plan.effects.push_back(effect);
  }
  plan.effects.push_back(annealing(config.optimizer.stop));

  if (construction.most.peak() > plan.most.peak()) plan.most = construction.most;
  for (std::size_t k = 0; k < plan.ranks.size(); ++k) {
    plan.ranks[k].bytes = std::max(plan.ranks[k].bytes, construction.ranks[k].bytes);
  }
  plan.node_bytes = std::max(plan.node_bytes, construction.node_bytes);
  plan.time.start += construction.time.total() - construction.time.saves;
  plan.time.spread = std::max(plan.time.spread, construction.time.spread);
  return plan;
}

}  // namespace noiseloom
