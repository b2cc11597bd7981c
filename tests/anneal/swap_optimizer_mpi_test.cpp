// The optimiser gives the same permutations on any number of ranks and threads and after any interruption.
#include "noiseloom/anneal/swap_optimizer.h"

#include <gtest/gtest.h>

#include <functional>

#include "noiseloom/anneal/tile_grid.h"
#include "support/filter_specs.h"

namespace noiseloom {
namespace {

using namespace testing_support;

struct Case {
  const char* name;
  ProblemSpec problem;
  OptimizerSpec optimizer;
};

std::vector<Case> cases() {
  std::vector<Case> all;
  Case product{"product with ema", {}, {}};
  product.problem.extents = Extents({13, 11, 7});
  product.problem.filter.groups = {group({0, 1}, box(3)), group({2}, ema(0.1, 0.1))};
  product.optimizer.stop.iterations = 6;
  all.push_back(product);

  Case fast = product;
  fast.name = "the paper's method";
  fast.optimizer.method = Method::fast;
  all.push_back(fast);

  Case stbn{"spatiotemporal blue noise", {}, {}};
  stbn.problem.extents = Extents({11, 8, 13});
  stbn.problem.samples.space = "vector2";
  stbn.problem.filter.combine = Combine::sum;
  stbn.problem.filter.groups = {group({0, 1}, gauss_energy(0.8)), group({2}, gauss_energy(0.8))};
  for (GroupSpec& spec : stbn.problem.filter.groups) spec.weight = 0.5;
  stbn.problem.value_kernel.kind = ValueKernelKind::stbn;
  stbn.optimizer.stop.iterations = 4;
  all.push_back(stbn);

  Case four{"2D x 2D directions", {}, {}};
  four.problem.extents = Extents({7, 5, 3, 5});
  four.problem.samples.space = "hemisphere-cosine";
  four.problem.filter.groups = {group({0, 1}, box(3)), group({2, 3}, gauss(0.7))};
  four.optimizer.precision = Precision::float64;
  four.optimizer.stop.iterations = 5;
  all.push_back(four);

  Case uncoupled{"slices on their own", {}, {}};
  uncoupled.problem.extents = Extents({9, 10, 6});
  uncoupled.problem.filter.groups = {group({0, 1}, box(5))};
  uncoupled.optimizer.stop.iterations = 5;
  all.push_back(uncoupled);

  Case tiles{"tiles", {}, {}};
  tiles.problem.extents = Extents({131, 97, 2});
  tiles.problem.filter.groups = {group({0, 1}, box(3))};
  tiles.optimizer.stop.iterations = 2;
  EXPECT_GT(TileGrid(Footprint(tiles.problem.extents, tiles.problem.filter), 2).num_tiles(), 1);
  all.push_back(tiles);

  Case sieved{"vectors, tiles, a product over slices", {}, {}};
  sieved.problem.extents = Extents({131, 97, 2});
  sieved.problem.samples.space = "vector2";
  sieved.problem.filter.groups = {group({0, 1}, box(4)), group({2}, box(2))};
  sieved.optimizer.stop.iterations = 3;
  sieved.optimizer.sieve_features = 16;
  EXPECT_GT(TileGrid(Footprint(sieved.problem.extents, sieved.problem.filter), 1).num_tiles(), 1);
  all.push_back(sieved);

  Case directions{"directions by the same pixel of other slices", {}, {}};
  directions.problem.extents = Extents({11, 13, 5});
  directions.problem.samples.space = "sphere";
  directions.problem.filter.combine = Combine::sum;
  directions.problem.filter.groups = {group({0, 1}, gauss(0.8)), group({2}, ema(0.1, 0.1))};
  directions.optimizer.stop.iterations = 6;
  directions.optimizer.sieve_features = 16;
  all.push_back(directions);
  return all;
}

SampleSource source_of(const ProblemSpec& problem) {
  return {problem.samples, problem.extents.cells_per_slice(), problem.extents.num_slices(), problem.seed};
}

std::vector<Permutation> straight_run(const Case& job, std::vector<HistoryRow>& history) {
  const Communicator alone = Communicator::self();
  ThreadPool pool(1);
  const SampleSource source = source_of(job.problem);
  SwapOptimizer engine(job.problem, job.optimizer, source, alone, pool);
  engine.start();
  while (!engine.finished()) engine.step(0);
  history = engine.history();
  std::vector<Permutation> result;
  for (const SliceIndex s : job.problem.extents.slices()) result.push_back(engine.permutation(s));
  return result;
}

TEST(SwapOptimizer, SamePermutationsOnAnyRanksAndThreads) {
  const Communicator world = Communicator::world();
  for (const Case& job : cases()) {
    SCOPED_TRACE(job.name);
    std::vector<HistoryRow> expected_history;
    const auto expected = straight_run(job, expected_history);
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
  for (const Case& job : cases()) {
    SCOPED_TRACE(job.name);
    std::vector<HistoryRow> expected_history;
    const auto expected = straight_run(job, expected_history);
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
    const Case first = cases().front();
    problem = first.problem;
    const Extents& extents = problem.extents;
    const SampleSource source(problem.samples, extents.cells_per_slice(), extents.num_slices(), problem.seed);
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

TEST(SwapOptimizer, KeepsTheSamplesOfEverySliceBitForBit) {
  const Communicator world = Communicator::world();
  for (const Case& job : cases()) {
    SCOPED_TRACE(job.name);
    ThreadPool pool(1);
    const SampleSource source = source_of(job.problem);
    SwapOptimizer engine(job.problem, job.optimizer, source, world, pool);
    engine.start();
    while (!engine.finished()) engine.step(0);
    const auto channels = static_cast<std::size_t>(source.channels());
    for (const SliceIndex s : engine.distribution().own_slices()) {
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
  const Communicator world = Communicator::world();
  Case job = cases()[1];
  job.problem.extents = Extents({32, 32, 5});
  job.optimizer.fraction = 1.0 / 128;
  job.optimizer.grow_fraction = false;
  job.optimizer.stop.iterations = 40;
  ThreadPool pool(1);
  const SampleSource source = source_of(job.problem);
  SwapOptimizer engine(job.problem, job.optimizer, source, world, pool);
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
double error_found_afresh(SwapOptimizer& optimizer, const Case& job, const SampleSource& source, ThreadPool& pool,
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
  Case job = cases().front();
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

// R is evaluated again whenever somebody looks, seconds apart; what is shown is R of a moment, and says of which. The
// history and the texture do not depend on it.
TEST(SwapOptimizer, ShowsNothingButR) {
  const Communicator alone = Communicator::self();
  ThreadPool pool(2);
  for (const Case& job : cases()) {
    SCOPED_TRACE(job.name);
    std::vector<HistoryRow> expected_history;
    const auto expected = straight_run(job, expected_history);
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
