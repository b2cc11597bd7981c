#include "noiseloom/anneal/colour_classes.h"

#include <algorithm>
#include <cmath>

namespace noiseloom {
namespace {

constexpr std::int64_t usual_stride = 4;
constexpr double tolerated_coupling = 1.6;

struct Coupling {
  Extents::SliceCoord offset;
  double weight;  // sum of |F| over the plane, offset not zero
};

std::vector<Coupling> couplings_of(const Footprint& footprint) {
  std::vector<Coupling> couplings;
  for (const SliceTaps& slice : footprint.slices()) {
    if (slice.offset == Extents::SliceCoord{}) continue;
    double weight = 0;
    for (const PlaneTap& tap : slice.taps) weight += std::abs(tap.weight);
    couplings.push_back({slice.offset, weight});
  }
  return couplings;
}

// |F| over the plane of the own slice: what the coupling to others is measured by.
double own_coupling(const Footprint& footprint) {
  double own = footprint.weight_zero();
  for (const PlaneTap& tap : footprint.slices()[0].taps) own += std::abs(tap.weight);
  return own;
}

// The coupling of a slice to all others that stand on its lattice.
double lattice_coupling(const Extents& extents, const std::vector<Coupling>& couplings,
                        const std::vector<std::int64_t>& strides) {
  double sum = 0;
  for (const Coupling& coupling : couplings) {
    bool together = true;
    for (int axis = 2; axis < extents.num_axes(); ++axis) {
      const auto k = static_cast<std::size_t>(axis - 2);
      const std::int64_t d = std::abs(std::int64_t{coupling.offset[k]});
      // The last members of a ring stand at least a stride apart, not always a multiple of it.
      together = together && (d % strides[k] == 0 || (extents.size(axis) - d) % strides[k] == 0);
    }
    if (together) sum += coupling.weight;
  }
  return sum;
}

// Colour of every position of an axis: same colour means at least `stride` apart on the ring.
std::vector<std::int64_t> axis_colours(std::int64_t size, std::int64_t stride) {
  std::vector<std::int64_t> colours(static_cast<std::size_t>(size));
  const std::int64_t regular = size >= 2 * stride ? size - size % stride : 0;
  for (std::int64_t p = 0; p < size; ++p) {
    colours[static_cast<std::size_t>(p)] = stride == 1   ? 0
                                           : p < regular ? p % stride
                                                         : stride * (regular > 0) + p - regular;
  }
  return colours;
}

}  // namespace

std::vector<std::int64_t> class_strides(const Footprint& footprint) {
  const Extents& extents = footprint.extents();
  const std::vector<Coupling> couplings = couplings_of(footprint);
  std::vector<std::int64_t> strides;
  for (int axis = 2; axis < extents.num_axes(); ++axis) {
    strides.push_back(std::min<std::int64_t>(usual_stride, footprint.reach(axis) + 1));
  }
  const double tolerated = tolerated_coupling * own_coupling(footprint);
  while (lattice_coupling(extents, couplings, strides) > tolerated) {
    // The axis whose members stand nearest for its length gives way; a stride that no two members fit is the whole
    // axis.
    int widest = -1;
    for (int axis = 2; axis < extents.num_axes(); ++axis) {
      const auto k = static_cast<std::size_t>(axis - 2);
      if (footprint.reach(axis) == 0 || strides[k] >= extents.size(axis)) continue;
      const auto best = static_cast<std::size_t>(widest - 2);
      if (widest < 0 || strides[k] * extents.size(widest) < strides[best] * extents.size(axis)) widest = axis;
    }
    if (widest < 0) break;
    std::int64_t& stride = strides[static_cast<std::size_t>(widest - 2)];
    stride = 2 * (stride + 1) <= extents.size(widest) ? stride + 1 : extents.size(widest);
  }
  return strides;
}

std::vector<std::vector<SliceIndex>> colour_classes(const Footprint& footprint) {
  const Extents& extents = footprint.extents();
  const std::vector<std::int64_t> strides = class_strides(footprint);
  std::vector<std::vector<std::int64_t>> colours;
  std::int64_t num_classes = 1;
  for (int axis = 2; axis < extents.num_axes(); ++axis) {
    colours.push_back(axis_colours(extents.size(axis), strides[static_cast<std::size_t>(axis - 2)]));
    num_classes *= *std::max_element(colours.back().begin(), colours.back().end()) + 1;
  }
  std::vector<std::vector<SliceIndex>> classes(static_cast<std::size_t>(num_classes));
  for (SliceIndex slice = 0; slice < extents.num_slices(); ++slice) {
    const Extents::SliceCoord coord = extents.slice_coord(slice);
    std::int64_t index = 0;
    for (std::size_t axis = colours.size(); axis-- > 0;) {
      const auto& axis_colour = colours[axis];
      index = index * (*std::max_element(axis_colour.begin(), axis_colour.end()) + 1) +
              axis_colour[static_cast<std::size_t>(coord[axis])];
    }
    classes[static_cast<std::size_t>(index)].push_back(slice);
  }
  std::erase_if(classes, [](const auto& members) { return members.empty(); });
  return classes;
}

}  // namespace noiseloom
