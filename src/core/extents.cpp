#include "noiseloom/core/extents.h"

#include <algorithm>

namespace noiseloom {
namespace {

std::vector<std::string> default_names(std::size_t count) {
  const std::vector<std::string> names = {"x", "y", "t", "z", "w", "v", "u", "s"};
  NOISELOOM_CHECK_LE(count, names.size());
  return {names.begin(), names.begin() + static_cast<std::ptrdiff_t>(count)};
}

}  // namespace

Extents::Extents(std::vector<std::int64_t> sizes, std::vector<std::string> names)
    : sizes_(std::move(sizes)), names_(std::move(names)) {
  NOISELOOM_CHECK_EQ(sizes_.size(), names_.size());
  NOISELOOM_CHECK(sizes_.size() >= 2 && sizes_.size() <= max_axes);
  std::int64_t slices = 1;
  for (std::size_t axis = 0; axis < sizes_.size(); ++axis) {
    NOISELOOM_CHECK_LE(1, sizes_[axis]);
    if (axis >= 2) {
      NOISELOOM_CHECK_LE(sizes_[axis], std::numeric_limits<std::int32_t>::max() / slices);
      slices *= sizes_[axis];
    }
  }
  num_slices_ = narrow<std::int32_t>(slices);
}

Extents::Extents(std::vector<std::int64_t> sizes) : Extents(sizes, default_names(sizes.size())) {}

int Extents::axis(const std::string& name) const {
  const auto found = std::find(names_.begin(), names_.end(), name);
  return found == names_.end() ? -1 : static_cast<int>(found - names_.begin());
}

Extents::SliceCoord Extents::slice_coord(SliceIndex slice) const {
  SliceCoord coord{};
  std::int64_t rest = slice.value();
  for (std::size_t axis = 2; axis < sizes_.size(); ++axis) {
    coord[axis - 2] = static_cast<std::int32_t>(rest % sizes_[axis]);
    rest /= sizes_[axis];
  }
  return coord;
}

SliceIndex Extents::slice_index(const SliceCoord& coord) const {
  std::int64_t slice = 0;
  for (std::size_t axis = sizes_.size(); axis-- > 2;) slice = slice * sizes_[axis] + coord[axis - 2];
  return SliceIndex(slice);
}

SliceIndex Extents::slice_at(SliceIndex slice, const SliceCoord& offset) const {
  SliceCoord coord = slice_coord(slice);
  for (std::size_t axis = 2; axis < sizes_.size(); ++axis) {
    const std::int64_t moved = (std::int64_t{coord[axis - 2]} + offset[axis - 2]) % sizes_[axis];
    coord[axis - 2] = static_cast<std::int32_t>(moved < 0 ? moved + sizes_[axis] : moved);
  }
  return slice_index(coord);
}

std::vector<std::int64_t> Extents::file_dimensions() const { return {sizes_.rbegin(), sizes_.rend()}; }

std::string Extents::to_string() const {
  std::string text;
  for (const std::int64_t size : sizes_) text += (text.empty() ? "" : " x ") + std::to_string(size);
  return text;
}

}  // namespace noiseloom
