// The optimiser gives the same permutations on any number of ranks and threads and after any interruption.
#include "noiseloom/anneal/swap_optimizer.h"

#include <gtest/gtest.h>

#include <cstring>
#include <functional>

#include "anneal/swap_cases.h"

namespace noiseloom {
namespace {

using namespace testing_support;

// What one process makes of each of swap_cases(). Ranks share the work; it is done once for all tests. *Collective*
const std::vector<StraightRun>& straight_runs() {
  static const std::vector<StraightRun> runs = [] {
    const Communicator world = Communicator::world();
    const std::vector<SwapCase> cases = swap_cases();
    const auto size = static_cast<std::size_t>(world.size());
    std::vector<StraightRun> all(cases.size());
    for (std::size_t k = static_cast<std::size_t>(world.rank().value()); k < cases.size(); k += size) {
      all[k] = straight_run(cases[k]);
    }
    const auto share = [&world](auto& values) {
      const auto bytes = world.gather_all(std::as_bytes(std::span(values)));
      values.resize(bytes.size() / sizeof(values[0]));
      std::copy(bytes.begin(), bytes.end(), std::as_writable_bytes(std::span(values)).begin());
    };
    for (std::size_t k = 0; k < cases.size(); ++k) {
      all[k].permutations.resize(static_cast<std::size_t>(cases[k].problem.extents.num_slices()));
      for (Permutation& permutation : all[k].permutations) share(permutation);
      share(all[k].history);
    }
    return all;
  }();
  return runs;
}

TEST(SwapOptimizer, SamePermutationsOnAnyRanksAndThreads) {
  const Communicator world = Communicator::world();
  const std::vector<SwapCase> cases = swap_cases();
  for (std::size_t k = 0; k < cases.size(); ++k) {
    const SwapCase& job = cases[k];
    SCOPED_TRACE(job.name);
    const auto& [expected, expected_history] = straight_runs()[k];
    for (const int threads : {1, 2}) {
      ThreadPool pool(threads);
      const SampleSource source = source_of(job.problem);
      SwapOptimizer engine(job.problem, job.optimizer, source, world, pool);
      engine.start();
      while (!engine.finished()) engine.step(0);
      engine.settle();
      for (const SliceIndex s : engine.distribution().own_slices()) {
        EXPECT_EQ(engine.permutation(s), expected[static_cast<std::size_t>(s)]) << "slice " << s;
      }
      ASSERT_EQ(engine.history().size(), expected_history.size());
      for (std::size_t row = 0; row < expected_history.size(); ++row) {
        EXPECT_EQ(engine.history()[row].relative_error, expected_history[row].relative_error);
        EXPECT_EQ(engine.history()[row].acceptance, expected_history[row].acceptance);
      }
    }
  }
}

// Stops after every possible step; the state and the permutations are all that the next engine gets.
TEST(SwapOptimizer, GoesOnFromEveryStepToTheSamePermutations) {
  const Communicator world = Communicator::world();
  const std::vector<SwapCase> cases = swap_cases();
  for (std::size_t k = 0; k < cases.size(); ++k) {
    const SwapCase& job = cases[k];
    SCOPED_TRACE(job.name);
    const auto& [expected, expected_history] = straight_runs()[k];
    ThreadPool pool(1);
    const SampleSource source = source_of(job.problem);
    auto engine = std::make_unique<SwapOptimizer>(job.problem, job.optimizer, source, world, pool);
    engine->start();
    while (!engine->finished()) {
      engine->step(0);
      const SwapState state = engine->state();
      std::vector<Permutation> all(static_cast<std::size_t>(job.problem.extents.num_slices()));
      // Everybody learns every permutation, as from a run file.
      const Distribution& distribution = engine->distribution();
      std::vector<std::byte> sent;
      world.stream_to_root(
          distribution,
          [&](SliceIndex slice, std::vector<std::byte>& block) {
            const auto bytes = std::as_bytes(std::span(engine->permutation(slice)));
            block.assign(bytes.begin(), bytes.end());
          },
          [&](SliceIndex slice, std::span<const std::byte> block) {
            auto& ids = all[static_cast<std::size_t>(slice)];
            ids.resize(block.size() / sizeof(SampleId));
            std::copy(block.begin(), block.end(), std::as_writable_bytes(std::span(ids)).begin());
          });
      const IndexRange<SliceIndex> slices = first_indices<SliceIndex>(distribution.num_slices());
      const std::vector<SliceIndex> every(slices.begin(), slices.end());
      world.stream_from_root(
          every,
          [&](SliceIndex slice, std::vector<std::byte>& block) {
            const auto bytes = std::as_bytes(std::span(all[static_cast<std::size_t>(slice)]));
            block.assign(bytes.begin(), bytes.end());
          },
          [&](SliceIndex slice, std::span<const std::byte> block) {
            auto& ids = all[static_cast<std::size_t>(slice)];
            ids.resize(block.size() / sizeof(SampleId));
            std::copy(block.begin(), block.end(), std::as_writable_bytes(std::span(ids)).begin());
          });
      engine = std::make_unique<SwapOptimizer>(job.problem, job.optimizer, source, world, pool);
      engine->restore(state, [&](SliceIndex slice) { return all[static_cast<std::size_t>(slice)]; });
    }
    for (const SliceIndex s : engine->distribution().own_slices()) {
      EXPECT_EQ(engine->permutation(s), expected[static_cast<std::size_t>(s)]) << "slice " << s;
    }
    EXPECT_EQ(engine->history().back().relative_error, expected_history.back().relative_error);
  }
}

// A run that anneals what another has come to.
struct GivenRun {
  GivenRun(const OptimizerSpec& spec, const std::function<void(SwapOptimizer&)>& join = {}) : optimizer(spec) {
    const SwapCase first = swap_cases().front();
    problem = first.problem;
    const Extents& extents = problem.extents;
    const SampleSource source = source_of(problem);
    const Communicator world = Communicator::world();
    ThreadPool pool(1);
    const auto ids = [&](SliceIndex slice) { return start_permutation(99, slice, extents.cells_per_slice()); };
    SwapOptimizer run(problem, optimizer, source, world, pool);
    run.start_from(ids, 0.5);
    given_error = run.last_score();
    if (join) join(run);
    while (!run.finished()) run.step(0.5);
    error = run.relative_error();
    kept = run.kept_given();
    history = run.history();
    for (const SliceIndex slice : run.distribution().own_slices()) {
      came_back = came_back && run.permutation(slice) == ids(slice) && run.given_permutation(slice) == ids(slice);
    }
  }

  OptimizerSpec optimizer;
  ProblemSpec problem;
  double given_error = 0;
  double error = 0;
  bool kept = false;
  bool came_back = true;  // the own slices
  std::vector<HistoryRow> history;
};

TEST(SwapOptimizer, AnnealsAGivenArrangement) {
  OptimizerSpec spec;
  spec.stop.iterations = 60;
  const GivenRun hot(spec);
  EXPECT_LT(hot.error, 0.5 * hot.given_error);
  EXPECT_FALSE(hot.kept);
  EXPECT_EQ(hot.history.front().relative_error, hot.given_error);
  const GivenRun cold(spec, [](SwapOptimizer& run) { run.join_cold(0.5); });
  EXPECT_LT(cold.error, 0.5 * cold.given_error);
  EXPECT_LT(cold.history.back().temperature, 0.1 * hot.history.back().temperature);
  const GivenRun joined(spec, [](SwapOptimizer& run) { run.join_schedule(0.5, 0.5); });
  EXPECT_LT(joined.error, 0.5 * joined.given_error);
  EXPECT_NE(joined.error, hot.error);
  EXPECT_EQ(joined.history.back().temperature, hot.history.back().temperature) << "both end where the schedule does";
}

TEST(SwapOptimizer, ComesBackToAnArrangementThatItDoesNotImprove) {
  OptimizerSpec spec;
  spec.stop.iterations = 2;
  spec.temperature_start = 100;
  spec.temperature_end = 90;
  const GivenRun run(spec);
  // A random arrangement has R about 1, and so has what the heat makes of it.
  EXPECT_EQ(run.kept, run.error == run.given_error);
  EXPECT_EQ(run.kept, run.came_back);
  EXPECT_LE(run.error, run.given_error);
  spec.stop = StopSpec::none();
  spec.stop.time_s = 0.4;  // over when the arrangement is given
  const GivenRun late(spec);
  EXPECT_TRUE(late.came_back);
  EXPECT_EQ(late.error, late.given_error);
}

}  // namespace
}  // namespace noiseloom
