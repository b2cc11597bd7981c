// A million swaps: the energy that their changes add up to is the energy that is found afresh.
#include <gtest/gtest.h>

#include "noiseloom/anneal/swap_delta.h"
#include "noiseloom/core/random.h"
#include "noiseloom/problem/score.h"
#include "noiseloom/samples/sample_space.h"
#include "support/filter_specs.h"
#include "support/sanitizers.h"

namespace noiseloom {
namespace {

using namespace testing_support;

// How far R, followed through `count` swaps by their dE, ends from R as it then is: dR = dE / (n m F(0)).
double drift(const std::string& kind, Precision precision, int count) {
  ProblemSpec problem{Extents({31, 37, 3}),
                      {},
                      Stratify::slice,
                      1,
                      product({group({0, 1}, gauss(1.0)), group({2}, ema(0.2, 0.1))}),
                      {}};
  problem.samples.space = kind;
  const Extents& extents = problem.extents;
  const Cell cells = extents.cells_per_slice();
  const SampleSource source(problem.samples, cells, extents.num_slices(), 1);
  const Footprint footprint(extents, problem.filter);
  std::vector<SliceField> fields;
  for (const SliceIndex slice : extents.slices()) {
    fields.emplace_back(FieldLayout(footprint, source.channels()));
    fields.back().fill(start_permutation(1, slice, cells), source.list(slice));
  }
  ThreadPool pool(1);
  const MeanDistance mean(source.distance(), source.channels(), cells, extents.num_slices());
  const double m = mean.compute([&](SliceIndex slice) { return source.list(slice); }, pool);
  const auto score = [&] {
    std::vector<std::vector<float>> planar;
    for (const SliceField& field : fields) planar.push_back(field.planar());
    std::vector<double> sums;
    for (const SliceIndex slice : extents.slices()) {
      sums.push_back(weighted_distance_sum(footprint, source.distance(), source.channels(), slice,
                                           [&](SliceIndex s) { return planar[static_cast<std::size_t>(s)].data(); }));
    }
    return relative_error(footprint, m, sums);
  };

  const double start = score();
  const auto delta =
      make_swap_delta(footprint, make_value_kernel(problem, source.channels(), source.distance()), precision);
  delta->bind(SliceIndex(1), fields[1],
              [&](SliceIndex s) -> const SliceField& { return fields[static_cast<std::size_t>(s)]; });
  double change = 0;
  for (int k = 0; k < count; ++k) {
    const RandomBlock bits = random_block(1, Purpose::proposal, 0, 0, static_cast<std::uint64_t>(k));
    const CellPair pair{to_below(bits[0], static_cast<std::uint32_t>(cells)),
                        to_below(bits[1], static_cast<std::uint32_t>(cells))};
    if (pair.i == pair.j) continue;
    change += delta->delta(pair);
    delta->swap(pair);
    fields[1].swap(pair.i, pair.j);
  }
  const double followed = start + change / (static_cast<double>(extents.num_cells()) * m * footprint.weight_zero());
  return std::abs(followed - score());
}

// Under sanitizers: vectors made of scalars, every access checked, 60 us a swap.
constexpr int million = under_sanitizers ? 20'000 : 1'000'000;

TEST(HardCases, AMillionSwapsInDoubleLeaveNoDrift) {
  EXPECT_LT(drift("uniform", Precision::float64, million), 1e-10);
  EXPECT_LT(drift("sphere", Precision::float64, 3000), 1e-10);  // fewer: 100 times as slow
}

TEST(HardCases, AMillionSwapsInFloatDriftByLessThanAHundredThousandth) {
  for (const char* const kind : {"uniform", "circle", "sphere"}) {
    EXPECT_LT(drift(kind, Precision::float32, million), 1e-5);
  }
}

}  // namespace
}  // namespace noiseloom
