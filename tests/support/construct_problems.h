// Small problems of construction of every kind, and runs of them.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "noiseloom/construct/slice_construction.h"
#include "noiseloom/problem/footprint.h"
#include "support/filter_specs.h"
#include "support/slice_construction_oracle.h"

namespace noiseloom::testing_support {

struct ConstructProblem {
  std::string name;
  Extents extents;
  FilterSpec filter;
  ConstructSpec spec{};
  std::uint64_t seed = 1;
  SampleScale scale = SampleScale::line;

  ConstructProblem with_density(double density) const {
    ConstructProblem other = *this;
    other.spec.density = density;
    return other;
  }
  ConstructProblem with_sharpness(double sharpness) const {
    ConstructProblem other = *this;
    other.spec.sharpness = sharpness;
    return other;
  }
  ConstructProblem on_circle() const {
    ConstructProblem other = *this;
    other.name += ", on a circle";
    other.scale = SampleScale::circle;
    return other;
  }
  ConstructProblem with_seed(std::uint64_t other_seed) const {
    ConstructProblem other = *this;
    other.seed = other_seed;
    return other;
  }
};

inline ConstructProblem construct_problem(std::string name, std::vector<std::int64_t> sizes, FilterSpec filter) {
  ConstructProblem problem{std::move(name), Extents(std::move(sizes)), std::move(filter)};
  problem.spec.density = 0.1;
  problem.spec.sharpness = 1.4;
  return problem;
}

// A table whose taps are known.
inline KernelSpec taps(std::vector<std::int64_t> shape, std::vector<double> values) {
  KernelSpec kernel = kernel_of(KernelKind::table);
  kernel.array = std::make_shared<InputArray>(InputArray{std::move(shape), std::move(values)});
  return kernel;
}
inline KernelSpec taps_with_negative_ones() { return taps({4}, {-0.3, 1, 0.7, -0.25}); }
// Over x, y and t: [t][y][x].
inline KernelSpec joint_taps() {
  return taps({3, 2, 3}, {0.5, 1, -0.25, 1, 0.75, 0, 0.25, -0.5, 1, 0, 0.5, 0.25, 0.125, 0, 0, 0.5, -0.125, 0.25});
}

// A sum whose overlap is zero between neighbouring slices, where its sharpened planes are not: 2 and 1, 1 at dx = 0,
// -1, 1 of the first group against -2, -1 and -1 of the others.
inline FilterSpec planes_that_cancel() {
  return sum({group({0, 2}, taps({2, 2}, {1, 1, 1, 1}), 0.25), group({0, 2}, taps({2, 2}, {1, 0, 0, -1}), 0.25),
              group({0, 2}, taps({2, 2}, {0, 1, -1, 0}), 0.25), group({0, 2}, taps({2, 2}, {1, 0, -2, 0}), 0.25)});
}

// Every kind of kernel and combination, with none to three slice axes.
inline std::vector<ConstructProblem> construct_problems() {
  const auto xy = [](const KernelSpec& kernel) { return group({0, 1}, kernel); };
  const auto t = [](const KernelSpec& kernel) { return group({2}, kernel); };
  const auto z = [](const KernelSpec& kernel) { return group({3}, kernel); };
  const auto half = [](GroupSpec spec, double weight = 0.5) {
    spec.weight = weight;
    return spec;
  };
  return {
      construct_problem("box", {16, 16}, product({xy(box(3))})),
      construct_problem("large box", {23, 19}, product({xy(box(5))})),
      construct_problem("gauss", {17, 13}, product({xy(gauss(1))})),
      construct_problem("binomial", {11, 31}, product({xy(binomial(2))})),
      construct_problem("gauss-energy", {13, 17}, product({xy(gauss_energy(1.5))})),
      construct_problem("negative taps", {13, 12}, product({xy(taps_with_negative_ones())})),
      construct_problem("rows longer than vectors", {41, 17}, product({xy(gauss(3))})),
      construct_problem("x alone", {29, 7}, product({group({0}, binomial(3))})),
      construct_problem("box and ema", {7, 11, 9}, product({xy(box(3)), t(ema(0.1, 0.1))})),
      construct_problem("gauss and ema", {11, 7, 13}, product({xy(gauss(1)), t(ema(0.2, 0.1))})),
      construct_problem("gauss and gauss over time", {7, 8, 11}, product({xy(gauss(1)), t(gauss(1))})),
      construct_problem("gauss plus ema", {11, 7, 9}, sum({half(xy(gauss(1))), half(t(ema(0.1, 0.1)))})),
      construct_problem("sum with weights", {11, 9, 5}, sum({half(xy(box(3)), 0.75), half(t(box(3)), 0.25)})),
      construct_problem("three groups", {7, 5, 6},
                        sum({half(xy(gauss(1)), 0.25), half(t(ema(0.1, 0)), 0.25), half(group({0, 2}, box(2)))})),
      construct_problem("void and cluster's", {9, 8, 7},
                        sum({half(xy(gauss_energy(1.9))), half(t(gauss_energy(1.9)))})),
      construct_problem("gauss-energy over all", {7, 9, 8}, product({group({0, 1, 2}, gauss_energy(1.2))})),
      construct_problem("negative taps and ema", {8, 7, 6}, product({xy(taps_with_negative_ones()), t(ema(0.1, 0.1))})),
      construct_problem("negative taps plus taps", {9, 7, 7},
                        sum({half(xy(taps_with_negative_ones())), half(t(taps_with_negative_ones()))})),
      construct_problem("joint table", {9, 8, 7}, product({group({0, 1, 2}, joint_taps())})),
      construct_problem("planes that cancel", {11, 5, 7}, planes_that_cancel()),
      construct_problem("two slice axes", {7, 5, 3, 4}, product({xy(box(3)), t(ema(0.2, 0.1)), z(gauss(0.7))})),
      construct_problem("an axis that nothing names", {5, 7, 3, 4}, product({xy(gauss(1)), z(ema(0.1, 0.1))})),
      construct_problem("three slice axes", {5, 3, 3, 2, 4},
                        sum({half(xy(gauss(1))), half(group({2, 3}, box(2)), 0.25), half(group({4}, box(3)), 0.25)})),
  };
}

inline std::vector<ConstructProblem> problems_on_both_scales() {
  std::vector<ConstructProblem> problems;
  for (const ConstructProblem& problem : construct_problems()) {
    problems.push_back(problem);
    problems.push_back(problem.on_circle());
  }
  return problems;
}

// A run on this process alone, started.
class AloneConstruction {
 public:
  explicit AloneConstruction(const ConstructProblem& problem, int num_threads = 1)
      : communicator_(Communicator::self()),
        pool_(num_threads),
        run_(Footprint(problem.extents, problem.filter), problem.filter, problem.scale, problem.spec, problem.seed,
             communicator_, pool_) {
    run_.start();
  }
  SliceConstruction& operator*() { return run_; }
  SliceConstruction* operator->() { return &run_; }
  oracle::SliceConstructionOracle::Places places() const {
    oracle::SliceConstructionOracle::Places all;
    for (const SliceIndex slice : first_indices<SliceIndex>(run_.distribution().num_slices()))
      all.push_back(run_.places(slice));
    return all;
  }
  void finish() {
    while (!run_.done()) run_.advance();
  }

 private:
  Communicator communicator_;
  ThreadPool pool_;
  SliceConstruction run_;
};

inline oracle::SliceConstructionOracle::Places places_of(const ConstructProblem& problem, int num_threads = 1) {
  AloneConstruction run(problem, num_threads);
  run.finish();
  return run.places();
}

}  // namespace noiseloom::testing_support
