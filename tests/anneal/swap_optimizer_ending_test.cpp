// A run ends where its stop rule says, and where that cannot be met.
#include <gtest/gtest.h>

#include "anneal/swap_cases.h"
#include "noiseloom/anneal/swap_optimizer.h"
#include "support/filter_specs.h"
#include "support/mpi_session.h"

namespace noiseloom {
namespace {

using namespace testing_support;

std::string reason_of_ending(const StopSpec& stop, const std::vector<std::int64_t>& sizes,
                             std::vector<HistoryRow>& history) {
  ProblemSpec problem;
  problem.extents = Extents(sizes);
  problem.filter.groups = {group({0, 1}, box(3))};
  OptimizerSpec spec;
  spec.stop = stop;
  const Communicator alone = Communicator::self();
  ThreadPool pool(1);
  const SampleSource source = source_of(problem);
  SwapOptimizer optimizer(problem, spec, source, alone, pool);
  optimizer.start();
  while (!optimizer.finished() && optimizer.sweep() < 5000) optimizer.step(0);
  history = optimizer.history();
  return optimizer.finished_by();
}

TEST(SwapOptimizer, EndsWhereItsStopRuleCannotBeMet) {
  StopSpec score;
  score.iterations = 0;
  score.score = 1e-6;
  std::vector<HistoryRow> history;
  EXPECT_EQ(reason_of_ending(score, {16, 16}, history), ended::out_of_reach);
  for (const std::vector<std::int64_t>& sizes : {std::vector<std::int64_t>{1, 1}, {1, 1, 7}}) {
    EXPECT_EQ(reason_of_ending(score, sizes, history), ended::nothing_to_swap);
    EXPECT_EQ(history.size(), 1U);
  }
  score.score = 0.99;
  EXPECT_EQ(reason_of_ending(score, {16, 16}, history), ended::by_score);
  StopSpec improvement;
  improvement.iterations = 0;
  improvement.improvement = 0.02;
  EXPECT_EQ(reason_of_ending(improvement, {16, 16}, history), ended::by_improvement);
  EXPECT_LT(history.back().iterations, 5000);
}

// A sweep that the clock cuts short has made no more iterations than its slices were visited for, and a run that is
// read back says the same.
TEST(SwapOptimizer, CountsWhatASweepThatIsCutShortHasDone) {
  ProblemSpec problem;
  problem.extents = Extents({16, 16, 8});
  problem.filter.groups = {group({0, 1}, box(3)), group({2}, box(3))};
  OptimizerSpec spec;
  spec.stop.iterations = 0;
  spec.stop.time_s = 10;
  const Communicator alone = Communicator::self();
  ThreadPool pool(1);
  const SampleSource source = source_of(problem);
  SwapOptimizer optimizer(problem, spec, source, alone, pool);
  optimizer.start();
  ASSERT_GT(optimizer.num_classes(), 1);
  while (optimizer.sweep() < 2) optimizer.step(1);
  optimizer.step(1);  // one class of the third sweep
  optimizer.step(20);
  ASSERT_EQ(optimizer.finished_by(), ended::by_time);
  const std::int64_t of_sweep = optimizer.iterations_per_sweep();
  EXPECT_GT(optimizer.iterations(), 2 * of_sweep);
  EXPECT_LT(optimizer.iterations(), 3 * of_sweep);
  const double candidates_of_iteration = static_cast<double>(problem.extents.num_cells()) / 2;
  EXPECT_NEAR(static_cast<double>(optimizer.candidates_done()) / candidates_of_iteration,
              static_cast<double>(optimizer.iterations()), 1);
  EXPECT_EQ(optimizer.history().back().iterations, static_cast<double>(optimizer.iterations()));
  SwapOptimizer again(problem, spec, source, alone, pool);
  again.restore(optimizer.state(), [&](SliceIndex slice) { return optimizer.permutation(slice); });
  EXPECT_EQ(again.iterations(), optimizer.iterations());
  EXPECT_TRUE(again.last_score_is_current());
}

}  // namespace
}  // namespace noiseloom
