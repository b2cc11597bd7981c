// The methods that swap samples: anneal and fast; and annealing as the second part of a construction.
#pragma once

#include <functional>
#include <optional>

#include "noiseloom/anneal/swap_optimizer.h"
#include "noiseloom/run/job.h"
#include "run/jobs/joining.h"

namespace noiseloom {

// The place of a pixel is the sample that it gets.
Permutation permutation_of(const std::vector<std::uint32_t>& places);

class SwapJob : public Job {
 public:
  // With method = "construct" it anneals what start_from is given.
  explicit SwapJob(const RunConfig& config);

  void prepare(const Communicator& communicator, ThreadPool& pool) override;
  void start(double run_s) override;
  // In place of start: from an arrangement of the slices that the optimiser holds, when `run_s` are over. Without a
  // joining the schedule is the user's. *Collective*
  void start_from(const PermutationOf& permutation, const std::optional<Joining>& joining, double run_s);
  void restore(const RunFileReader* saved) override;
  void step(double run_s) override { optimizer_->step(run_s); }
  bool finished() const override { return optimizer_->finished(); }
  std::string save(const SaveTarget& target) override;

  void refresh() override { optimizer_->score_now(); }
  bool refreshes_quickly() const override;
  std::vector<SliceDataset> datasets() const override;
  std::string start_words() const override;
  std::string title() const override;
  bool is_coupled() const override { return optimizer_->couples_slices(); }
  std::string position() const override;
  std::size_t num_rows() const override { return optimizer_->history().size(); }
  ProgressFigures figures(double run_s, double part_s) override;
  std::int64_t bytes_sent() const override { return optimizer_ ? optimizer_->bytes_sent() : 0; }
  std::vector<std::pair<std::string, std::string>> summary(double run_s) override;

 private:
  std::string score_text() const;
  std::string given_words() const;
  void start_from_time_strata(double run_s);
  void start_from_lattice(double run_s);
  void start_from(const PermutationOf& permutation, double run_s);
  void join(const Joining& joining, double run_s);

  const RunConfig& config_;
  OptimizerSpec spec_;
  SampleSource source_;
  const Communicator* communicator_ = nullptr;
  ThreadPool* pool_ = nullptr;
  std::optional<SwapOptimizer> optimizer_;
  Pace pace_;
};

}  // namespace noiseloom
