// The pull of all other slices on the samples of the one that moves, through features (feature_map.h). It stands behind
// the taps of the slice itself, which are all taken one by one; hence its name. For filters that are a product over the
// plane and the slice axes, F(dx, dy, o) = plane(dx, dy) along(o):
//
//   sum over the other slices of F (K(b, s) - K(a, s)), at cell i less at cell j  =  (f(b) - f(a)) . (B_i - B_j)
//   B = A sum_d plane(d) sum_{o != 0} along(o) f(sample at slice offset o, d away)
//
// for a sample a at i and b at j. Each cell holds f of its sample and B, one after the other, so that a candidate reads
// two runs of memory; a swap exchanges the two f and leaves B alone.
//
// The cost of a candidate does not depend on the depth of the filter; binding a slice costs (slices + plane taps per
// axis) x features a cell.
#pragma once

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "anneal/fields/tap_plan.h"
#include "noiseloom/anneal/feature_map.h"
#include "noiseloom/anneal/swap_delta.h"

namespace noiseloom {

struct WeightedField {
  const SliceField* field;
  float weight;
};

// The slices that act on a moving one, with their weights, as fields of its window.
class SlicesAround {
 public:
  // `footprint` must outlive the object.
  SlicesAround(const Footprint& footprint, const FieldLayout& window) : footprint_(footprint), window_(window) {}

  void add(const Extents::SliceCoord& offset, double weight) {
    weights_.emplace_back(offset, static_cast<float>(weight));
  }
  bool empty() const { return weights_.empty(); }
  // Around `slice`, whose window lies at `corner`; valid until the next call.
  std::vector<WeightedField> fields(SliceIndex slice, Corner corner, const FieldOf& others);

 private:
  const Footprint& footprint_;
  FieldLayout window_;
  std::vector<std::pair<Extents::SliceCoord, float>> weights_;
  std::vector<SliceField> windows_;  // where the window is not the whole slice
};

class Background {
 public:
  // Requires footprint.factors(). Both must outlive the object.
  Background(const Footprint& footprint, const FeatureMap& map, WindowSize window);

  // `own`: the window at `corner` itself.
  void bind(SliceIndex slice, Corner corner, const SliceField& own, const FieldOf& others);
  void swap(CellPair pair);

  // A multiple of block_lanes; lanes past the map's features are zero.
  std::int64_t num_lanes() const { return num_lanes_; }
  // num_lanes() values of f of the sample at a cell, then as many of B there.
  const float* at(Cell cell) const { return values_of(cells_) + cell * 2 * num_lanes_; }

  struct Filter {
    std::vector<float> along_x;  // plane(d, 0), d = -reach..reach; empty where the plane is not separable
    std::vector<float> along_y;  // plane(0, d) / plane(0, 0)
    std::vector<PlaneTap> taps;  // all, where it is not
  };

 private:
  const FeatureMap& map_;
  FieldLayout layout_;  // of the window
  std::int64_t num_lanes_;
  SlicesAround around_;
  Filter filter_;
  std::vector<float> mixing_;  // A, rows of num_lanes
  std::vector<float> sums_;    // [feature][plane with border]
  std::vector<float> scratch_;
  std::vector<BlockWeights> cells_;  // aligned, so that a cell's lie in as few cache lines as can be
};

// The plane of a footprint, its centre among the taps, as a filter; separable where it is the product of its middle row
// and column to within `within` of its centre. Taps beyond the reach of the layout are left out.
Background::Filter make_plane_filter(std::span<const PlaneTap> taps, const FieldLayout& layout, double within);
// Other slices and along(o), without those that hardly count. Requires footprint.factors().
std::vector<std::pair<Extents::SliceCoord, double>> weights_along(const Footprint& footprint);
// The map's features, rounded up to whole blocks of lanes.
std::int64_t padded_lanes(const FeatureMap& map);
// A, in rows of num_lanes, padded by zeros.
std::vector<float> padded_mixing(const FeatureMap& map, std::int64_t num_lanes);

}  // namespace noiseloom
