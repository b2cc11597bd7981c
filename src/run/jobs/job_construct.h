// Construction: every slice is filled point by point, and is scored when it is full.
#pragma once

#include <map>
#include <optional>

#include "noiseloom/construct/slice_construction.h"
#include "noiseloom/problem/footprint.h"
#include "noiseloom/run/construct_checkpoint.h"
#include "noiseloom/run/job.h"

namespace noiseloom {

class ConstructJob : public Job {
 public:
  explicit ConstructJob(const RunConfig& config);

  void prepare(const Communicator& communicator, ThreadPool& pool) override;
  void start(double run_s) override {
    run_->start();
    history_.push_back({.seconds = run_s});
  }
  void restore(const RunFileReader* saved) override;
  void step(double run_s) override;
  bool finished() const override { return run_->done(); }
  std::string save(const SaveTarget& target) override;

  std::vector<SliceDataset> datasets() const override;
  std::string start_words() const override {
    return "drawing the first points and computing the energies of all pixels";
  }
  std::string title() const override;
  bool is_coupled() const override { return run_->couples_slices(); }
  std::string position() const override;
  std::size_t num_rows() const override { return history_.size(); }
  ProgressFigures figures(double run_s, double part_s) override;
  std::int64_t bytes_sent() const override { return run_ ? run_->bytes_sent() : 0; }
  std::vector<std::pair<std::string, std::string>> summary(double run_s) override;

  // When it is finished: of own slices and of all that they act on, the place of the sample of every cell. *Collective*
  std::map<SliceIndex, std::vector<std::uint32_t>> places() const;
  double relative_error() const { return relative_error_; }

 private:
  void find_sharpness();
  std::int64_t num_ranked() const { return run_->progress().num_placed * config_.problem.extents.num_slices(); }
  ConstructState state() const;
  void score();

  const RunConfig& config_;
  SampleSource source_;
  Footprint overlap_;
  std::optional<SampleScale> scale_;
  ConstructSpec spec_;  // with the sharpness that is used
  const Communicator* communicator_ = nullptr;
  ThreadPool* pool_ = nullptr;
  std::optional<SliceConstruction> run_;
  std::vector<ConstructRow> history_;
  double mean_distance_ = 0;
  double relative_error_ = 0;
  std::int64_t next_rounds_ = 1;
  double rate_ = 0;  // pixels a second in the last step
  Pace pace_;
};

}  // namespace noiseloom
