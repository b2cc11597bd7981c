// plan: what a run would take, before it is started.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>

#include "noiseloom/anneal/engine_choices.h"
#include "noiseloom/config/config.h"
#include "noiseloom/core/quantity_text.h"
#include "noiseloom/dist/communicator.h"
#include "noiseloom/dist/halo_plan.h"
#include "noiseloom/files/output_probe.h"
#include "noiseloom/samples/sample_space.h"
#include "noiseloom_commands.h"
#include "noiseloom_options.h"
#include "noiseloom_plan.h"

namespace noiseloom {
namespace {

// Share of candidates that are swapped, averaged over a cooling run; what the exchange is estimated from.
constexpr double typical_acceptance = 0.15;

// Seconds for one candidate on this machine, one thread, with its share of taking the tile up: measured on the first
// tile of slice 0 against copies of that slice.
double seconds_per_candidate(const RunConfig& config, const SampleSource& source, const Footprint& footprint) {
  const ProblemSpec& problem = config.problem;
  SliceField field(FieldLayout(footprint, source.channels()));
  field.fill(start_permutation(problem.seed, 0, problem.extents.cells_per_slice()), source.list(0));
  const ValueKernel kernel = make_value_kernel(problem, source.channels(), source.distance());
  const std::optional<FeatureMap> features =
      features_between_slices(config.optimizer, footprint, kernel, source, config.optimizer.background_rank);
  const Method method = config.optimizer.method;
  const WindowSize tile = tiles_for(method, footprint, classes_for(method, footprint)).window();
  const auto delta =
      make_swap_delta(footprint, kernel, config.optimizer.precision, features ? &*features : nullptr, tile);
  const auto begun = std::chrono::steady_clock::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count(); };
  delta->bind(0, field, [&field](SliceIndex) -> const SliceField& { return field; });
  const double bound_s = elapsed();
  const auto cells = static_cast<std::uint64_t>(tile.width * tile.height);
  std::uint64_t candidates = 0;
  double sum = 0;
  while (cells > 1 && elapsed() < bound_s + 0.3) {
    for (int k = 0; k < 64; ++k, ++candidates) {
      const auto i = static_cast<std::uint32_t>(candidates * 7919 % cells);
      const auto j = static_cast<std::uint32_t>((candidates * 7919 + 1) % cells);
      sum += delta->delta({i, j});
    }
  }
  if (candidates == 0 || sum != sum) return 0;
  const auto visit = visit_length(config.optimizer, features.has_value());
  const double visit_candidates = static_cast<double>(visit) * static_cast<double>(cells) / 2;
  return (elapsed() - bound_s) / static_cast<double>(candidates) + bound_s / visit_candidates;
}

struct RankPlan {
  std::int64_t slices;
  std::int64_t halo_slices;
  double bytes;
};

class Plan {
 public:
  Plan(const RunConfig& config, int ranks, int threads)
      : config_(config),
        extents_(config.problem.extents),
        source_(config.problem.samples, extents_.cells_per_slice(), extents_.num_slices(), config.problem.seed),
        footprint_(extents_, config.problem.filter),
        judged_(extents_, config.problem.filter, config.optimizer.cutoff),
        partition_(extents_.num_slices(), ranks),
        threads_(threads),
        background_(features(config.optimizer.background_rank).has_value()),
        tile_(tiles_for(config.optimizer.method, judged_, classes_for(config.optimizer.method, judged_)).window()) {
    for (const SliceTaps& slice : footprint_.slices()) offsets_.push_back(slice.offset);
  }

  void print() const;

 private:
  std::optional<FeatureMap> features(int rank) const {
    const ValueKernel kernel = make_value_kernel(config_.problem, source_.channels(), source_.distance());
    return features_between_slices(config_.optimizer, judged_, kernel, source_, rank);
  }
  RankPlan rank_plan(const HaloPlan& halo, int rank) const;
  void print_effects() const;
  void print_background() const;
  void print_exchange(std::int64_t messages) const;

  const RunConfig& config_;
  const Extents& extents_;
  SampleSource source_;
  Footprint footprint_;  // of R and of the exchange
  Footprint judged_;     // of the energy, cut off
  Partition partition_;
  std::vector<Extents::SliceCoord> offsets_;
  int threads_;
  bool background_;
  WindowSize tile_;
};

// Fields of own and halo slices, ids of own ones, and for scoring another copy of the values. Each thread has copies of
// the tile that it moves (rows, columns, ids both ways) and, with a background, four floats a cell and feature, and
// where the tile is not the whole slice, copies of it in the other slices. The program itself with MPI: 30 MiB.
RankPlan Plan::rank_plan(const HaloPlan& halo, int rank) const {
  const FieldLayout layout(footprint_, source_.channels());
  const auto held = static_cast<double>(partition_.count(rank)) + static_cast<double>(halo.needed().size());
  const double values = static_cast<double>(extents_.cells_per_slice()) * 4;
  const double bytes = held * (static_cast<double>(layout.num_floats()) * 4 + values * source_.channels()) +
                       static_cast<double>(partition_.count(rank)) * values;
  const double features = background_ ? 16.0 * background_rank(config_.optimizer, 1) : 0;
  const FieldLayout tile(judged_, source_.channels(), tile_);
  const double copies = 3 + (background_ && !tile.whole() ? static_cast<double>(offsets_.size()) : 0);
  const double thread = copies * 4 * static_cast<double>(tile.num_floats()) +
                        static_cast<double>(tile.width * tile.height) * (8 + features);
  const double program = 30 * 1024 * 1024;
  return {partition_.count(rank), static_cast<std::int64_t>(halo.needed().size()), program + bytes + threads_ * thread};
}

void Plan::print_effects() const {
  const ProblemSpec& problem = config_.problem;
  fmt::print("texture    {} ({} samples, {} channel{})\n", extents_.to_string(), extents_.num_cells(),
             source_.channels(), source_.channels() == 1 ? "" : "s");
  fmt::print("samples    {}, each of {} slices stratified on its own\n", sample_space_name(problem.samples),
             extents_.num_slices());
  fmt::print("footprint  {} taps, reach", footprint_.num_taps());
  for (int axis = 0; axis < extents_.num_axes(); ++axis)
    fmt::print(" {} {}", extents_.name(axis), footprint_.reach(axis));
  fmt::print("\n");
  if (tile_.width < extents_.width() || tile_.height < extents_.height()) {
    fmt::print("tiles      {} x {} pixels of a slice move at a time\n", tile_.width, tile_.height);
  }
  for (int axis = 0; axis < extents_.num_axes(); ++axis) {
    fmt::print("effect     {}: {}\n", extents_.name(axis),
               footprint_.reach(axis) > 0 ? "on" : "off (no group couples this axis; it costs nothing)");
  }
}

// At the start, in the last quarter and in the last twentieth.
void Plan::print_background() const {
  if (!background_) return;
  std::string text;
  for (const double fraction : {0.0, 0.8, 1.0}) {
    const FeatureMap map = *features(background_rank(config_.optimizer, fraction));
    text += fmt::format("{}{} ({:.2g} %)", text.empty() ? "" : ", ", map.num_features(), 100 * map.missed());
  }
  fmt::print("background other slices act through {} features (and the share of the variance that they miss)\n", text);
}

void Plan::print_exchange(std::int64_t messages) const {
  if (!footprint_.couples_slices()) {
    fmt::print("exchange   none: slices are not coupled\n");
  } else if (partition_.num_ranks() == 1) {
    fmt::print("exchange   none: one rank\n");
  } else {
    const auto iterations = static_cast<double>(visit_length(config_.optimizer, background_));
    const auto cells = static_cast<double>(extents_.cells_per_slice());
    const double swaps = std::min(cells, iterations * typical_acceptance * cells / 2);
    fmt::print("exchange   {} slice updates a sweep, about {} (8 B a swap, {:.0f} % of the candidates)\n", messages,
               bytes_text(static_cast<double>(messages) * swaps * 8), 100 * typical_acceptance);
  }
}

void Plan::print() const {
  print_effects();
  print_background();
  std::int64_t messages = 0;
  double most = 0;
  const int ranks = partition_.num_ranks();
  fmt::print("ranks      {}\n", ranks);
  for (int rank = 0; rank < ranks; ++rank) {
    const HaloPlan halo(extents_, offsets_, partition_, rank);
    messages += halo.messages_per_sweep();
    const RankPlan plan = rank_plan(halo, rank);
    most = std::max(most, plan.bytes);
    if (ranks <= 16 || rank < 4 || rank + 2 >= ranks) {
      fmt::print("  rank {:4}  {} slices, {} halo slices, {}\n", rank, plan.slices, plan.halo_slices,
                 bytes_text(plan.bytes));
    } else if (rank == 4) {
      fmt::print("  ...\n");
    }
  }
  fmt::print("memory     at most {} a rank of {} thread{}\n", bytes_text(most), threads_, threads_ == 1 ? "" : "s");
  print_exchange(messages);
  const double file =
      static_cast<double>(extents_.num_cells()) * (4.0 * source_.channels() + 4 + (source_.has_pdf() ? 4 : 0));
  print_run_file(file);

  const double each = seconds_per_candidate(config_, source_, judged_);
  const double sweep = each * static_cast<double>(extents_.num_cells()) / 2;
  const auto classes = classes_for(config_.optimizer.method, judged_).size();
  const double busy =
      std::min<double>(ranks, static_cast<double>(extents_.num_slices()) / static_cast<double>(classes));
  fmt::print("speed      {:.3g} us a candidate, measured here on one thread; {} colour class{}\n", each * 1e6, classes,
             classes == 1 ? "" : "es");
  if (config_.optimizer.stop.iterations > 0) {
    fmt::print("time       about {} for {} iterations on {} rank{} of one thread\n",
               duration_text(sweep * static_cast<double>(config_.optimizer.stop.iterations) / std::max(1.0, busy)),
               config_.optimizer.stop.iterations, ranks, ranks == 1 ? "" : "s");
  } else {
    fmt::print("time       one iteration takes about {} on one thread\n", duration_text(sweep));
  }
}

}  // namespace

void print_run_file(double bytes) {
  const auto at_a_save = static_cast<double>(bytes_needed(static_cast<std::uint64_t>(bytes)));
  fmt::print("run file   {}; a save needs {} on disk, for it and two generations before it\n", bytes_text(bytes),
             bytes_text(at_a_save));
}

int run_plan(int argc, char** argv) {
  if (std::string(argv[1]) == "--help-config") {
    fmt::print("{}", describe_settings());
    return exit_done;
  }
  CLI::App app("Says what a run would take (memory, messages, time) and which effects are on, without starting it.");
  app.name("noiseloom plan");
  std::string path;
  std::vector<std::string> overrides;
  int ranks = 1;
  int threads = 1;
  app.add_option("CONFIG", path, "config (TOML)")->required();
  app.add_option("--ranks", ranks, "MPI ranks to plan for (default 1)");
  app.add_option("--threads", threads, "threads of each rank (default 1)");
  app.add_option("--set", overrides, "override a setting, as for generate")->allow_extra_args(false);
  if (const auto status = read_options(app, argc - 1, argv + 1)) return *status;
  if (threads < 1) throw UserError("command line", fmt::format("--threads {}: must be at least 1", threads));
  if (ranks < 1) throw UserError("command line", fmt::format("--ranks {}: must be at least 1", ranks));
  const RunConfig config = load_config(path, overrides);
  if (config.optimizer.method == Method::void_and_cluster) {
    MpiSession session(argc, argv);
    print_order_plan(config, ranks, threads);
  } else {
    Plan(config, ranks, threads).print();
  }
  return exit_done;
}

}  // namespace noiseloom
