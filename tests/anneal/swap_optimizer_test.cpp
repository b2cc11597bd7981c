// What one process does with the samples of its slices, with R and with time.
#include "noiseloom/anneal/swap_optimizer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "anneal/swap_cases.h"
#include "support/mpi_session.h"
#include "support/sanitizers.h"

namespace noiseloom {
namespace {

using namespace testing_support;

// Sanitizers ask where, not how well: of every other kind.
std::vector<SwapCase> some_cases() {
  const std::vector<SwapCase> all = swap_cases();
  std::vector<SwapCase> some;
  for (std::size_t k = under_sanitizers; k < all.size(); k += under_sanitizers ? 2 : 1) some.push_back(all[k]);
  return some;
}

TEST(SwapOptimizer, KeepsTheSamplesOfEverySliceBitForBit) {
  const Communicator alone = Communicator::self();
  for (const SwapCase& job : some_cases()) {
    SCOPED_TRACE(job.name);
    ThreadPool pool(1);
    const SampleSource source = source_of(job.problem);
    SwapOptimizer engine(job.problem, job.optimizer, source, alone, pool);
    engine.start();
    while (!engine.finished()) engine.step(0);
    const auto channels = static_cast<std::size_t>(source.channels());
    for (const SliceIndex s : job.problem.extents.slices()) {
      const std::vector<float> list = source.list(s);
      const std::vector<float> samples = engine.samples(s);
      std::vector<bool> seen(list.size() / channels);
      for (std::size_t cell = 0; cell < seen.size(); ++cell) {
        const std::uint32_t id = engine.permutation(s)[cell].value();
        EXPECT_FALSE(seen[id]);
        seen[id] = true;
        for (std::size_t c = 0; c < channels; ++c) EXPECT_EQ(samples[cell * channels + c], list[id * channels + c]);
      }
    }
  }
}

// gamma this small makes simultaneous swaps all but independent: the energy, and with K = -d also R, can only fall.
TEST(SwapOptimizer, RelativeErrorFallsInEverySweepOfAGreedyRun) {
  const Communicator alone = Communicator::self();
  SwapCase job = swap_cases()[1];
  job.problem.extents = Extents({32, 32, 5});
  job.optimizer.fraction = 1.0 / 128;
  job.optimizer.grow_fraction = false;
  job.optimizer.stop.iterations = 40;
  ThreadPool pool(1);
  const SampleSource source = source_of(job.problem);
  SwapOptimizer engine(job.problem, job.optimizer, source, alone, pool);
  engine.start();
  double before = engine.relative_error();
  while (!engine.finished()) {
    engine.step(0);
    const double after = engine.relative_error();
    EXPECT_LT(after, before) << "sweep " << engine.sweep();
    before = after;
  }
  EXPECT_EQ(engine.sweep(), 40);
}

// Pairs that swap together see each other's old values; only a small share of them may, until few want to.
TEST(SwapOptimizer, FastConvergesOnASmallSliceUnderAWideFilter) {
  ProblemSpec problem;
  problem.extents = Extents({24, 24});
  problem.filter.groups = {group({0, 1}, box(5))};
  OptimizerSpec optimizer;
  optimizer.method = Method::fast;
  optimizer.stop.iterations = 400;
  const SampleSource source = source_of(problem);
  const Communicator alone = Communicator::self();
  ThreadPool pool(1);
  SwapOptimizer engine(problem, optimizer, source, alone, pool);
  engine.start();
  while (!engine.finished()) engine.step(0);
  double lowest = 1;
  for (const HistoryRow& row : engine.history()) {
    EXPECT_LT(row.relative_error, 1.1 * lowest + 0.05);
    lowest = std::min(lowest, row.relative_error);
  }
  EXPECT_LT(engine.history().back().relative_error, 0.2);
}

// R of an optimiser's texture as it is now, by one that knows nothing but its permutations.
double error_found_afresh(SwapOptimizer& optimizer, const SwapCase& job, const SampleSource& source, ThreadPool& pool,
                          const Communicator& communicator) {
  SwapState state = optimizer.state();
  state.scored_iterations = -1;
  SwapOptimizer other(job.problem, job.optimizer, source, communicator, pool);
  other.restore(state, [&](SliceIndex slice) { return optimizer.permutation(slice); });
  return other.relative_error();
}

// A run that must end in time has to know how long its last score takes, also where it is taken up again.
TEST(SwapOptimizer, KnowsWhatItsLastScoreTakesWhereTheClockEndsIt) {
  const Communicator alone = Communicator::self();
  ThreadPool pool(1);
  SwapCase job = swap_cases().front();
  job.optimizer.stop = {.iterations = 0, .time_s = 1000};
  const SampleSource source = source_of(job.problem);
  SwapOptimizer begun(job.problem, job.optimizer, source, alone, pool);
  begun.start();
  EXPECT_TRUE(begun.scores_within(1000));
  begun.step(1);
  SwapOptimizer resumed(job.problem, job.optimizer, source, alone, pool);
  resumed.restore(begun.state(), [&](SliceIndex slice) { return begun.permutation(slice); });
  EXPECT_TRUE(resumed.scores_within(1000));
  EXPECT_TRUE(resumed.last_score_is_current());
  EXPECT_EQ(resumed.last_score(), begun.relative_error());
}

// By its iterations, or by the seconds that it is told: T = start (end / start)^(f^2.75), and f^3.575 of seconds.
TEST(SwapOptimizer, ASumStaysHotForLong) {
  const Communicator alone = Communicator::self();
  ThreadPool pool(1);
  SwapCase job;
  job.problem.extents = Extents({8, 7, 4});
  job.problem.filter = {Combine::sum, {group({0, 1}, gauss(0.8)), group({2}, ema(0.1, 0.1))}};
  const SampleSource source = source_of(job.problem);
  const auto temperatures = [&](const StopSpec& stop, double seconds_of_sweep) {
    job.optimizer.stop = stop;
    SwapOptimizer engine(job.problem, job.optimizer, source, alone, pool);
    engine.start();
    std::vector<double> of_sweeps;
    while (!engine.finished() && of_sweeps.size() < 20) {
      const std::int64_t sweep = engine.sweep();
      const double seconds = seconds_of_sweep * static_cast<double>(sweep);
      while (!engine.finished() && engine.sweep() == sweep) engine.step(seconds);
      of_sweeps.push_back(engine.temperature());
    }
    return of_sweeps;
  };
  const double whole = std::log(8e-4 / 0.06);
  const std::vector<double> by_iterations = temperatures({.iterations = 24 * 24}, 0);
  ASSERT_GE(by_iterations.size(), 10U);
  const double of_last = static_cast<double>(24 * 24 / 8 - 1);  // visits of 8 iterations
  const std::vector<double> by_time = temperatures({.iterations = 0, .time_s = 100}, 5);
  ASSERT_GE(by_time.size(), 10U);
  for (std::size_t k = 1; k < 10; ++k) {
    const auto sweep = static_cast<double>(k);
    EXPECT_NEAR(std::log(by_iterations[k] / by_iterations[0]), whole * std::pow(sweep / of_last, 2.75), 1e-9) << k;
    EXPECT_NEAR(std::log(by_time[k] / by_time[0]), whole * std::pow(sweep / 20, 3.575), 1e-9) << k;
  }
}

// R is evaluated again whenever somebody looks, seconds apart; what is shown is R of a moment, and says of which. The
// history and the texture do not depend on it.
TEST(SwapOptimizer, ShowsNothingButR) {
  const Communicator alone = Communicator::self();
  ThreadPool pool(2);
  for (const SwapCase& job : some_cases()) {
    if (job.problem.extents.num_cells() > 10'000) continue;  // R is found afresh after every step
    SCOPED_TRACE(job.name);
    const auto [expected, expected_history] = straight_run(job);
    const SampleSource source = source_of(job.problem);
    SwapOptimizer optimizer(job.problem, job.optimizer, source, alone, pool);
    optimizer.start();
    double seconds = 0;
    while (!optimizer.finished()) {
      optimizer.step(seconds += 1000);
      const double exact = error_found_afresh(optimizer, job, source, pool, alone);
      const bool ends_sweep = optimizer.state().step == 0;
      EXPECT_EQ(optimizer.last_score_is_current(), ends_sweep);
      if (ends_sweep) {
        EXPECT_NEAR(optimizer.last_score(), exact, 1e-4 * exact);
      }
      optimizer.score_now();
      EXPECT_TRUE(optimizer.last_score_is_current());
      EXPECT_EQ(optimizer.last_score(), exact);
      EXPECT_EQ(optimizer.last_score_at_iteration(), optimizer.iterations());
    }
    ASSERT_EQ(optimizer.history().size(), expected_history.size());
    for (std::size_t row = 0; row < expected_history.size(); ++row) {
      EXPECT_EQ(optimizer.history()[row].relative_error, expected_history[row].relative_error);
      EXPECT_EQ(optimizer.history()[row].iterations, expected_history[row].iterations);
    }
    EXPECT_EQ(optimizer.history().back().relative_error, error_found_afresh(optimizer, job, source, pool, alone));
    for (const SliceIndex s : job.problem.extents.slices()) {
      EXPECT_EQ(optimizer.permutation(s), expected[static_cast<std::size_t>(s)]);
    }
  }
}

}  // namespace
}  // namespace noiseloom
