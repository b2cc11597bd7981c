// The plan of a run that swaps samples: anneal and fast.
#include "run/plans/plan_swap.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "noiseloom/anneal/swap_choices.h"
#include "noiseloom/dist/halo_plan.h"
#include "noiseloom/files/npy.h"
#include "noiseloom/problem/score.h"
#include "noiseloom/samples/space.h"
#include "run/checkpoints/checkpoint_parts.h"
#include "run/plans/plan_filter.h"
#include "run/plans/plan_memory.h"
#include "run/plans/plan_speed.h"

namespace noiseloom {
namespace {

// Between ranks of one machine or a fast network, measured on this kind of machine.
constexpr double exchanged_bytes_per_second = 1e9;
constexpr double message_s = 5e-6;
// Two threads of a core, or cores that share the memory's bandwidth, do less than twice the work of one.
constexpr double share_of_further_threads = 0.9;
constexpr double permuted_sample_s = 15e-9;
constexpr double program_start_s = 0.1;
constexpr double checkpoint_every_s = 600;
constexpr int most_features = 64;

constexpr double score_shown_share = 0.02;

// What R in float takes of what it takes in double.
double quick_score(DistanceKind kind) {
  switch (kind) {
    case DistanceKind::angle:
      return 0.09;
    case DistanceKind::absolute:
    case DistanceKind::circle:
      return 0.33;
    default:
      return 0.24;
  }
}

// What is known of the samples without making them.
struct Samples {
  int channels;
  DistanceKind distance;
  bool has_pdf;
  double file_values = 0;
  bool shared = true;
};

Samples samples_of(const ProblemSpec& problem) {
  SampleSpec spec = problem.samples;
  double file_values = 0;
  bool shared = true;
  if (spec.is_file()) {
    const std::int64_t n = problem.extents.cells_per_slice();
    const std::vector<std::int64_t> shape = read_npy_shape(spec.file);
    const std::int64_t channels = num_channels(spec, n, problem.extents.num_slices());
    file_values = 1;
    for (const std::int64_t size : shape) file_values *= as_double(size);
    // Small enough to be read whole, it is checked as generate does.
    constexpr double read_whole = 1 << 22;
    if (file_values <= read_whole) SampleSource(spec, n, problem.extents.num_slices(), problem.seed);
    shared = file_values == as_double(n * channels);
    spec.channels = static_cast<int>(std::clamp<std::int64_t>(channels, 1, 8));
  }
  return {num_channels(spec), distance_kind(spec, num_channels(spec)), has_pdf(spec), file_values, shared};
}

class SwapPlan {
 public:
  SwapPlan(const RunConfig& config, const PlanRequest& request, Start start);
  RunPlan make();

 private:
  bool with_features() const {
    return optimizer_.background_features > 0 &&
           wants_features(optimizer_, judged_.is_product, judged_.num_taps, judged_.own_taps);
  }
  bool with_sieve() const {
    const ValueKernel kernel = make_value_kernel(config_.problem, samples_.channels, samples_.distance);
    return wants_sieve(optimizer_, kernel, judged_.is_product || judged_.same_pixel_only, judged_.own_taps);
  }
  void describe();
  void add_ranks();
  void add_exchange();
  void add_files();
  void add_time();
  SwapSizes sizes() const;
  double steps_of_units(double units) const;
  double score_seconds() const;
  double start_seconds() const;
  double sweep_seconds() const;

  const RunConfig& config_;
  Start start_;
  const OptimizerSpec& optimizer_;
  const Extents& extents_;
  Samples samples_;
  FilterOutline scored_;  // of R and of what ranks tell each other
  double cutoff_;
  FilterOutline judged_;  // of the energy, cut off
  std::vector<std::vector<SliceIndex>> classes_;
  TileGrid tiles_;
  Partition partition_;
  PlanSpeed speed_;
  RunPlan plan_;
  double most_slices_;  // of a rank
};

SwapPlan::SwapPlan(const RunConfig& config, const PlanRequest& request, Start start)
    : config_(config),
      start_(start),
      optimizer_(config.optimizer),
      extents_(config.problem.extents),
      samples_(samples_of(config.problem)),
      scored_(outline_of(extents_, config.problem.filter, 0)),
      cutoff_(energy_cutoff(optimizer_)),
      judged_(cutoff_ > 0 ? outline_of(extents_, config.problem.filter, cutoff_) : scored_),
      classes_(classes_for(optimizer_.method, judged_.slices)),
      tiles_(tiles_for(optimizer_, judged_.plane, classes_)),
      partition_(extents_.num_slices(), request.ranks),
      speed_(measure_speed(config, judged_, tiles_.window(), samples_.channels, samples_.distance)),
      plan_(plan_basis(config, request)),
      most_slices_(partition_.count(0)) {}

RunPlan SwapPlan::make() {
  describe();
  add_ranks();
  add_exchange();
  add_files();
  add_time();
  return std::move(plan_);
}

void SwapPlan::describe() {
  plan_.method = optimizer_.method == Method::fast ? "fast" : "anneal";
  plan_.channels = samples_.channels;
  plan_.filter.taps = scored_.num_taps;
  plan_.filter.judged_taps = with_features() ? judged_.own_taps : judged_.num_taps;
  plan_.filter.coupled_slices = scored_.num_coupled_slices();
  plan_.filter.exact = scored_.is_counted && judged_.is_counted;
  for (int axis = 0; axis < extents_.num_axes(); ++axis) {
    const std::int64_t reach = axis < 2 ? scored_.plane.reach(axis) : scored_.slices.reach(axis);
    plan_.filter.reach.push_back(reach);
    plan_.axes.push_back(
        {extents_.name(axis), reach > 0, reach > 0 ? "" : "no group couples this axis; it costs nothing"});
  }
  plan_.features = speed_.features;
  plan_.tile_width = tiles_.window().width;
  plan_.tile_height = tiles_.window().height;
  plan_.num_tiles = tiles_.num_tiles();
  plan_.num_classes = std::ssize(classes_);
  plan_.iterations_per_sweep = visit_length(optimizer_, extents_.num_cells(), with_features(), with_sieve());

  const auto effect = [&](const char* name, bool on, std::string why) {
    plan_.effects.push_back({name, on, std::move(why)});
  };
  const bool coupled = scored_.num_coupled_slices() > 0;
  effect("coupled slices", coupled,
         coupled ? fmt::format("each with {} others", scored_.num_coupled_slices()) : "every slice is on its own");
  effect("features", with_features(),
         with_features() ? "stand for the other slices; the slice itself goes by its exact taps"
         : coupled       ? "all taps are exact"
                         : "no other slices to stand for");
  effect("sieve", with_sieve(),
         with_sieve() ? "candidates are estimated first; only those that may be accepted are judged by all taps"
                      : "every candidate is judged by all taps");
  effect("tiles", plan_.num_tiles > 1,
         plan_.num_tiles > 1 ? fmt::format("{} of a slice, {} x {} pixels each, move at a time", plan_.num_tiles,
                                           plan_.tile_width, plan_.tile_height)
                             : "a slice moves as a whole");
  effect("colour classes", plan_.num_classes > 1,
         plan_.num_classes > 1 ? fmt::format("{}, one after another", plan_.num_classes) : "all slices move at once");
  effect("cut-off", cutoff_ > 0,
         cutoff_ > 0 ? fmt::format("taps below {} of the largest{} judge no candidate", cutoff_,
                                   config_.problem.filter.combine == Combine::sum ? " of their group" : "")
                     : "every tap judges");
  effect("double precision", optimizer_.precision == Precision::float64,
         optimizer_.precision == Precision::float64 ? "candidates are judged in double"
                                                    : "candidates are judged in float");
  effect("density", samples_.has_pdf, samples_.has_pdf ? "stored with the samples, as /pdf" : "constant, not stored");
  effect("list of samples", samples_.file_values > 0,
         samples_.file_values == 0 ? "samples are drawn, one from each stratum"
         : samples_.shared         ? "one file's samples in every slice"
                                   : "one list of a file for each slice");
}

SwapSizes SwapPlan::sizes() const {
  int features = 0;
  for (const PlanFeatures& moment : speed_.features) features = std::max(features, moment.count);
  if (with_features() && features == 0) features = most_features;
  const MeanDistance mean(samples_.distance, samples_.channels, extents_.cells_per_slice(), extents_.num_slices());
  return {.slice = FieldLayout(judged_.plane, samples_.channels),
          .tile = FieldLayout(judged_.plane, samples_.channels, tiles_.window()),
          .num_tiles = tiles_.num_tiles(),
          .num_classes = std::ssize(classes_),
          .by_ids = optimizer_.method == Method::anneal,
          .class_is_coupled =
              optimizer_.method == Method::fast || (judged_.num_coupled_slices() > 0 && classes_.front().size() > 1),
          .features = features,
          .sieve_features = with_sieve() ? optimizer_.sieve_features : 0,
          .channels = samples_.channels,
          .sorts_for_mean = mean_is_sorted(samples_.distance),
          .mean_tasks = mean.num_tasks(),
          .mean_task_bytes = mean.task_bytes(),
          .has_pdf = samples_.has_pdf,
          .is_given = start_ == Start::given,
          .visit = plan_.iterations_per_sweep,
          .file_samples = samples_.file_values,
          .begins_with_lattice = config_.start.pattern == StartPattern::lattice};
}

void SwapPlan::add_ranks() {
  std::vector<Extents::SliceCoord> offsets;
  for (const SliceTaps& slice : scored_.slices.slices()) offsets.push_back(slice.offset);
  const SwapSizes sizes = this->sizes();
  const std::vector<Rank> looked_at = ranks_to_look_at(plan_.request.ranks);
  for (const Rank rank : looked_at) {
    const Distribution distribution(partition_, rank);
    const HaloPlan halo(extents_, offsets, distribution);
    plan_.exchange.slice_updates += as_double(halo.messages_per_sweep());
    std::set<Rank> peers;
    for (const SliceIndex slice : distribution.own_slices()) {
      peers.insert(halo.listeners(slice).begin(), halo.listeners(slice).end());
    }
    // One message for each peer and class, where as many slices are told.
    plan_.exchange.messages +=
        std::min(as_double(halo.messages_per_sweep()), as_double(std::ssize(peers)) * as_double(plan_.num_classes));
    const PlanRank entry{rank, distribution.num_own(), std::ssize(halo.needed()), 0};
    add_rank(entry, swap_memory(sizes, scored_, judged_, extents_.num_slices(), plan_.request, entry), plan_);
  }
  add_node_bytes(plan_);
  const double share = as_double(plan_.request.ranks) / as_double(std::ssize(looked_at));
  plan_.exchange.slice_updates = std::round(plan_.exchange.slice_updates * share);
  plan_.exchange.messages = std::round(plan_.exchange.messages * share);
}

// A hot visit's swaps are told as what they come to: fewer than cells.
void SwapPlan::add_exchange() {
  const auto cells = as_double(extents_.cells_per_slice());
  const double swaps = std::min(cells, as_double(plan_.iterations_per_sweep) * typical_acceptance * cells / 2);
  plan_.exchange.bytes = plan_.exchange.slice_updates * swaps * 8;
}

void SwapPlan::add_files() {
  const std::vector<SliceDataset> datasets = datasets_for(samples_.channels, samples_.has_pdf, start_ == Start::given);
  add_file_sizes(config_, datasets, plan_);
}

// How many times one after another, where a rank has so many pieces of work at a time.
double SwapPlan::steps_of_units(double units) const {
  const double threads = std::min<double>(plan_.request.threads, std::max(1.0, units));
  return std::max(std::ceil(units / threads), units / (1 + (threads - 1) * share_of_further_threads));
}

// Slices are shared out among threads whole.
double SwapPlan::score_seconds() const {
  const double slice = speed_.score_tap * as_double(scored_.num_taps) / 2 * as_double(extents_.cells_per_slice());
  return slice * steps_of_units(most_slices_);
}

double SwapPlan::start_seconds() const {
  const auto cells = as_double(extents_.cells_per_slice());
  const MeanDistance mean(samples_.distance, samples_.channels, extents_.cells_per_slice(), extents_.num_slices());
  const bool sorted = mean_is_sorted(samples_.distance);
  const double samples = cells * extents_.num_slices();
  const double work =
      speed_.pair * (sorted ? samples * std::max(1.0, std::log2(samples) / 14) : as_double(mean.num_pairs()));
  const double workers =
      std::min(as_double(mean.num_tasks()), std::min<double>(plan_.request.ranks, extents_.num_slices()) *
                                                (1 + (plan_.request.threads - 1) * share_of_further_threads));
  const double halo = plan_.ranks.empty() ? 0 : as_double(plan_.ranks.front().halo_slices);
  const double lists = cells * steps_of_units(most_slices_ + halo) * (speed_.sample + permuted_sample_s);
  return program_start_s + lists + (work + samples * speed_.sample) / std::max(1.0, workers);
}

double SwapPlan::sweep_seconds() const {
  const auto cells = as_double(extents_.cells_per_slice());
  const double tiles = as_double(plan_.num_tiles);
  const double tile_cells = as_double(plan_.tile_width * plan_.tile_height);
  const double unit =
      cells / tiles * as_double(plan_.iterations_per_sweep) / 2 * speed_.candidate + tile_cells * speed_.bind;
  // The slices of a class are spread over the ranks as they come.
  double steps = 0;
  const double ranks = std::min<double>(plan_.request.ranks, extents_.num_slices());
  for (const auto& members : classes_)
    steps += steps_of_units(std::ceil(as_double(std::ssize(members)) / ranks) * tiles);
  return steps * unit;
}

void SwapPlan::add_time() {
  const StopSpec& stop = optimizer_.stop;
  PlanTime& time = plan_.time;
  time.stop = stop.time_s > 0 ? "time" : stop.score > 0 ? "score" : stop.improvement > 0 ? "improvement" : "iterations";
  // Without a count of its own, a thousand iterations stand for the run.
  time.iterations = optimizer_.stop.iterations > 0 ? optimizer_.stop.iterations : 1000;
  const double sweeps = std::ceil(as_double(time.iterations) / as_double(plan_.iterations_per_sweep));
  time.candidate_us = speed_.candidate * 1e6;
  time.score_s = score_seconds();
  const double worth = iterations_per_score(samples_.distance, scored_.num_taps, true,
                                            with_features() ? judged_.own_taps : judged_.num_taps);
  time.num_scores = std::min<std::int64_t>(static_cast<std::int64_t>(sweeps), scores_per_round(worth, time.iterations));
  time.start = start_seconds() + time.score_s;
  time.moves = sweeps * sweep_seconds();
  // In float for the history and for people to see; in double at the end.
  const double quick = quick_score(samples_.distance) * time.score_s;
  time.scores =
      as_double(time.num_scores) * quick + std::min(time.moves, time.moves * score_shown_share + quick) + time.score_s;
  const double ranks = std::max(1, plan_.request.ranks);
  time.exchange = sweeps * (plan_.exchange.bytes / ranks / exchanged_bytes_per_second +
                            plan_.exchange.messages / ranks * message_s);
  const double busy_s = time.start + time.moves + time.scores + time.exchange;
  time.saves = save_seconds(plan_.run_file_bytes) * (1 + std::floor(busy_s / checkpoint_every_s));
  time.spread = plan_.request.ranks * plan_.request.threads > 1 ? 1.6 : 1.4;
}

}  // namespace

RunPlan plan_swaps(const RunConfig& config, const PlanRequest& request, Start start) {
  return SwapPlan(config, request, start).make();
}

}  // namespace noiseloom
