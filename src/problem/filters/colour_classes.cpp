#include "noiseloom/problem/colour_classes.h"

#include <algorithm>
#include <cmath>

namespace noiseloom {
namespace {

constexpr std::int64_t usual_stride = 4;
constexpr double tolerated_coupling = 1.6;

// How much the slices of a class act on each other, for any spacing of its members.
//
// The coupling of a slice to the slice at an offset is the sum of |F| over the plane there. A class with the strides s
// holds, along each slice axis, the offsets d with d or size - |d| a multiple of s: the last members of a ring stand at
// least a stride apart, not always a multiple of it.
class LatticeCoupling {
 public:
  explicit LatticeCoupling(const Footprint& footprint) : extents_(footprint.extents()) {
    double box = 1;
    for (int axis = 2; axis < extents_.num_axes(); ++axis) {
      reach_.push_back(footprint.reach(axis));
      box *= static_cast<double>(2 * reach_.back() + 1);
    }
    const bool dense = box <= most_of_table * static_cast<double>(footprint.slices().size());
    if (dense) table_.resize(static_cast<std::size_t>(box));
    for (const SliceTaps& slice : footprint.slices()) {
      if (slice.offset == Extents::SliceCoord{}) continue;
      if (dense) {
        table_[index(slice.offset)] = plane_weight(slice);
      } else {
        list_.emplace_back(slice.offset, plane_weight(slice));
      }
    }
  }

  // The coupling of a slice to all other members of its class. Both ways of finding it add up the same numbers in the
  // same order, that of the footprint.
  double sum(const std::vector<std::int64_t>& strides) const {
    double total = 0;
    if (table_.empty()) {
      for (const auto& [offset, weight] : list_) {
        if (on_lattice(offset, strides)) total += weight;
      }
      return total;
    }
    std::vector<std::vector<std::int32_t>> members;
    for (std::size_t k = 0; k < strides.size(); ++k) members.push_back(members_along(k, strides[k]));
    Extents::SliceCoord offset{};
    add_members(members, strides.size(), offset, total);
    return total;
  }

 private:
  // A table of all offsets within the reach is quicker where few of them are empty: a sum over one class then takes
  // time in proportion to the members of the class, not to all offsets.
  static constexpr double most_of_table = 4;

  static double plane_weight(const SliceTaps& slice) {
    double weight = 0;
    for (const PlaneTap& tap : slice.taps) weight += std::abs(tap.weight);
    return weight;
  }

  bool is_member(std::size_t k, std::int64_t d, std::int64_t stride) const {
    return d % stride == 0 || (extents_.size(static_cast<int>(k) + 2) - std::abs(d)) % stride == 0;
  }
  bool on_lattice(const Extents::SliceCoord& offset, const std::vector<std::int64_t>& strides) const {
    for (std::size_t k = 0; k < strides.size(); ++k) {
      if (!is_member(k, offset[k], strides[k])) return false;
    }
    return true;
  }

  // Offsets of the members of a class along one axis within the reach, ascending.
  std::vector<std::int32_t> members_along(std::size_t k, std::int64_t stride) const {
    const std::int64_t size = extents_.size(static_cast<int>(k) + 2);
    std::vector<std::int32_t> offsets;
    const auto add = [&](std::int64_t d) {
      offsets.push_back(static_cast<std::int32_t>(d));
      offsets.push_back(static_cast<std::int32_t>(-d));
    };
    for (std::int64_t d = 0; d <= reach_[k]; d += stride) add(d);
    for (std::int64_t d = size - (size - reach_[k] + stride - 1) / stride * stride; d >= 0; d -= stride) add(d);
    std::sort(offsets.begin(), offsets.end());
    offsets.erase(std::unique(offsets.begin(), offsets.end()), offsets.end());
    return offsets;
  }

  // The last axis outermost, as in the footprint.
  void add_members(const std::vector<std::vector<std::int32_t>>& members, std::size_t axes, Extents::SliceCoord& offset,
                   double& total) const {
    if (axes == 0) {
      total += table_[index(offset)];
      return;
    }
    for (const std::int32_t d : members[axes - 1]) {
      offset[axes - 1] = d;
      add_members(members, axes - 1, offset, total);
    }
  }

  std::size_t index(const Extents::SliceCoord& offset) const {
    std::int64_t at = 0;
    for (std::size_t k = reach_.size(); k-- > 0;) at = at * (2 * reach_[k] + 1) + offset[k] + reach_[k];
    return static_cast<std::size_t>(at);
  }

  const Extents& extents_;
  std::vector<std::int64_t> reach_;
  std::vector<double> table_;  // by offset, last axis counting most; zero where nothing couples
  std::vector<std::pair<Extents::SliceCoord, double>> list_;  // instead, where most of the table would be zero
};

// |F| over the plane of the own slice: what the coupling to others is measured by.
double own_coupling(const Footprint& footprint) {
  double own = footprint.weight_zero();
  for (const PlaneTap& tap : footprint.slices()[0].taps) own += std::abs(tap.weight);
  return own;
}

// The colours of the positions of an axis: same colour means at least `stride` apart on the ring. The positions that
// are left over at its end have colours of their own.
class AxisColours {
 public:
  AxisColours(std::int64_t size, std::int64_t stride)
      : stride_(stride), regular_(stride == 1 || size >= 2 * stride ? size - size % stride : 0) {
    const std::int64_t left_over = size - regular_;
    count_ = (regular_ > 0 ? stride : 0) + left_over;
  }
  std::int64_t count() const { return count_; }
  std::int64_t of(std::int64_t position) const {
    if (position < regular_) return position % stride_;
    return (regular_ > 0 ? stride_ : 0) + position - regular_;
  }

 private:
  std::int64_t stride_;
  std::int64_t regular_;  // positions before this one repeat with the stride
  std::int64_t count_ = 0;
};

}  // namespace

std::vector<std::int64_t> class_strides(const Footprint& footprint) {
  const Extents& extents = footprint.extents();
  const LatticeCoupling coupling(footprint);
  std::vector<std::int64_t> strides;
  for (int axis = 2; axis < extents.num_axes(); ++axis) {
    strides.push_back(std::min<std::int64_t>(usual_stride, footprint.reach(axis) + 1));
  }
  const double tolerated = tolerated_coupling * own_coupling(footprint);
  while (coupling.sum(strides) > tolerated) {
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
  std::vector<AxisColours> colours;
  std::int64_t num_classes = 1;
  for (int axis = 2; axis < extents.num_axes(); ++axis) {
    colours.emplace_back(extents.size(axis), strides[static_cast<std::size_t>(axis - 2)]);
    num_classes *= colours.back().count();
  }
  std::vector<std::vector<SliceIndex>> classes(static_cast<std::size_t>(num_classes));
  for (const SliceIndex slice : extents.slices()) {
    const Extents::SliceCoord coord = extents.slice_coord(slice);
    std::int64_t index = 0;
    for (std::size_t axis = colours.size(); axis-- > 0;) {
      index = index * colours[axis].count() + colours[axis].of(coord[axis]);
    }
    classes[static_cast<std::size_t>(index)].push_back(slice);
  }
  std::erase_if(classes, [](const auto& members) { return members.empty(); });
  return classes;
}

}  // namespace noiseloom
