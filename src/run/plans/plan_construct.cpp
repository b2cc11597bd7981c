// The plan of construction.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <set>

#include "noiseloom/construct/sharpness.h"
#include "noiseloom/construct/slice_construction.h"
#include "noiseloom/core/distribution.h"
#include "noiseloom/dist/halo_plan.h"
#include "noiseloom/problem/colour_classes.h"
#include "noiseloom/samples/space.h"
#include "run/plans/plan_filter.h"
#include "run/plans/plan_memory.h"
#include "run/plans/plan_swap.h"

namespace noiseloom {
namespace {

// What the speed is found with: the same filter in a texture of at most so many pixels, for so long.
constexpr std::int64_t most_constructed_pixels = std::int64_t{1} << 15;
constexpr double constructed_s = 0.25;

// The same texture with its largest axes halved.
Extents reduced(const Extents& extents) {
  std::vector<std::int64_t> sizes;
  std::vector<std::string> names;
  double pixels = 1;
  for (int axis = 0; axis < extents.num_axes(); ++axis) {
    sizes.push_back(extents.size(axis));
    names.push_back(extents.name(axis));
    pixels *= as_double(sizes.back());
  }
  while (pixels > as_double(most_constructed_pixels)) {
    auto& largest = *std::max_element(sizes.begin(), sizes.end());
    pixels /= as_double(largest);
    largest = (largest + 1) / 2;
    pixels *= as_double(largest);
  }
  return Extents(sizes, names);
}

// Seconds a pixel and slice that a pick acts on.
double measured_pick(const Extents& extents, const FilterSpec& filter, SampleScale scale, const ConstructSpec& spec) {
  const Extents small = reduced(extents);
  const Communicator alone = Communicator::self();
  ThreadPool pool(1);
  const Footprint overlap(small, filter);
  SliceConstruction run(overlap, filter, scale, spec, 1, alone, pool);
  const std::clock_t begun = std::clock();
  const auto elapsed_s = [begun] { return static_cast<double>(std::clock() - begun) / CLOCKS_PER_SEC; };
  run.start();
  while (!run.done() && elapsed_s() < constructed_s) run.advance();
  const double picks = std::max(1.0, run.fraction() * as_double(small.num_cells()));
  return elapsed_s() / picks / as_double(std::ssize(overlap.slices()));
}

struct Sharpness {
  double value;
  std::string why;
};

Sharpness sharpness_of(const RunConfig& config, SampleScale scale) {
  if (config.construct.sharpness > 0) return {config.construct.sharpness, "as the config says"};
  const std::vector<SharpnessTrial> trials = try_sharpness(config.problem.extents, config.problem.filter, scale);
  const double best = best_sharpness(trials);
  if (asks_for_blue_noise(config.problem.filter)) return {best, "gauss-energy asks for blue noise"};
  if (trials.empty()) return {best, "the filter reaches no other pixel of a slice"};
  const auto error_at = [&](double sharpness) {
    return std::find_if(trials.begin(), trials.end(), [&](const auto& trial) { return trial.sharpness == sharpness; })
        ->relative_error;
  };
  return {best, fmt::format("found on a small texture, R {:.4f} there; the overlap itself, power 1: {:.4f}",
                            error_at(best), error_at(1))};
}

void describe(const RunConfig& config, const FilterOutline& outline, SampleScale scale, const Sharpness& sharpness,
              RunPlan& plan) {
  const Extents& extents = config.problem.extents;
  plan.method = "construct";
  plan.filter.taps = plan.filter.judged_taps = outline.num_taps;
  plan.filter.coupled_slices = outline.num_coupled_slices();
  plan.filter.exact = outline.is_counted;
  for (int axis = 0; axis < extents.num_axes(); ++axis) {
    const std::int64_t reach = axis < 2 ? outline.plane.reach(axis) : outline.slices.reach(axis);
    plan.filter.reach.push_back(reach);
    plan.axes.push_back(
        {extents.name(axis), reach > 0, reach > 0 ? "" : "no group couples this axis; it costs nothing"});
  }
  const auto effect = [&](const char* name, bool on, std::string why) {
    plan.effects.push_back({name, on, std::move(why)});
  };
  const bool coupled = plan.filter.coupled_slices > 0;
  effect("coupled slices", coupled,
         coupled ? fmt::format("each with {} others", plan.filter.coupled_slices) : "every slice is on its own");
  effect("colour classes", plan.num_classes > 1,
         plan.num_classes > 1 ? fmt::format("{}, one after another", plan.num_classes) : "all slices move at once");
  effect("sharpening", sharpness.value != 1, fmt::format("power {:g} in space: {}", sharpness.value, sharpness.why));
  if (scale == SampleScale::circle) {
    effect("start pattern", true, "half of the pixels of every slice, put into voids and relaxed by swaps");
  } else {
    effect("start pattern", config.construct.density > 0,
           fmt::format("{:g} % of the pixels of every slice, relaxed by swaps", 100 * config.construct.density));
  }
}

}  // namespace

RunPlan plan_construct(const RunConfig& config, const PlanRequest& request) {
  const Extents& extents = config.problem.extents;
  RunPlan plan = plan_basis(config, request);
  const FilterOutline outline = outline_of(extents, config.problem.filter, 0);
  const auto classes = colour_classes(outline.slices);
  plan.num_classes = std::ssize(classes);
  const SampleScale scale = scale_of(config.problem.samples, 1).value();
  const Sharpness sharpness = sharpness_of(config, scale);
  describe(config, outline, scale, sharpness, plan);

  std::vector<Extents::SliceCoord> offsets;
  for (const SliceTaps& slice : outline.slices.slices()) offsets.push_back(slice.offset);
  const Partition partition(extents.num_slices(), request.ranks);
  const std::vector<Rank> looked_at = ranks_to_look_at(request.ranks);
  double told = 0;
  double messages = 0;
  for (const Rank rank : looked_at) {
    const Distribution distribution(partition, rank);
    const HaloPlan halo(extents, offsets, distribution);
    std::set<Rank> peers;
    for (const SliceIndex slice : distribution.own_slices()) {
      peers.insert(halo.listeners(slice).begin(), halo.listeners(slice).end());
    }
    told += as_double(halo.messages_per_sweep());
    messages += as_double(std::ssize(peers)) * as_double(plan.num_classes);
    const PlanRank entry{rank, distribution.num_own(), std::ssize(halo.needed()), 0};
    add_rank(entry, construct_memory(extents, outline, request, entry), plan);
  }
  add_node_bytes(plan);
  const double share = as_double(request.ranks) / as_double(std::ssize(looked_at));
  const auto cells = as_double(extents.cells_per_slice());
  plan.exchange.slice_updates = std::round(told * share);
  plan.exchange.messages = std::round(messages * share);
  plan.exchange.bytes = plan.exchange.slice_updates * cells * 8;  // of the whole run

  std::vector<SliceDataset> datasets = {{"/samples", ElementType::float32, 1, true},
                                        {"/state/permutation", ElementType::uint32, 1, false}};
  if (has_pdf(config.problem.samples)) datasets.push_back({"/pdf", ElementType::float32, 1, false});
  add_file_sizes(config, datasets, plan);

  ConstructSpec spec = config.construct;
  spec.sharpness = sharpness.value;
  const double slices_acted_on = as_double(plan.filter.coupled_slices) + 1;
  const double pick_s = measured_pick(extents, config.problem.filter, scale, spec) * slices_acted_on;
  PlanTime& time = plan.time;
  time.stop = "construction";
  time.candidate_us = pick_s * 1e6;
  const double workers = std::min(as_double(std::ssize(classes.front())), as_double(request.ranks) * request.threads);
  time.moves = as_double(extents.num_cells()) * pick_s / std::max(1.0, 0.9 * workers + 0.1);
  time.start = 0.2;
  // Two nanoseconds a tap and pixel, half of the taps; sorting for the mean distance.
  time.score_s = as_double(extents.num_cells()) * (as_double(outline.num_taps) / 2 * 0.15e-9 + 60e-9);
  time.scores = time.score_s / std::max(1.0, workers);
  time.num_scores = 1;
  time.saves = save_seconds(plan.run_file_bytes) * (1 + std::floor(time.total() / 600));
  time.spread = 2;
  return plan;
}

}  // namespace noiseloom
