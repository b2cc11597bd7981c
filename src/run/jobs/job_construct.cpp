#include "run/jobs/job_construct.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "noiseloom/anneal/texture_score.h"
#include "noiseloom/construct/sharpness.h"
#include "noiseloom/core/quantity_text.h"
#include "noiseloom/dist/halo_exchange.h"
#include "noiseloom/dist/halo_plan.h"
#include "noiseloom/run/checkpoint.h"
#include "noiseloom/run/stop_signals.h"
#include "run/jobs/memory_words.h"

namespace noiseloom {
namespace {

// What steps are fitted to: safe points that no signal waits long for.
constexpr double construct_step_s = 0.4;

}  // namespace

ConstructJob::ConstructJob(const RunConfig& config)
    : config_(config),
      source_(config.problem.samples, config.problem.extents.cells_per_slice(), config.problem.extents.num_slices(),
              config.problem.seed),
      overlap_(config.problem.extents, config.problem.filter),
      scale_(scale_of(config.problem.samples, source_.channels())) {
  if (scale_) return;
  throw UserError(config.problem.samples.file,
                  fmt::format("its samples have {} channels; method = \"construct\" takes scalars that are compared by "
                              "their difference, and \"circle\"; method = \"anneal\" takes all",
                              source_.channels()));
}

void ConstructJob::prepare(const Communicator& communicator, ThreadPool& pool) {
  communicator_ = &communicator;
  pool_ = &pool;
  spec_ = config_.construct;
  if (spec_.sharpness == 0) find_sharpness();
  const ProblemSpec& problem = config_.problem;
  communicator.together([&] {
    naming_shortage("taking up filter and energies",
                    [&] { run_.emplace(overlap_, problem.filter, *scale_, spec_, problem.seed, communicator, pool); });
  });
}

// Every rank makes the same trials for itself. A signal to one of them stops all, once the others are through with
// theirs.
void ConstructJob::find_sharpness() {
  const ProblemSpec& problem = config_.problem;
  bool stopped = false;
  communicator_->together([&] {
    naming_shortage("trying how sharp an overlap constructs best", [&] {
      spec_.sharpness = best_sharpness(try_sharpness(problem.extents, problem.filter, *scale_, [&] {
        stopped = noted_stop_signal() != 0;
        return !stopped;
      }));
    });
  });
  if (communicator_->any_bits(stopped ? 1U : 0U) != 0) throw StartStopped();
}

void ConstructJob::restore(const RunFileReader* saved) {
  const ConstructState state = restore_construct_run(saved, config_, source_, *run_, *communicator_);
  if (state.sharpness != spec_.sharpness) {
    throw SharedUserError("", fmt::format("the run was begun with sharpness {}, but this program finds {}: give "
                                          "optimizer.sharpness = {} to go on",
                                          state.sharpness, spec_.sharpness, state.sharpness));
  }
  history_ = state.history;
  mean_distance_ = state.mean_distance;
  relative_error_ = state.relative_error;
}

std::string ConstructJob::save(const SaveTarget& target) {
  return save_construct_run(posix_file_ops(), target.path, config_, source_, *run_, state(), *communicator_,
                            target.provenance);
}

std::vector<SliceDataset> ConstructJob::datasets() const { return run_datasets(source_); }

std::string ConstructJob::title() const {
  return fmt::format("{} of {}, construct", config_.problem.extents.to_string(), config_.problem.samples.space);
}

ConstructState ConstructJob::state() const {
  ConstructState now =
      construct_state_of(run_->progress(), config_.problem.extents.num_slices(), spec_.sharpness, history_);
  now.mean_distance = mean_distance_;
  now.relative_error = relative_error_;
  return now;
}

// Only rank 0's clock decides how many rounds the next step takes.
void ConstructJob::step(double run_s) {
  const auto begun = std::chrono::steady_clock::now();
  const auto took_s = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count(); };
  const std::int64_t picks_before = run_->picks_done();
  for (std::int64_t round = 0; round < next_rounds_ && !run_->done(); ++round) {
    const ConstructProgress before = run_->progress();
    run_->advance();
    add_construct_rows(before, run_->progress(), config_.problem.extents, run_s + took_s(), history_);
  }
  const double seconds = std::max(took_s(), 1e-9);
  rate_ = static_cast<double>((run_->picks_done() - picks_before) * communicator_->size()) / seconds;
  const double fitting = static_cast<double>(next_rounds_) * std::min(4.0, construct_step_s / seconds);
  next_rounds_ = static_cast<std::int64_t>(communicator_->broadcast(std::max(1.0, fitting)));
  if (run_->done()) score();
}

namespace {

// [cell][channel] as [channel][cell].
std::vector<float> planes_of(const std::vector<float>& samples, int channels) {
  const auto step = static_cast<std::size_t>(channels);
  std::vector<float> planes;
  planes.reserve(samples.size());
  for (std::size_t c = 0; c < step; ++c) {
    for (std::size_t i = c; i < samples.size(); i += step) planes.push_back(samples[i]);
  }
  return planes;
}

HaloPlan slices_that_count(const Footprint& overlap, const Distribution& distribution) {
  std::vector<Extents::SliceCoord> offsets;
  for (const SliceTaps& slice : overlap.slices()) offsets.push_back(slice.offset);
  return {overlap.extents(), offsets, distribution};
}

}  // namespace

// R counts pairs that construction leaves out, as their weight is so small (src/construct/stamp_kernel.h): slices
// further apart than those that are held. So every slice is told once more, to all that need it for R.
std::map<SliceIndex, std::vector<std::uint32_t>> ConstructJob::places() const {
  const Distribution& distribution = run_->distribution();
  const HaloPlan needed = slices_that_count(overlap_, distribution);
  HaloExchange exchange(*communicator_, needed, distribution);
  std::map<SliceIndex, std::vector<std::uint32_t>> all;
  for (const SliceIndex slice : config_.problem.extents.slices()) {
    std::vector<SliceSwaps> told;
    if (distribution.owns(slice)) {
      all[slice] = run_->places(slice);
      SliceSwaps& message = told.emplace_back();
      message.slice = slice;
      if (!needed.listeners(slice).empty()) {
        std::uint32_t cell = 0;
        for (const std::uint32_t place : run_->places(slice)) message.swaps.push_back({cell++, place});
      }
    }
    exchange.begin(std::span(&slice, 1), told);
    exchange.wait([&](SliceIndex from, std::span<const Swap> cells_and_places) {
      std::vector<std::uint32_t>& places = all[from];
      places.resize(cells_and_places.size());
      for (const auto& [cell, place] : cells_and_places) places[cell] = place;
    });
  }
  return all;
}

void ConstructJob::score() {
  const Distribution& distribution = run_->distribution();
  const HaloPlan needed = slices_that_count(overlap_, distribution);
  mean_distance_ =
      mean_distance(source_, *communicator_, *pool_);  // takes much memory, and so before the places are heard
  const auto heard = places();
  const IndexRange<SliceIndex> own = distribution.own_slices();
  std::vector<SliceIndex> held(own.begin(), own.end());
  held.insert(held.end(), needed.needed().begin(), needed.needed().end());
  const auto planar = [&](SliceIndex slice) {
    const int channels = source_.channels();
    return planes_of(samples_of_places(heard.at(slice), source_.list(slice), channels), channels);
  };
  relative_error_ =
      texture_error(overlap_, source_, mean_distance_, distribution, held, planar, *communicator_, *pool_);
}

std::string ConstructJob::position() const {
  const ConstructProgress& progress = run_->progress();
  if (run_->done()) return fmt::format("the end of the construction, R {:.5f}", relative_error_);
  return fmt::format("phase {}, {} of {} pixels placed", construct_phase_name(progress.phase), num_ranked(),
                     config_.problem.extents.num_cells());
}

ProgressFigures ConstructJob::figures(double run_s, double part_s) {
  const ConstructProgress& progress = run_->progress();
  const std::int64_t num_cells = config_.problem.extents.num_cells();
  ProgressFigures f;
  f.fraction = run_->fraction();
  f.left_s = pace_.left_s(f.fraction, part_s);
  f.json = {{"phase", std::string(construct_phase_name(progress.phase))},
            {"swaps", progress.num_swaps},
            {"ranked", num_ranked()},
            {"of", num_cells},
            {"fraction", f.fraction},
            {"picks_per_second", rate_},
            {"seconds", run_s}};
  f.bar = fmt::format("{:<5}  {}", construct_phase_name(progress.phase), rate_text(rate_, "pixels"));
  f.plain = fmt::format("{}  {:.1f} %  {} swaps, {} of {} pixels placed  {}  {}", construct_phase_name(progress.phase),
                        100 * f.fraction, progress.num_swaps, num_ranked(), num_cells, rate_text(rate_, "pixels"),
                        duration_text(run_s));
  return f;
}

std::vector<std::pair<std::string, std::string>> ConstructJob::summary(double run_s) {
  std::int64_t totals[] = {run_->picks_done(), run_->bytes_sent(), run_->messages_sent()};
  communicator_->sum(totals);
  const ConstructProgress& progress = run_->progress();
  std::vector<std::pair<std::string, std::string>> lines = {
      {"R", fmt::format("{:.5f}   (white noise 1)", relative_error_)},
      {"construction", fmt::format("sharpness {:g}{}; {} swaps of {} points in every slice before it", spec_.sharpness,
                                   config_.construct.sharpness == 0 ? ", found from the filter" : "",
                                   progress.num_swaps, progress.num_start_points)},
      {"effort", fmt::format("{} picks in this part, {}", totals[0], duration_text(run_s))}};
  if (communicator_->size() > 1 && totals[0] > 0) {
    lines.emplace_back("exchange", fmt::format("{} messages, {:.3g} B a pick between ranks", totals[2],
                                               static_cast<double>(totals[1]) / static_cast<double>(totals[0])));
  }
  return lines;
}

}  // namespace noiseloom
