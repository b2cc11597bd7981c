// Construction and then annealing: of a construction that has a stop rule.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "noiseloom/core/stopwatch.h"
#include "noiseloom/run/construct_checkpoint.h"
#include "run/jobs/job_construct.h"
#include "run/jobs/job_swap.h"

namespace noiseloom {
namespace {

// One of its two parts at a time; the run file is that of the part.
class ConstructAnnealJob : public Job {
 public:
  explicit ConstructAnnealJob(const RunConfig& config)
      : config_(config), construction_(std::make_unique<ConstructJob>(config)) {}

  void prepare(const Communicator& communicator, ThreadPool& pool) override {
    communicator_ = &communicator;
    pool_ = &pool;
    construction_->prepare(communicator, pool);
  }
  void start(double run_s) override { construction_->start(run_s); }
  void restore(const RunFileReader* saved) override {
    const bool constructing =
        communicator_->broadcast(saved != nullptr && is_construct_run(saved->content()) ? 1.0 : 0.0) != 0;
    if (constructing) return construction_->restore(saved);
    take_up_annealing();
    annealing_->restore(saved);
  }
  void step(double run_s) override {
    if (annealing_) return annealing_->step(run_s);
    if (!construction_->finished()) return construction_->step(run_s);
    // Trials and the start of annealing are one step: a run that is stopped after each of its steps gets on all the
    // same.
    const Stopwatch watch;
    if (!settle_joining(run_s)) return;
    std::map<SliceIndex, std::vector<std::uint32_t>> places = construction_->places();
    take_up_annealing();
    annealing_->start_from([&](SliceIndex slice) { return permutation_of(places.at(slice)); }, joining_,
                           run_s + watch.seconds());
  }
  bool finished() const override { return annealing_ && annealing_->finished(); }
  std::string save(const SaveTarget& target) override { return part().save(target); }
  void refresh() override { part().refresh(); }
  bool refreshes_quickly() const override { return part().refreshes_quickly(); }
  std::vector<SliceDataset> datasets() const override { return SwapJob(config_).datasets(); }

  std::string title() const override { return part().title() + (annealing_ ? "" : ", then anneal"); }
  std::string start_words() const override { return part().start_words(); }
  bool is_coupled() const override { return part().is_coupled(); }
  std::string position() const override { return part().position(); }
  std::size_t num_rows() const override { return part().num_rows(); }
  ProgressFigures figures(double run_s, double part_s) override { return part().figures(run_s, part_s); }
  std::int64_t bytes_sent() const override { return part().bytes_sent(); }
  std::vector<std::pair<std::string, std::string>> summary(double run_s) override { return part().summary(run_s); }

 private:
  Job& part() const { return annealing_ ? static_cast<Job&>(*annealing_) : *construction_; }
  // How hot annealing begins. Found before what was constructed leaves the run file: trials take seconds, and a stop in
  // them, which makes this false, is one at the end of the construction.
  bool settle_joining(double run_s) {
    const StopSpec& stop = config_.optimizer.stop;
    const double error = construction_->relative_error();
    if (needs_joining(config_.optimizer) && !(stop.score > 0 && error <= stop.score)) {
      const SampleSource source(config_.problem.samples, config_.problem.extents.cells_per_slice(),
                                config_.problem.extents.num_slices(), config_.problem.seed);
      joining_ = agree_on_joining(config_, source, error, stop.time_s - run_s, *communicator_, *pool_);
      return joining_.has_value();
    }
    return true;
  }
  // The memory of the first part is given back before the second takes its own.
  void take_up_annealing() {
    construction_.reset();
    communicator_->together([&] { annealing_ = std::make_unique<SwapJob>(config_); });
    annealing_->prepare(*communicator_, *pool_);
  }

  const RunConfig& config_;
  const Communicator* communicator_ = nullptr;
  ThreadPool* pool_ = nullptr;
  std::unique_ptr<ConstructJob> construction_;
  std::optional<Joining> joining_;
  std::unique_ptr<SwapJob> annealing_;
};

}  // namespace

std::unique_ptr<Job> make_construct_job(const RunConfig& config) {
  if (config.optimizer.stop.is_none()) return std::make_unique<ConstructJob>(config);
  return std::make_unique<ConstructAnnealJob>(config);
}

}  // namespace noiseloom
