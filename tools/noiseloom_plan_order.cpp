// plan for void and cluster.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>

#include "noiseloom/core/quantity_text.h"
#include "noiseloom/run/order_checkpoint.h"
#include "noiseloom_commands.h"
#include "noiseloom_plan.h"

namespace noiseloom {
namespace {

constexpr std::int64_t most_measured_pixels = std::int64_t{1} << 17;

// Offsets that a pick changes: where the Gaussian does not round to zero in fixed point of about 24 bits.
double num_taps(const VacSpec& spec, const Extents& extents) {
  double taps = 0;
  for (const VacGroup& group : spec.groups) {
    const double reach = group.sigma_px * std::sqrt(2 * 25 * std::log(2));
    double box = 1;
    for (const int axis : group.axes) {
      box *= std::min(static_cast<double>(extents.size(axis)), 2 * std::floor(reach) + 1);
    }
    taps += box;
  }
  return taps;
}

// The same texture with its largest axes halved until it is quickly made.
VacSpec reduced(const VacSpec& spec) {
  std::vector<std::int64_t> sizes;
  for (int axis = 0; axis < spec.extents.num_axes(); ++axis) sizes.push_back(spec.extents.size(axis));
  VacSpec small = spec;
  small.extents = Extents(sizes);
  while (small.extents.num_cells() > most_measured_pixels) {
    auto& largest = *std::max_element(sizes.begin(), sizes.end());
    largest = (largest + 1) / 2;
    small.extents = Extents(sizes);
  }
  return small;
}

struct Measured {
  std::string size;
  double seconds_per_pick;
  double swaps_per_point;
};

// A whole run of the reduced texture on one thread, scaled to the taps of the whole one.
Measured measure(const VacSpec& spec) {
  const VacSpec small = reduced(spec);
  const Communicator alone = Communicator::self();
  ThreadPool pool(1);
  const std::clock_t begun = std::clock();
  VoidAndCluster run(small, alone, pool);
  run.start();
  run.advance(std::numeric_limits<std::int64_t>::max());
  const double took_s = static_cast<double>(std::clock() - begun) / CLOCKS_PER_SEC;
  const VacProgress& progress = run.progress();
  const double taps = num_taps(spec, spec.extents) / num_taps(spec, small.extents);
  const auto points = static_cast<double>(progress.num_start_points);
  return {small.extents.to_string(), took_s * taps / static_cast<double>(progress.num_swaps + progress.num_ranked),
          points > 0 ? static_cast<double>(progress.num_swaps) / points : 0};
}

void print_effects(const RunConfig& config, const VacSpec& spec) {
  const Extents& extents = spec.extents;
  const OrderSpec& order = config.order;
  fmt::print("texture    {} ({} pixels)\n", extents.to_string(), extents.num_cells());
  const std::string divisor =
      std::to_string(order.equalize == Equalize::slice ? extents.cells_per_slice() : extents.num_cells());
  const char* whole = order.equalize == Equalize::slice ? "every slice" : "the volume";
  if (order.bits > 0) {
    fmt::print("samples    {} levels, equally often in {}\n", 1 << order.bits, whole);
  } else {
    fmt::print("samples    (rank in {} + 0.5) / {}, float32\n", whole, divisor);
  }
  for (const VacGroup& group : spec.groups) {
    std::string axes;
    for (const int axis : group.axes) axes += (axes.empty() ? "" : " ") + extents.name(axis);
    fmt::print("energy     gauss-energy over {}, sigma {}\n", axes, group.sigma_px);
  }
  for (int axis = 0; axis < extents.num_axes(); ++axis) {
    const auto has_axis = [&](const VacGroup& group) {
      return std::find(group.axes.begin(), group.axes.end(), axis) != group.axes.end();
    };
    const bool on = extents.size(axis) > 1 && std::any_of(spec.groups.begin(), spec.groups.end(), has_axis);
    const bool wraps = spec.toroidal.empty() || spec.toroidal[static_cast<std::size_t>(axis)];
    fmt::print("effect     {}: {}\n", extents.name(axis),
               on ? (wraps ? "on, wraps around" : "on, bounded") : "off (white noise along this axis)");
  }
}

// Energies and ranks of the own slices, and 3.5 B a pixel for bounds and candidates (peaks measured at 2^20 and 2^24
// pixels). The program itself with MPI: 30 MiB.
double bytes_of_rank(const VacSpec& spec, std::int64_t own_slices, bool wide) {
  const auto own = static_cast<double>(own_slices) * static_cast<double>(spec.extents.cells_per_slice());
  return 30.0 * 1024 * 1024 + own * (4 + (wide ? 8 : 4) + 3.5);
}

}  // namespace

void print_order_plan(const RunConfig& config, int ranks, int threads) {
  const VacSpec spec = vac_spec(config);
  const Extents& extents = spec.extents;
  check_vac_spec(spec);
  print_effects(config, spec);
  const bool wide = extents.num_cells() > std::int64_t{std::numeric_limits<std::uint32_t>::max()} - 1;
  const Partition partition(extents.num_slices(), ranks);
  fmt::print("ranks      {} of {} thread{}\n", ranks, threads, threads == 1 ? "" : "s");
  double most = 0;
  for (int rank = 0; rank < ranks; ++rank) {
    const double bytes = bytes_of_rank(spec, partition.count(rank), wide);
    most = std::max(most, bytes);
    if (ranks <= 16 || rank < 4 || rank + 2 >= ranks) {
      fmt::print("  rank {:4}  {} slices, {}\n", rank, partition.count(rank), bytes_text(bytes));
    } else if (rank == 4) {
      fmt::print("  ...\n");
    }
  }
  fmt::print("memory     at most {} a rank\n", bytes_text(most));
  const auto pixels = static_cast<double>(extents.num_cells());
  fmt::print("exchange   {}\n", ranks == 1 ? "none: one rank" : "candidates for the picks, a batch at a time");
  print_run_file(pixels * (wide ? 12 : 8));

  const Measured measured = measure(spec);
  const double points = std::floor(spec.density * pixels);
  const double swaps = points * measured.swaps_per_point;
  fmt::print("phases     swap: about {:.0f} swaps of {:.0f} points; drain: {:.0f} ranks; fill: {:.0f} ranks\n", swaps,
             points, points, pixels - points);
  fmt::print("speed      {:.3g} us a pick, processor time of one thread here, measured on {}{}\n",
             measured.seconds_per_pick * 1e6, measured.size,
             measured.size == extents.to_string() ? "" : "; slower where the texture leaves the caches");
  fmt::print("time       about {} on one rank of one thread\n",
             duration_text((swaps + pixels) * measured.seconds_per_pick));
}

}  // namespace noiseloom
