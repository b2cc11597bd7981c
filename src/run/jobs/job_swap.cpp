#include "run/jobs/job_swap.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <stdexcept>

#include "noiseloom/construct/time_strata.h"
#include "noiseloom/core/quantity_text.h"
#include "noiseloom/core/stopwatch.h"
#include "noiseloom/files/digest.h"
#include "noiseloom/run/checkpoint.h"
#include "noiseloom/run/stop_signals.h"
#include "noiseloom/samples/sample_space.h"
#include "run/checkpoints/checkpoint_parts.h"
#include "run/checkpoints/start_file.h"
#include "run/jobs/memory_words.h"
#include "run/jobs/start_lattice.h"

namespace noiseloom {
namespace {

constexpr double quick_score_s = 0.5;

OptimizerSpec swaps_of(const RunConfig& config) {
  OptimizerSpec spec = config.optimizer;
  if (spec.method == Method::construct) spec.method = Method::anneal;
  return spec;
}

}  // namespace

Permutation permutation_of(const std::vector<std::uint32_t>& places) {
  Permutation samples(places.size());
  std::transform(places.begin(), places.end(), samples.begin(), [](std::uint32_t place) { return SampleId(place); });
  return samples;
}

SwapJob::SwapJob(const RunConfig& config)
    : config_(config),
      spec_(swaps_of(config)),
      source_(config.problem.samples, config.problem.extents.cells_per_slice(), config.problem.extents.num_slices(),
              config.problem.seed) {}

void SwapJob::prepare(const Communicator& communicator, ThreadPool& pool) {
  communicator_ = &communicator;
  pool_ = &pool;
  communicator.together([&] {
    naming_shortage("taking up filter, features and texture",
                    [&] { optimizer_.emplace(config_.problem, spec_, source_, communicator, pool); });
  });
}

void SwapJob::start(double run_s) {
  if (spec_.strata > 1) return start_from_time_strata(run_s);
  if (!config_.start.is_given()) return optimizer_->start();
  if (config_.start.file.empty()) return start_from_lattice(run_s);
  const Stopwatch watch;
  StartFile start(config_.start.file, config_.problem.extents, source_, optimizer_->slices_held(), *communicator_);
  start_from([&](SliceIndex slice) { return start.take_permutation(slice); }, run_s + watch.seconds());
}

void SwapJob::start_from_lattice(double run_s) {
  const Stopwatch watch;
  const ProblemSpec& problem = config_.problem;
  std::optional<Lattice> lattice;
  std::vector<std::uint32_t> first;
  communicator_->together([&] {
    naming_shortage("finding a lattice", [&] {
      lattice = start_lattice(config_, source_.channels(), [] { return noted_stop_signal() == 0; });
      if (lattice) first = lattice_places(*lattice, problem.extents, problem.seed);
    });
  });
  if (communicator_->any_bits(lattice ? 0U : 1U) != 0) throw StartStopped();
  const auto permutation = [&](SliceIndex slice) {
    const std::uint64_t ahead = places_ahead(*lattice, problem.extents, slice);
    Permutation samples(first.size());
    std::ranges::transform(first, samples.begin(), [&](std::uint64_t place) {
      return SampleId(static_cast<std::uint32_t>((place + ahead) % first.size()));
    });
    return samples;
  };
  start_from(permutation, run_s + watch.seconds());
}

// Scalars are all but done; of other samples their places along a curve are but a start.
void SwapJob::start_from_time_strata(double run_s) {
  const Stopwatch watch;
  const auto now_s = [&] { return run_s + watch.seconds(); };
  const ProblemSpec& problem = config_.problem;
  std::vector<std::vector<std::uint32_t>> places;
  bool stopped = false;
  communicator_->together([&] {
    naming_shortage("constructing strata over time", [&] {
      places = time_strata(problem.extents, problem.filter, problem.extents.axis("t"), 0, problem.seed, [&] {
        stopped = noted_stop_signal() != 0;
        return !stopped;
      });
    });
  });
  if (communicator_->any_bits(stopped ? 1U : 0U) != 0) throw StartStopped();
  optimizer_->start_from([&](SliceIndex slice) { return permutation_of(places[static_cast<std::size_t>(slice)]); },
                         now_s());
  const bool is_scalar = scale_of(problem.samples, source_.channels()) == SampleScale::line;
  if (is_scalar && !optimizer_->finished()) optimizer_->join_cold(now_s());
}

void SwapJob::start_from(const PermutationOf& permutation, double run_s) {
  const Stopwatch watch;
  const auto now_s = [&] { return run_s + watch.seconds(); };
  optimizer_->start_from(permutation, run_s);
  if (optimizer_->finished() || !needs_joining(spec_)) return;
  const std::optional<Joining> joining =
      agree_on_joining(config_, source_, optimizer_->last_score(), spec_.stop.time_s - now_s(), *communicator_, *pool_);
  if (!joining) throw StartStopped();
  join(*joining, now_s());
}

void SwapJob::start_from(const PermutationOf& permutation, const std::optional<Joining>& joining, double run_s) {
  optimizer_->start_from(permutation, run_s);
  if (joining && !optimizer_->finished()) join(*joining, run_s);
}

void SwapJob::join(const Joining& joining, double run_s) {
  if (joining.cold) return optimizer_->join_cold(run_s);
  optimizer_->join_schedule(joining.fraction, run_s);
}

void SwapJob::restore(const RunFileReader* saved) { restore_run(saved, config_, *optimizer_, *communicator_); }

std::string SwapJob::save(const SaveTarget& target) {
  return save_run(posix_file_ops(), target.path, config_, source_, *optimizer_, *communicator_, target.provenance);
}

bool SwapJob::refreshes_quickly() const { return optimizer_->scores_within(quick_score_s); }

std::vector<SliceDataset> SwapJob::datasets() const { return run_datasets(source_, begins_with_arrangement(config_)); }

std::string SwapJob::start_words() const {
  if (spec_.strata > 1) return "constructing strata over time, then the score of that";
  if (config_.start.pattern == StartPattern::lattice) {
    return "finding the lattice, its score, and trials of how hot annealing may begin";
  }
  return begins_with_arrangement(config_)
             ? "taking up the arrangement, its score, and trials of how hot annealing may begin"
             : "placing the samples, then two scores: the mean distance of all samples, and R of the start";
}

std::string SwapJob::title() const {
  return fmt::format("{} of {}, {}", config_.problem.extents.to_string(), describe_samples(config_.problem.samples),
                     spec_.method == Method::fast ? "fast" : "anneal");
}

std::string SwapJob::position() const {
  return fmt::format("iteration {}, {}", optimizer_->iterations(), score_text());
}

// R as last evaluated, and where that was unless it is R now.
std::string SwapJob::score_text() const {
  const std::string at = optimizer_->last_score_is_current()
                             ? ""
                             : fmt::format(" (at iteration {})", optimizer_->last_score_at_iteration());
  return fmt::format("R {:.5f}{}", optimizer_->last_score(), at);
}

// What was made of the arrangement that the run was given, with the proof that it was only rearranged: the samples of
// every slice, laid back into the order of their ids, are the list that the slice began with. *Collective*
std::string SwapJob::given_words() const {
  std::int64_t sums[] = {0, 0};
  const auto channels = static_cast<std::size_t>(source_.channels());
  for (const SliceIndex slice : optimizer_->distribution().own_slices()) {
    const std::vector<float> list = source_.list(slice);
    const std::vector<float> samples = optimizer_->samples(slice);
    std::vector<float> sorted(samples.size());
    std::size_t cell = 0;
    for (const SampleId id : optimizer_->permutation(slice)) {
      std::copy_n(samples.begin() + static_cast<std::ptrdiff_t>(cell++ * channels), channels,
                  sorted.begin() + static_cast<std::ptrdiff_t>(id.value() * channels));
    }
    const auto add = [&](std::int64_t& sum, const std::vector<float>& values) {
      sum = static_cast<std::int64_t>(static_cast<std::uint64_t>(sum) + digest_of(std::as_bytes(std::span(values))));
    };
    add(sums[0], list);
    add(sums[1], sorted);
  }
  communicator_->sum(sums);
  if (sums[0] != sums[1]) throw std::logic_error("annealing changed the samples of a slice");
  const std::string digest = to_hex(static_cast<std::uint64_t>(sums[1]));
  const bool is_lattice = config_.start.pattern == StartPattern::lattice;
  const char* const origin = is_lattice ? "the lattice" : config_.start.file.empty() ? "the construction" : "the file";
  const std::string done =
      optimizer_->sweep() == 0   ? fmt::format("that of {}; annealing did not begin", origin)
      : optimizer_->kept_given() ? fmt::format("that of {}, which annealing did not improve", origin)
      : optimizer_->is_cold()
          ? fmt::format("that of {}, annealed in the cold", origin)
          : fmt::format("that of {}, annealed from {:.0f} % of the schedule on", origin, 100 * optimizer_->join());
  return fmt::format("{}; its slices hold the samples that they began with (sorted: {})", done, digest);
}

ProgressFigures SwapJob::figures(double run_s, double part_s) {
  const Moment moment = optimizer_->moment();
  const SweepFigures& sweep = optimizer_->last_sweep();
  const StopSpec& stop = config_.optimizer.stop;
  const bool by_time = stop.time_s > 0;
  ProgressFigures f;
  f.fraction = by_time ? std::min(1.0, run_s / stop.time_s) : 0;
  if (moment.round_length > 0) {
    f.fraction = static_cast<double>(moment.sweep_in_round) / static_cast<double>(moment.round_length);
  }
  const double left = pace_.left_s(f.fraction, part_s);
  if (by_time) {
    f.left_s = std::max(0.0, stop.time_s - run_s);
  } else if (stop.iterations > 0) {
    f.left_s = left;
  }
  const double candidates = static_cast<double>(optimizer_->candidates_done()) * communicator_->size();
  const double rate = part_s > 0 ? candidates / part_s : 0;
  f.json = {{"iterations", optimizer_->iterations()},
            {"of", stop.iterations},
            {"temperature", sweep.temperature},
            {"acceptance", sweep.acceptance},
            {"relative_error", optimizer_->last_score()},
            {"scored_at", optimizer_->last_score_at_iteration()},
            {"candidates_per_second", rate},
            {"seconds", run_s}};
  const std::string pace = rate_text(rate, "candidates");
  f.bar = fmt::format("{}  accepted {:.1f} %  {}", score_text(), 100 * sweep.acceptance, pace);
  f.plain = fmt::format("iteration {}{}  {} {:.3g}  accepted {:.1f} %  {}  {}  {}", optimizer_->iterations(),
                        stop.iterations > 0 ? fmt::format("/{}", stop.iterations) : "",
                        spec_.method == Method::fast ? "gamma" : "T", sweep.temperature, 100 * sweep.acceptance,
                        score_text(), pace, duration_text(run_s));
  return f;
}

std::vector<std::pair<std::string, std::string>> SwapJob::summary(double run_s) {
  std::int64_t totals[] = {optimizer_->candidates_done(), optimizer_->bytes_sent(), optimizer_->messages_sent()};
  communicator_->sum(totals);
  const auto candidates = static_cast<double>(totals[0]);
  const auto bytes = static_cast<double>(totals[1]);
  const std::vector<HistoryRow>& history = optimizer_->history();
  std::vector<std::pair<std::string, std::string>> lines = {
      {"R", fmt::format("{:.5f}   (white noise 1, {} {:.5f})", history.back().relative_error,
                        optimizer_->has_given() ? "before" : "at the start", history.front().relative_error)},
      {"effort", fmt::format("{} iterations, {:.3g} candidates in this part, {}", optimizer_->iterations(), candidates,
                             duration_text(run_s))},
      {"stopped by", ended_text(optimizer_->finished_by())}};
  if (optimizer_->has_given()) lines.emplace_back("arrangement", given_words());
  if (communicator_->size() > 1) {
    const double visits = candidates * 2 / static_cast<double>(optimizer_->iterations_per_sweep());
    lines.emplace_back("exchange",
                       fmt::format("{} messages, {:.3g} MB between ranks in this part, {:.3g} B a sample and sweep",
                                   totals[2], bytes / 1e6, candidates > 0 ? bytes / visits : 0.0));
  }
  return lines;
}

std::unique_ptr<Job> make_swap_job(const RunConfig& config) { return std::make_unique<SwapJob>(config); }

}  // namespace noiseloom
