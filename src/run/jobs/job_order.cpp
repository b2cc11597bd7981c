// Void and cluster: the order in which the pixels of a mask are turned on.

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "noiseloom/construct/order_samples.h"
#include "noiseloom/core/quantity_text.h"
#include "noiseloom/run/job.h"
#include "noiseloom/run/order_checkpoint.h"
#include "run/jobs/memory_words.h"

namespace noiseloom {
namespace {

// What steps are fitted to: safe points that no signal waits long for. What a step leaves of a batch, which is a few
// thousandths of the pixels, is copied for the next, so very small steps cost time.
constexpr double order_step_s = 0.4;
constexpr std::int64_t pixels_per_pick = 16384;
constexpr std::int64_t first_picks = 64;

class OrderJob : public Job {
 public:
  explicit OrderJob(const RunConfig& config)
      : config_(config), spec_(vac_spec(config)), next_picks_(std::max(first_picks, fewest_picks())) {
    check_vac_spec(spec_);
  }

  void prepare(const Communicator& communicator, ThreadPool& pool) override {
    communicator_ = &communicator;
    communicator.together(
        [&] { naming_shortage("taking up kernel and energies", [&] { run_.emplace(spec_, communicator, pool); }); });
  }
  void start(double run_s) override {
    run_->start();
    history_.push_back({.seconds = run_s});
  }
  void restore(const RunFileReader* saved) override {
    history_ = restore_order_run(saved, config_, *run_, *communicator_);
  }
  void step(double run_s) override;
  bool finished() const override { return run_->done(); }
  std::string save(const SaveTarget& target) override {
    return save_order_run(posix_file_ops(), target.path, config_, *run_, history_, *communicator_, target.provenance);
  }

  std::vector<SliceDataset> datasets() const override { return order_run_datasets(config_); }
  std::string start_words() const override {
    return "drawing the first points and computing the energies of all pixels";
  }

  std::string title() const override {
    return fmt::format("{} by void and cluster", config_.problem.extents.to_string());
  }
  bool is_coupled() const override { return true; }  // every pick may fall into any slice
  std::string position() const override;
  std::size_t num_rows() const override { return history_.size(); }
  ProgressFigures figures(double run_s, double part_s) override;
  std::int64_t bytes_sent() const override { return run_ ? run_->bytes_sent() : 0; }
  std::vector<std::pair<std::string, std::string>> summary(double run_s) override;

 private:
  static std::int64_t picks_of(const VacProgress& progress) { return progress.num_swaps + progress.num_placed; }
  std::int64_t fewest_picks() const { return std::max<std::int64_t>(1, spec_.extents.num_cells() / pixels_per_pick); }
  double fraction() const;
  double rms_moved() const;

  const RunConfig& config_;
  VacSpec spec_;
  const Communicator* communicator_ = nullptr;
  std::optional<VoidAndCluster> run_;
  std::vector<OrderRow> history_;
  std::int64_t next_picks_;
  std::int64_t picks_done_ = 0;  // in this part
  double rate_ = 0;              // picks a second in the last step
  Pace pace_;
};

// Only rank 0's clock decides how many picks the next step makes.
void OrderJob::step(double run_s) {
  const VacProgress before = run_->progress();
  const auto begun = std::chrono::steady_clock::now();
  run_->advance(next_picks_);
  const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  const VacProgress& after = run_->progress();
  add_order_rows(before, after, spec_.extents.num_cells(), run_s + took_s, history_);
  const std::int64_t picks = picks_of(after) - picks_of(before);
  picks_done_ += picks;
  rate_ = took_s > 0 ? static_cast<double>(picks) / took_s : rate_;
  // Picks of another phase may be slower by some times.
  const double most = static_cast<double>(next_picks_) * (after.phase == before.phase ? 4 : 0.5);
  const double next = std::max(std::min(rate_ * order_step_s, most), static_cast<double>(fewest_picks()));
  next_picks_ = static_cast<std::int64_t>(communicator_->broadcast(next));
}

// A swap takes as long as some five picks. How many there will be is known only afterwards: 0.33 to 0.46 for every
// point in the configs of this repository.
double OrderJob::fraction() const {
  constexpr double swap_cost = 5;
  const VacProgress& progress = run_->progress();
  const auto swaps = static_cast<double>(progress.num_swaps);
  const auto points = static_cast<double>(progress.num_start_points);
  const double all_swaps = progress.phase == VacPhase::swap ? std::max(swaps, 0.4 * points) : swaps;
  return (swap_cost * swaps + static_cast<double>(progress.num_placed)) /
         (swap_cost * all_swaps + static_cast<double>(spec_.extents.num_cells()));
}

std::string OrderJob::position() const {
  const VacProgress& progress = run_->progress();
  return fmt::format("phase {}, {} swaps, {} of {} pixels placed", vac_phase_name(progress.phase), progress.num_swaps,
                     progress.num_placed, spec_.extents.num_cells());
}

ProgressFigures OrderJob::figures(double run_s, double part_s) {
  const VacProgress& progress = run_->progress();
  ProgressFigures f;
  f.fraction = fraction();
  f.left_s = pace_.left_s(f.fraction, part_s);
  f.json = {{"phase", std::string(vac_phase_name(progress.phase))},
            {"swaps", progress.num_swaps},
            {"ranked", progress.num_placed},
            {"of", spec_.extents.num_cells()},
            {"fraction", f.fraction},
            {"picks_per_second", rate_},
            {"seconds", run_s}};
  f.bar = fmt::format("{:<5}  {}", vac_phase_name(progress.phase), rate_text(rate_, "picks"));
  f.plain = fmt::format("{}  {:.1f} %  {} swaps, {} of {} pixels placed  {}  {}", vac_phase_name(progress.phase),
                        100 * f.fraction, progress.num_swaps, progress.num_placed, spec_.extents.num_cells(),
                        rate_text(rate_, "picks"), duration_text(run_s));
  return f;
}

// How far equal counts in every slice move samples from their place in the volume's order. *Collective*
double OrderJob::rms_moved() const {
  const std::int64_t num_pixels = spec_.extents.num_cells();
  OrderSpec volume_spec;
  OrderSpec slice_spec;
  slice_spec.equalize = Equalize::slice;
  double sum = 0;
  for (const SliceIndex slice : Distribution(run_->partition(), communicator_->rank()).own_slices()) {
    const std::vector<std::byte> order = run_->order(slice);
    const auto by_slice = samples_of_order(order, run_->codec(), num_pixels, slice_spec);
    const auto by_volume = samples_of_order(order, run_->codec(), num_pixels, volume_spec);
    for (std::size_t i = 0; i < by_slice.size(); ++i) sum += std::pow(double{by_slice[i]} - double{by_volume[i]}, 2);
  }
  std::int64_t fixed = std::llround(sum * 0x1p30);
  communicator_->sum(std::span(&fixed, 1));
  return std::sqrt(static_cast<double>(fixed) * 0x1p-30 / static_cast<double>(num_pixels));
}

std::vector<std::pair<std::string, std::string>> OrderJob::summary(double run_s) {
  std::int64_t bytes = run_->bytes_sent();
  communicator_->sum(std::span(&bytes, 1));
  const VacProgress& progress = run_->progress();
  std::vector<std::pair<std::string, std::string>> lines = {
      {"order", fmt::format("{} pixels; {} swaps of {} points before it", progress.num_placed, progress.num_swaps,
                            progress.num_start_points)},
      {"effort", fmt::format("{} picks in this part, {}", picks_done_, duration_text(run_s))}};
  if (config_.order.equalize == Equalize::slice) {
    lines.emplace_back("equalize", fmt::format("samples moved by {:.2g} (rms) from the volume's order", rms_moved()));
  }
  if (communicator_->size() > 1 && picks_done_ > 0) {
    const auto picks = static_cast<double>(picks_done_);
    lines.emplace_back(
        "exchange", fmt::format("{:.3g} collectives a pick, {:.3g} B a pick between ranks",
                                static_cast<double>(run_->collectives()) / picks, static_cast<double>(bytes) / picks));
  }
  return lines;
}

}  // namespace

std::unique_ptr<Job> make_order_job(const RunConfig& config) { return std::make_unique<OrderJob>(config); }

}  // namespace noiseloom
