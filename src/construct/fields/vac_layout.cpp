#include "construct/fields/vac_layout.h"

namespace noiseloom {

VacLayout::VacLayout(const VacSpec& spec, std::int32_t begin, std::int32_t end)
    : num_axes(spec.extents.num_axes()),
      size{},
      toroidal{},
      slice_step{},
      cells(spec.extents.cells_per_slice()),
      num_slices(spec.extents.num_slices()),
      slice_begin(begin),
      slice_end(end) {
  std::int64_t step = 1;
  for (int axis = 0; axis < num_axes; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    size[a] = spec.extents.size(axis);
    toroidal[a] = spec.toroidal.empty() || spec.toroidal[a];
    if (axis < 2) continue;
    slice_step[a] = step;
    step *= size[a];
  }
  leaves = (cells + leaf_cells - 1) / leaf_cells;
  // At least a whole vector behind each slice (a row of taps is padded with zeros), and an odd number of lines.
  const std::int64_t lines = (cells + line_words - 1) / line_words + 1;
  slice_words = (lines | 1) * line_words;
}

VacLayout::Coord VacLayout::coord(std::uint64_t position) const {
  Coord result{};
  for (std::size_t a = 0; a < static_cast<std::size_t>(num_axes); ++a) {
    const auto n = static_cast<std::uint64_t>(size[a]);
    result[a] = static_cast<std::int64_t>(position % n);
    position /= n;
  }
  return result;
}

}  // namespace noiseloom
