#include "noiseloom/optimize/colour_classes.h"

#include <algorithm>
#include <cmath>

namespace noiseloom {
namespace {

constexpr std::int64_t usual_stride = 4;
constexpr double tolerated_coupling = 1.6;

// Coupling along one slice axis alone, as sums of |F| over the plane.
std::vector<double> axis_coupling(const Footprint& footprint, int axis) {
  const std::int64_t size = footprint.extents().size(axis);
  std::vector<double> coupling(static_cast<std::size_t>(size));
  coupling[0] = footprint.weight_zero();
  for (const SliceTaps& slice : footprint.slices()) {
    Extents::SliceCoord others = slice.offset;
    const std::int32_t along = others[static_cast<std::size_t>(axis - 2)];
    others[static_cast<std::size_t>(axis - 2)] = 0;
    // Coupling oblique to the axes counts on every axis that it moves along.
    if (along == 0 && others != Extents::SliceCoord{}) continue;
    const auto at = static_cast<std::size_t>((along % size + size) % size);
    double sum = 0;
    for (const PlaneTap& tap : slice.taps) sum += std::abs(tap.weight);
    coupling[at] = others == Extents::SliceCoord{} ? coupling[at] + sum : std::max(coupling[at], sum);
  }
  return coupling;
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

std::int64_t class_stride(const std::vector<double>& coupling) {
  const auto size = static_cast<std::int64_t>(coupling.size());
  std::int64_t reach = 0;
  for (std::int64_t d = 1; d < size; ++d) {
    if (coupling[static_cast<std::size_t>(d)] > 0) reach = std::max(reach, std::min(d, size - d));
  }
  if (reach == 0) return 1;
  for (std::int64_t stride = std::min(usual_stride, reach + 1); 2 * stride <= size; ++stride) {
    double others = 0;
    for (std::int64_t d = stride; d + stride <= size; d += stride) others += coupling[static_cast<std::size_t>(d)];
    if (others <= tolerated_coupling * coupling[0]) return stride;
  }
  return size;
}

std::vector<std::vector<SliceIndex>> colour_classes(const Footprint& footprint) {
  const Extents& extents = footprint.extents();
  std::vector<std::vector<std::int64_t>> colours;
  std::int64_t num_classes = 1;
  for (int axis = 2; axis < extents.num_axes(); ++axis) {
    colours.push_back(axis_colours(extents.size(axis), class_stride(axis_coupling(footprint, axis))));
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
