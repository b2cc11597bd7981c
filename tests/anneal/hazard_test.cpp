// All slices that move at once against a frozen copy of the others chase the same background, and the run does not
// converge. Colour classes prevent it.
#include <gtest/gtest.h>

#include <map>

#include "noiseloom/anneal/slice_mover.h"
#include "noiseloom/problem/colour_classes.h"
#include "noiseloom/problem/score.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {
namespace {

using Classes = std::vector<std::vector<SliceIndex>>;

// A scalar texture whose slices are strongly coupled: a running mean over 12 of 24 frames.
class CoupledTexture {
 public:
  CoupledTexture()
      : extents_({24, 24, 24}),
        footprint_(extents_, filter()),
        source_({}, extents_.cells_per_slice(), extents_.num_slices(), 1) {}

  const Footprint& footprint() const { return footprint_; }

  // R after `sweeps` cold sweeps with these classes.
  double anneal(const Classes& classes, std::uint32_t sweeps) {
    fields_.clear();
    permutations_.clear();
    for (const SliceIndex slice : extents_.slices()) {
      permutations_.push_back(start_permutation(1, slice, extents_.cells_per_slice()));
      fields_.emplace_back(FieldLayout(footprint_, 1)).fill(permutations_.back(), source_.list(slice));
    }
    for (std::uint32_t sweep = 0; sweep < sweeps; ++sweep) {
      for (const auto& members : classes) move(members, sweep);
    }
    return score();
  }

  double score() {
    std::map<SliceIndex, std::vector<float>> planar;
    for (const SliceIndex slice : extents_.slices()) {
      planar[slice] = fields_[static_cast<std::size_t>(slice)].planar();
    }
    ThreadPool pool(1);
    const MeanDistance mean(DistanceKind::absolute, 1, extents_.cells_per_slice(), extents_.num_slices());
    std::vector<double> sums;
    for (const SliceIndex slice : extents_.slices()) {
      sums.push_back(weighted_distance_sum(footprint_, DistanceKind::absolute, 1, slice,
                                           [&](SliceIndex s) { return planar.at(s).data(); }));
    }
    return relative_error(footprint_, mean.compute([this](SliceIndex s) { return source_.list(s); }, pool), sums);
  }

 private:
  static FilterSpec filter() {
    FilterSpec filter;
    filter.groups.resize(2);
    filter.groups[0].axes = {0, 1};
    filter.groups[1].axes = {2};
    filter.groups[1].kernel.size = 12;
    return filter;
  }

  void move(const std::vector<SliceIndex>& members, std::uint32_t sweep) {
    const PartnerDraw partners(extents_.cells_per_slice(), {64}, false);
    AnnealMover mover(make_swap_delta(footprint_, {}, Precision::float32));
    std::vector<VisitResult> results;
    for (const SliceIndex slice : members) {
      const auto k = static_cast<std::size_t>(slice);
      results.push_back(
          mover.visit({slice, sweep, 1}, 0, partners, fields_[k], permutations_[k],
                      [this](SliceIndex s) -> const SliceField& { return fields_[static_cast<std::size_t>(s)]; }));
    }
    for (std::size_t m = 0; m < members.size(); ++m) {
      const auto k = static_cast<std::size_t>(members[m]);
      for (const Swap& swap : results[m].swaps) {
        fields_[k].swap(swap.a, swap.b);
        std::swap(permutations_[k][swap.a], permutations_[k][swap.b]);
      }
    }
  }

  Extents extents_;
  Footprint footprint_;
  SampleSource source_;
  std::vector<SliceField> fields_;
  std::vector<Permutation> permutations_;
};

TEST(Hazard, ColourClassesConvergeWhereAllSlicesAtOnceDoNot) {
  CoupledTexture texture;
  const double start = texture.anneal({}, 0);
  const IndexRange<SliceIndex> all = first_indices<SliceIndex>(24);
  const Classes together = {std::vector<SliceIndex>(all.begin(), all.end())};
  Classes apart;
  for (const SliceIndex slice : all) apart.push_back({slice});

  const double one_by_one = texture.anneal(apart, 12);
  const double classes = texture.anneal(colour_classes(texture.footprint()), 12);
  const double at_once = texture.anneal(together, 12);
  EXPECT_LT(one_by_one, 0.2 * start);
  EXPECT_LT(classes, 1.1 * one_by_one);
  EXPECT_GT(at_once, 3 * one_by_one);
}

}  // namespace
}  // namespace noiseloom
