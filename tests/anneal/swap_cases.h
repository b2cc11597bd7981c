// Small problems of every kind that swaps solve, and what one process on one thread makes of them.
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "noiseloom/anneal/swap_optimizer.h"
#include "noiseloom/anneal/tile_grid.h"
#include "support/filter_specs.h"

namespace noiseloom::testing_support {

struct SwapCase {
  const char* name;
  ProblemSpec problem;
  OptimizerSpec optimizer;
};

inline std::vector<SwapCase> swap_cases() {
  std::vector<SwapCase> all;
  SwapCase product{"product with ema", {}, {}};
  product.problem.extents = Extents({13, 11, 7});
  product.problem.filter.groups = {group({0, 1}, box(3)), group({2}, ema(0.1, 0.1))};
  product.optimizer.stop.iterations = 6;
  all.push_back(product);

  SwapCase fast = product;
  fast.name = "the paper's method";
  fast.optimizer.method = Method::fast;
  all.push_back(fast);

  SwapCase stbn{"spatiotemporal blue noise", {}, {}};
  stbn.problem.extents = Extents({11, 8, 13});
  stbn.problem.samples.space = "vector2";
  stbn.problem.filter.combine = Combine::sum;
  stbn.problem.filter.groups = {group({0, 1}, gauss_energy(0.8)), group({2}, gauss_energy(0.8))};
  for (GroupSpec& spec : stbn.problem.filter.groups) spec.weight = 0.5;
  stbn.problem.value_kernel.kind = ValueKernelKind::stbn;
  stbn.optimizer.stop.iterations = 4;
  all.push_back(stbn);

  SwapCase four{"2D x 2D directions", {}, {}};
  four.problem.extents = Extents({7, 5, 3, 5});
  four.problem.samples.space = "hemisphere-cosine";
  four.problem.filter.groups = {group({0, 1}, box(3)), group({2, 3}, gauss(0.7))};
  four.optimizer.precision = Precision::float64;
  four.optimizer.stop.iterations = 5;
  all.push_back(four);

  SwapCase uncoupled{"slices on their own", {}, {}};
  uncoupled.problem.extents = Extents({9, 10, 6});
  uncoupled.problem.filter.groups = {group({0, 1}, box(5))};
  uncoupled.optimizer.stop.iterations = 5;
  all.push_back(uncoupled);

  SwapCase tiles{"tiles", {}, {}};
  tiles.problem.extents = Extents({131, 97, 2});
  tiles.problem.filter.groups = {group({0, 1}, box(3))};
  tiles.optimizer.stop.iterations = 2;
  EXPECT_GT(TileGrid(Footprint(tiles.problem.extents, tiles.problem.filter), 2).num_tiles(), 1);
  all.push_back(tiles);

  SwapCase sieved{"vectors, tiles, a product over slices", {}, {}};
  sieved.problem.extents = Extents({131, 97, 2});
  sieved.problem.samples.space = "vector2";
  sieved.problem.filter.groups = {group({0, 1}, box(4)), group({2}, box(2))};
  sieved.optimizer.stop.iterations = 3;
  sieved.optimizer.sieve_features = 16;
  EXPECT_GT(TileGrid(Footprint(sieved.problem.extents, sieved.problem.filter), 1).num_tiles(), 1);
  all.push_back(sieved);

  SwapCase directions{"directions by the same pixel of other slices", {}, {}};
  directions.problem.extents = Extents({11, 13, 5});
  directions.problem.samples.space = "sphere";
  directions.problem.filter.combine = Combine::sum;
  directions.problem.filter.groups = {group({0, 1}, gauss(0.8)), group({2}, ema(0.1, 0.1))};
  directions.optimizer.stop.iterations = 6;
  directions.optimizer.sieve_features = 16;
  all.push_back(directions);
  return all;
}

inline SampleSource source_of(const ProblemSpec& problem) {
  return {problem.samples, problem.extents.cells_per_slice(), problem.extents.num_slices(), problem.seed};
}

struct StraightRun {
  std::vector<Permutation> permutations;
  std::vector<HistoryRow> history;
};

inline StraightRun straight_run(const SwapCase& job) {
  const Communicator alone = Communicator::self();
  ThreadPool pool(1);
  const SampleSource source = source_of(job.problem);
  SwapOptimizer engine(job.problem, job.optimizer, source, alone, pool);
  engine.start();
  while (!engine.finished()) engine.step(0);
  StraightRun run;
  for (const SliceIndex s : job.problem.extents.slices()) run.permutations.push_back(engine.permutation(s));
  run.history = engine.history();
  return run;
}

}  // namespace noiseloom::testing_support
