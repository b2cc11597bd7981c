// The plan of void and cluster.
#include <algorithm>
#include <cmath>
#include <ctime>

#include "noiseloom/construct/void_and_cluster.h"
#include "noiseloom/core/decimal.h"
#include "noiseloom/core/partition.h"
#include "noiseloom/run/order_checkpoint.h"
#include "run/plans/plan_memory.h"
#include "run/plans/plan_swap.h"

namespace noiseloom {
namespace {

// What the speed is found with: picks of the same filter in a texture of at most so many pixels, for so long.
constexpr std::int64_t most_ordered_pixels = std::int64_t{1} << 16;
constexpr double ordered_s = 0.3;
constexpr std::int64_t picks_at_a_time = 1024;
// A swap takes as long as some five places; there are 0.33 to 0.46 for every point in the configs of this repository.
constexpr double swap_cost = 5;
constexpr double usual_swaps_per_point = 0.4;

// Offsets that a pick changes: where the Gaussian does not round to zero in fixed point of about 24 bits.
double num_taps(const VacSpec& spec, const Extents& extents) {
  double taps = 0;
  for (const VacGroup& group : spec.groups) {
    const double reach = group.sigma_px * std::sqrt(2 * std::max(0.0, 25 * std::log(2) + std::log(group.weight)));
    double box = 1;
    for (const int axis : group.axes) {
      box *= std::min(as_double(extents.size(axis)), 2 * std::floor(reach) + 1);
    }
    taps += box;
  }
  return taps;
}

// The same texture with its largest axes halved.
VacSpec reduced(const VacSpec& spec) {
  std::vector<std::int64_t> sizes;
  for (int axis = 0; axis < spec.extents.num_axes(); ++axis) sizes.push_back(spec.extents.size(axis));
  const auto pixels = [&] {
    double product = 1;
    for (const std::int64_t size : sizes) product *= as_double(size);
    return product;
  };
  while (pixels() > as_double(most_ordered_pixels)) {
    auto& largest = *std::max_element(sizes.begin(), sizes.end());
    largest = (largest + 1) / 2;
  }
  VacSpec small = spec;
  small.extents = Extents(sizes);
  return small;
}

struct Measured {
  std::string size;
  double seconds_per_place;
  double swaps_per_point;
  bool whole;  // the texture itself, from beginning to end
};

Measured measure(const VacSpec& spec) {
  const VacSpec small = reduced(spec);
  const Communicator alone = Communicator::self();
  ThreadPool pool(1);
  const std::clock_t begun = std::clock();
  const auto elapsed_s = [begun] { return static_cast<double>(std::clock() - begun) / CLOCKS_PER_SEC; };
  VoidAndCluster run(small, alone, pool);
  run.start();
  while (!run.done() && elapsed_s() < ordered_s) run.advance(picks_at_a_time);
  const VacProgress& progress = run.progress();
  const bool swapped = progress.phase != VacPhase::swap && progress.num_start_points > 0;
  const double per_point =
      swapped ? as_double(progress.num_swaps) / as_double(progress.num_start_points) : usual_swaps_per_point;
  const double work = swap_cost * as_double(progress.num_swaps) + as_double(progress.num_placed);
  const double scale = num_taps(spec, spec.extents) / num_taps(spec, small.extents);
  return {small.extents.to_string(), scale * elapsed_s() / std::max(1.0, work),
          progress.num_start_points > 0 ? per_point : 0, run.done() && small.extents == spec.extents};
}

void describe(const RunConfig& config, const VacSpec& spec, RunPlan& plan) {
  const Extents& extents = spec.extents;
  plan.method = "void-and-cluster";
  for (int axis = 0; axis < extents.num_axes(); ++axis) {
    const auto has_axis = [&](const VacGroup& group) {
      return std::find(group.axes.begin(), group.axes.end(), axis) != group.axes.end();
    };
    const bool on = extents.size(axis) > 1 && std::any_of(spec.groups.begin(), spec.groups.end(), has_axis);
    const bool wraps = spec.toroidal.empty() || spec.toroidal[static_cast<std::size_t>(axis)];
    plan.axes.push_back(
        {extents.name(axis), on, on ? (wraps ? "wraps around" : "bounded") : "white noise along this axis"});
  }
  const OrderSpec& order = config.order;
  const bool by_slice = order.equalize == Equalize::slice;
  plan.effects.push_back(
      {"levels", order.bits > 0,
       order.bits > 0 ? std::to_string(1 << order.bits) + " of them, equally often" : "as fine as float32 holds them"});
  plan.effects.push_back({"equal counts in every slice", by_slice,
                          by_slice ? "samples follow from the order within a slice" : "samples follow from the order"});
  plan.effects.push_back({"bounded axes", !order.bounded.empty(),
                          order.bounded.empty() ? "all axes wrap around" : "these do not wrap around"});
}

}  // namespace

RunPlan plan_order(const RunConfig& config, const PlanRequest& request) {
  const VacSpec spec = vac_spec(config);
  check_vac_spec(spec);
  const Extents& extents = spec.extents;
  RunPlan plan = plan_basis(config, request);
  describe(config, spec, plan);
  const double taps = num_taps(spec, extents);
  plan.filter.taps = plan.filter.judged_taps = static_cast<std::int64_t>(taps);
  plan.filter.exact = false;

  const Partition partition(extents.num_slices(), request.ranks);
  for (const Rank rank : ranks_to_look_at(request.ranks)) {
    const PlanRank entry{rank, partition.count(rank), 0, 0};
    add_rank(entry, order_memory(spec, taps, request, entry), plan);
  }
  add_node_bytes(plan);
  const double pixels = as_double(extents.num_cells());
  add_file_sizes(config, order_run_datasets(config), plan);

  const Measured measured = measure(spec);
  const double points = as_double(decimal_of(spec.density).floor_of_times(extents.num_cells()));
  plan.phases = {points, std::round(points * measured.swaps_per_point), measured.size};
  PlanTime& time = plan.time;
  time.stop = "order";
  time.candidate_us = measured.seconds_per_place * 1e6;
  const VacDivision division = vac_division(spec, request.ranks, request.threads);
  if (request.ranks > 1) {
    // About 17 bytes a pick, in batches of hundreds. As in the summary, what a rank tells all others counts once. Of
    // windows hardly anything travels but the swaps before.
    const double batches = division.by_windows ? 0 : pixels / 256;
    time.exchange = (2 * plan.phases.swaps + batches) * 10e-6 * std::log2(request.ranks);
    plan.exchange.bytes = division.by_windows ? 0 : pixels * 17;
  }
  const double workers = division.workers;
  // Swaps go one after another; the rest is shared out but for what waits for other slices.
  time.moves = swap_cost * plan.phases.swaps * measured.seconds_per_place +
               pixels * measured.seconds_per_place * (0.2 + 0.8 / workers);
  time.start = 0.1 + points * 50e-9;
  time.saves = save_seconds(plan.run_file_bytes) * (1 + std::floor(time.total() / 600));
  time.spread = measured.whole ? 1.3 : 2;
  return plan;
}

}  // namespace noiseloom
