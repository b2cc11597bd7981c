#include "run/plans/plan_memory.h"

#include <algorithm>
#include <cmath>

#include "noiseloom/construct/void_and_cluster.h"
#include "noiseloom/files/order_codec.h"
#include "noiseloom/problem/score.h"

namespace noiseloom {
namespace {

constexpr double mebi = 1024.0 * 1024;

// Measured, of a texture of 2x2 (tests/bench/plan_memory.py --only smallest; Open MPI 4.1): one rank by itself; under
// mpirun, where a rank more on the node adds little; a thread. Other networks of MPI take more.
constexpr double alone_bytes = 22 * mebi;
constexpr double launched_bytes = 27 * mebi;
constexpr double peer_bytes = 0.1 * mebi;
constexpr double thread_bytes = 0.1 * mebi;

// A tap of a footprint (offsets and weight), with what vectors keep in reserve; while it is built, with all its
// coordinates and copies of the list.
constexpr double tap_bytes = 24;
constexpr double tap_bytes_while_built = 120;
constexpr double coupled_slice_bytes = 48;

// Swaps a candidate while the run is hot.
constexpr double hot_acceptance = 0.45;

int ranks_on_node(const PlanRequest& request) {
  return request.ranks_per_node > 0 ? std::min(request.ranks_per_node, request.ranks) : request.ranks;
}

std::int64_t round_up(std::int64_t n, std::int64_t multiple) { return (n + multiple - 1) / multiple * multiple; }

// One thread: the copy of the tile and of its transpose, positions of samples both ways, and what of the other slices
// it reads side by side.
double mover_bytes(const SwapSizes& sizes, const FilterOutline& judged) {
  const double cells = as_double(sizes.tile.width * sizes.tile.height);
  const double floats = as_double(sizes.tile.num_floats());
  double bytes = sizes.by_ids ? 4 * 2 * floats + cells * 8 : 4 * floats;
  if (!sizes.tile.whole()) bytes += cells * 16;  // for sorting
  if (sizes.features > 0) {
    const double lanes = as_double(round_up(sizes.features, 16));
    bytes += 4 * (2 * as_double(sizes.tile.plane_size) * sizes.features + 2 * lanes * cells);
    if (!sizes.tile.whole()) bytes += 4 * floats * as_double(std::min<std::int64_t>(judged.num_coupled_slices(), 90));
  } else if (judged.same_pixel_only) {
    bytes += 4 * as_double(round_up(judged.num_coupled_slices(), 16)) * cells * sizes.channels;
  } else {
    bytes += 10 * as_double(judged.num_taps);
  }
  if (sizes.sieve_features > 0) {
    const double lanes = as_double(round_up(sizes.sieve_features, 16));
    const double planes = judged.same_pixel_only && judged.num_coupled_slices() > 0 ? 3 : 2;
    bytes += 4 * (planes * as_double(sizes.tile.plane_size) * sizes.sieve_features + 2 * lanes * cells);
    if (!sizes.tile.whole()) bytes += 4 * floats * as_double(std::min<std::int64_t>(judged.num_coupled_slices(), 90));
  }
  return bytes + 10 * as_double(judged.own_taps);
}

}  // namespace

double program_bytes(const PlanRequest& request) {
  const double ranks = request.ranks == 1 ? alone_bytes : launched_bytes + peer_bytes * (ranks_on_node(request) - 1);
  return ranks + thread_bytes * (request.threads - 1);
}

double bytes_of_node(double writer, double other, const PlanRequest& request) {
  return writer + other * (ranks_on_node(request) - 1);
}

PlanMemory swap_memory(const SwapSizes& sizes, const FilterOutline& scored, const FilterOutline& judged,
                       std::int64_t num_slices, const PlanRequest& request, const PlanRank& rank) {
  const double cells = as_double(sizes.slice.width * sizes.slice.height);
  const double values = 4 * cells * sizes.channels;
  const double ids = 4 * cells;
  const double field = 4 * as_double(sizes.slice.num_floats());
  const double own = as_double(rank.slices);
  const double held = own + as_double(rank.halo_slices);
  const double threads = std::min<double>(request.threads, std::max(1.0, held));
  PlanMemory memory;
  memory.program = program_bytes(request);
  memory.texture = own * (field + (sizes.is_given ? 2 : 1) * ids);
  memory.halo = as_double(rank.halo_slices) * field;
  const double taps = as_double(scored.num_taps + judged.num_taps);
  memory.filter =
      tap_bytes * taps + coupled_slice_bytes * 2 * as_double(scored.num_coupled_slices()) + 4 * sizes.file_samples;
  memory.threads = request.threads * mover_bytes(sizes, judged);

  // Swaps that wait until all of the class have moved, or until they are told.
  const double moving = std::ceil(own / as_double(sizes.num_classes));
  const bool wait = sizes.class_is_coupled || rank.halo_slices > 0;
  const double swaps = 8 * hot_acceptance * as_double(sizes.visit) / 2 * cells;
  memory.at_move = wait ? moving * swaps : threads * swaps / as_double(sizes.num_tiles);

  memory.at_score = held * values;
  const double lists = threads * (values + ids);
  const double samples = as_double(num_slices) * cells;
  // All samples of the texture in double and the list of a slice; or what tasks hold.
  const double numbers = samples * sizes.channels;
  const bool sorts_all = sizes.sorts_for_mean && numbers <= 0x1p26 && rank.rank == Rank(0);
  const double tasks = std::min<double>(request.threads, std::ceil(as_double(sizes.mean_tasks) / request.ranks));
  const double mean = sorts_all ? 8 * numbers + values : tasks * sizes.mean_task_bytes;
  const double resumed = held * ids + own * values;
  memory.at_start = std::max({lists, mean, memory.at_score, resumed,
                              tap_bytes_while_built * as_double(scored.num_taps) - memory.texture - memory.halo,
                              16 * sizes.file_samples - memory.texture - memory.halo,
                              sizes.begins_with_lattice ? memory.at_score + 12 * cells : 0.0});

  // One dataset of one slice after the other: as values and as bytes; densities are found from samples.
  memory.at_save = std::max(2 * values, values + (sizes.has_pdf ? 2 * 4 * cells : 0));
  return memory;
}

PlanMemory order_memory(const VacSpec& spec, double kernel_taps, const PlanRequest& request, const PlanRank& rank) {
  const double cells = as_double(spec.extents.cells_per_slice());
  const double own = as_double(rank.slices) * cells;
  const auto order = static_cast<double>(OrderCodec::for_pixels(spec.extents.num_cells()).bytes_per_pixel());
  PlanMemory memory;
  memory.program = program_bytes(request);
  memory.texture = own * (4 + order);
  memory.filter = 16 * kernel_taps;
  // Bounds of the search; the candidates of all, which every thread files for itself; and the messages that they come
  // in. Windows have few candidates each.
  constexpr double message_bytes = 1.2 * mebi;
  const bool by_windows = vac_division(spec, request.ranks, request.threads).by_windows;
  const double candidates = by_windows ? mebi : as_double(spec.extents.num_cells()) * 1.1;
  memory.threads = own * 2.5 + candidates * request.threads + message_bytes * (ranks_on_node(request) - 1);
  memory.at_save = cells * (4 + order);
  return memory;
}

PlanMemory construct_memory(const Extents& extents, const FilterOutline& overlap, const PlanRequest& request,
                            const PlanRank& rank) {
  const double cells = as_double(extents.cells_per_slice());
  const double own = as_double(rank.slices);
  const double held = own + as_double(rank.halo_slices);
  const double coupled = as_double(overlap.num_coupled_slices()) + 1;
  const double rows = (2 * as_double(overlap.plane.reach(1)) + 1) * coupled;
  PlanMemory memory;
  memory.program = program_bytes(request);
  memory.texture = own * cells * (4 + 4 + 0.2);  // energies, places, bounds
  memory.halo = as_double(rank.halo_slices) * cells * 4;
  memory.filter = tap_bytes * as_double(overlap.num_taps) + coupled_slice_bytes * coupled + rows * (24 + 64);
  const double samples = as_double(extents.num_cells());
  // The mean distance: all samples in double and the list of a slice, or what tasks hold.
  const MeanDistance mean(DistanceKind::absolute, 1, extents.cells_per_slice(), extents.num_slices());
  const double tasks = std::min<double>(request.threads, as_double(mean.num_tasks()));
  const double sorted = samples <= 0x1p26 && rank.rank == Rank(0) ? 8 * samples + 4 * cells : tasks * mean.task_bytes();
  // R: the places of all slices that count for a rank, and their samples; those of one slice twice more on their way.
  memory.at_score = std::max((2 * held + 2) * 4 * cells, sorted);
  // A node of a tree for every tap, while rows are cut.
  memory.at_start = tap_bytes_while_built * as_double(overlap.num_taps);
  memory.at_save = 12 * cells;
  return memory;
}

}  // namespace noiseloom
