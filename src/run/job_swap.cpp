// The methods that swap samples: anneal and fast.

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "noiseloom/anneal/swap_optimizer.h"
#include "noiseloom/core/quantity_text.h"
#include "noiseloom/run/checkpoint.h"
#include "noiseloom/run/job.h"
#include "run/memory_words.h"

namespace noiseloom {
namespace {

constexpr double quick_score_s = 0.5;

class SwapJob : public Job {
 public:
  explicit SwapJob(const RunConfig& config)
      : config_(config),
        source_(config.problem.samples, config.problem.extents.cells_per_slice(), config.problem.extents.num_slices(),
                config.problem.seed) {}

  void prepare(const Communicator& communicator, ThreadPool& pool) override {
    communicator_ = &communicator;
    communicator.together([&] {
      naming_shortage("taking up filter, features and texture",
                      [&] { optimizer_.emplace(config_.problem, config_.optimizer, source_, communicator, pool); });
    });
  }
  void start(double) override { optimizer_->start(); }
  void restore(const RunFileReader* saved) override { restore_run(saved, config_, *optimizer_, *communicator_); }
  void step(double run_s) override { optimizer_->step(run_s); }
  bool finished() const override { return optimizer_->finished(); }
  std::string save(const SaveTarget& target) override {
    return save_run(posix_file_ops(), target.path, config_, source_, *optimizer_, *communicator_, target.provenance);
  }

  void refresh() override { optimizer_->score_now(); }
  bool refreshes_quickly() const override { return optimizer_->scores_within(quick_score_s); }
  std::vector<SliceDataset> datasets() const override { return run_datasets(source_); }
  std::string start_words() const override {
    return "placing the samples, then two scores: the mean distance of all samples, and R of the start";
  }

  std::string title() const override {
    return fmt::format("{} of {}, {}", config_.problem.extents.to_string(), config_.problem.samples.space,
                       config_.optimizer.method == Method::fast ? "fast" : "anneal");
  }
  bool is_coupled() const override { return optimizer_->couples_slices(); }
  std::string position() const override {
    return fmt::format("iteration {}, {}", optimizer_->iterations(), score_text());
  }
  std::size_t num_rows() const override { return optimizer_->history().size(); }
  ProgressFigures figures(double run_s, double part_s) override;
  std::vector<std::pair<std::string, std::string>> summary(double run_s) override;

 private:
  // R as last evaluated, and where that was unless it is R now.
  std::string score_text() const {
    const std::string at = optimizer_->last_score_is_current()
                               ? ""
                               : fmt::format(" (at iteration {})", optimizer_->last_score_at_iteration());
    return fmt::format("R {:.5f}{}", optimizer_->last_score(), at);
  }

  const RunConfig& config_;
  SampleSource source_;
  const Communicator* communicator_ = nullptr;
  std::optional<SwapOptimizer> optimizer_;
  Pace pace_;
};

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
                        config_.optimizer.method == Method::fast ? "gamma" : "T", sweep.temperature,
                        100 * sweep.acceptance, score_text(), pace, duration_text(run_s));
  return f;
}

std::vector<std::pair<std::string, std::string>> SwapJob::summary(double run_s) {
  std::int64_t totals[] = {optimizer_->candidates_done(), optimizer_->bytes_sent(), optimizer_->messages_sent()};
  communicator_->sum(totals);
  const auto candidates = static_cast<double>(totals[0]);
  const auto bytes = static_cast<double>(totals[1]);
  const std::vector<HistoryRow>& history = optimizer_->history();
  std::vector<std::pair<std::string, std::string>> lines = {
      {"R", fmt::format("{:.5f}   (white noise 1, at the start {:.5f})", history.back().relative_error,
                        history.front().relative_error)},
      {"effort", fmt::format("{} iterations, {:.3g} candidates in this part, {}", optimizer_->iterations(), candidates,
                             duration_text(run_s))},
      {"stopped by", ended_text(optimizer_->finished_by())}};
  if (communicator_->size() > 1) {
    const double visits = candidates * 2 / static_cast<double>(optimizer_->iterations_per_sweep());
    lines.emplace_back("exchange",
                       fmt::format("{} messages, {:.3g} MB between ranks in this part, {:.3g} B a sample and sweep",
                                   totals[2], bytes / 1e6, candidates > 0 ? bytes / visits : 0.0));
  }
  return lines;
}

}  // namespace

std::unique_ptr<Job> make_swap_job(const RunConfig& config) { return std::make_unique<SwapJob>(config); }

}  // namespace noiseloom
