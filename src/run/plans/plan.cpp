#include "noiseloom/run/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "noiseloom/config/inputs.h"
#include "noiseloom/core/stopwatch.h"
#include "noiseloom/files/output_probe.h"
#include "noiseloom/samples/sample_space.h"
#include "run/jobs/start_lattice.h"
#include "run/plans/plan_memory.h"
#include "run/plans/plan_swap.h"

namespace noiseloom {

// What threads work with is first touched when slices move.
double PlanMemory::peak() const {
  return held() + std::max(at_start, threads + std::max({at_move, at_score, at_save}));
}

// Finds it, as every rank will.
static void add_lattice(const RunConfig& config, RunPlan& plan) {
  const Stopwatch watch;
  const Extents& extents = config.problem.extents;
  const int channels = num_channels(config.problem.samples, extents.cells_per_slice(), extents.num_slices());
  const Lattice lattice = *start_lattice(config, channels);
  std::string cycles;
  for (int axis = 0; axis < extents.num_axes(); ++axis) {
    const std::int64_t of_axis = lattice.cycles[static_cast<std::size_t>(axis)];
    cycles += fmt::format("{}{} along {}", axis == 0 ? "" : ", ", of_axis, extents.name(axis));
  }
  plan.effects.push_back(
      {"lattice", true,
       fmt::format("to begin with; cycles: {}; R about {:.3g} with uniform samples", cycles, lattice.relative_error)});
  plan.time.start += watch.seconds();
}

RunPlan plan_run(const RunConfig& config, const PlanRequest& request) {
  std::vector<Fault> faults;
  const auto at_least_one = [&](const char* option, int value, int least) {
    if (value < least)
      faults.push_back({"command line", fmt::format("{} {}: must be at least {}", option, value, least)});
  };
  at_least_one("--ranks", request.ranks, 1);
  at_least_one("--threads", request.threads, 1);
  at_least_one("--ranks-per-node", request.ranks_per_node, 0);
  throw_if_any(std::move(faults));
  if (config.optimizer.method == Method::automatic) {
    RunConfig settled = config;
    settle_method(settled);
    return plan_run(settled, request);
  }
  switch (config.optimizer.method) {
    case Method::void_and_cluster:
      return plan_order(config, request);
    case Method::construct:
      return config.optimizer.stop.is_none() ? plan_construct(config, request)
                                             : plan_construct_and_anneal(config, request);
    default: {
      if (config.optimizer.strata > 1) return plan_strata(config, request);
      if (!config.start.is_given()) return plan_swaps(config, request, Start::random);
      RunPlan plan = plan_swaps(config, request, Start::given);
      if (config.start.pattern == StartPattern::lattice) add_lattice(config, plan);
      add_trials(config, plan);
      return plan;
    }
  }
}

RunPlan plan_basis(const RunConfig& config, const PlanRequest& request) {
  const Extents& extents = config.problem.extents;
  RunPlan plan;
  plan.texture = extents.to_string();
  plan.samples = describe_samples(config.problem.samples);
  plan.pixels = extents.num_cells();
  plan.num_slices = extents.num_slices();
  plan.request = request;
  plan.input_bytes = inputs_memory(config);
  plan.idle_ranks = std::max(0, request.ranks - extents.num_slices());
  for (int axis = 0; axis < extents.num_axes(); ++axis) plan.axis_names.push_back(extents.name(axis));
  for (InputNote& note : notes_on_inputs(config)) {
    plan.effects.push_back({std::move(note.subject), true, std::move(note.text)});
  }
  return plan;
}

std::vector<Rank> ranks_to_look_at(int ranks) {
  constexpr int most_looked_at = 32;
  std::vector<Rank> some;
  for (int k = 0; k < std::min(ranks, most_looked_at); ++k) {
    const double place = ranks <= most_looked_at ? k : std::round(double(k) * (ranks - 1) / (most_looked_at - 1));
    some.push_back(Rank(static_cast<int>(place)));
  }
  return some;
}

void add_rank(PlanRank rank, PlanMemory memory, RunPlan& plan) {
  memory.inputs = plan.input_bytes;
  rank.bytes = memory.peak();
  if (rank.bytes > plan.most.peak()) plan.most = memory;
  plan.ranks.push_back(rank);
}

void add_node_bytes(RunPlan& plan) {
  double other = 0;
  for (std::size_t k = 1; k < plan.ranks.size(); ++k) other = std::max(other, plan.ranks[k].bytes);
  plan.node_bytes = bytes_of_node(plan.ranks.front().bytes, other - plan.input_bytes, plan.request);
}

void add_file_sizes(const RunConfig& config, const std::vector<SliceDataset>& datasets, RunPlan& plan) {
  const std::uint64_t file =
      run_file_bytes(config.problem.extents, datasets, to_toml(config).size() + inputs_bytes(config));
  plan.run_file_bytes = static_cast<double>(file);
  plan.disk_bytes = static_cast<double>(bytes_needed(file));
}

double save_seconds(double run_file_bytes) {
  // A digest of everything, written and synced; measured on this kind of machine's disk.
  constexpr double bytes_per_second = 300e6;
  constexpr double each_s = 0.02;
  return each_s + run_file_bytes / bytes_per_second;
}

}  // namespace noiseloom
