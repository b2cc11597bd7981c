// Filters from files.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "noiseloom/files/npy.h"
#include "problem/overlap.h"

namespace noiseloom {
namespace {

// Taps wrapped onto the torus: at most extents.size(axis) along each axis.
std::vector<double> folded_array(const Extents& extents, const std::vector<int>& axes,
                                 const std::vector<std::int64_t>& sizes, std::span<const double> taps,
                                 std::vector<std::int64_t>& folded_sizes) {
  folded_sizes.clear();
  std::int64_t cells = 1;
  for (std::size_t k = 0; k < axes.size(); ++k) {
    folded_sizes.push_back(std::min(sizes[k], extents.size(axes[k])));
    cells *= folded_sizes.back();
  }
  std::vector<double> folded(static_cast<std::size_t>(cells), 0.0);
  for (std::size_t i = 0; i < taps.size(); ++i) {
    auto rest = static_cast<std::int64_t>(i);
    std::int64_t index = 0;
    std::int64_t stride = 1;
    for (std::size_t k = 0; k < axes.size(); ++k) {
      index += rest % sizes[k] % folded_sizes[k] * stride;
      rest /= sizes[k];
      stride *= folded_sizes[k];
    }
    folded[static_cast<std::size_t>(index)] += taps[i];
  }
  return folded;
}

[[noreturn]] void refuse(const std::string& file, const std::string& why) {
  throw UserError(file, "filter table: " + why);
}

void check_taps(const std::string& file, std::span<const double> taps) {
  double energy = 0;
  for (std::size_t i = 0; i < taps.size(); ++i) {
    if (!std::isfinite(taps[i])) refuse(file, fmt::format("tap {} is {}; taps must be finite", i, taps[i]));
    energy += taps[i] * taps[i];
  }
  if (!(energy > 0)) refuse(file, "all taps are zero (or too small to square)");
  if (!std::isfinite(energy)) refuse(file, "the squares of the taps overflow");
}

}  // namespace

Overlap array_overlap(const Extents& extents, const std::vector<int>& axes, const std::vector<std::int64_t>& sizes,
                      std::span<const double> taps) {
  std::vector<std::int64_t> folded_sizes;
  const std::vector<double> folded = folded_array(extents, axes, sizes, taps, folded_sizes);

  // Rows are spaced so that the difference of two flat positions names the offset uniquely.
  struct Placed {
    std::int64_t position;
    double tap;
  };
  std::vector<Placed> placed;
  std::int64_t span = 1;
  std::int64_t centre = 0;
  for (const std::int64_t size : folded_sizes) {
    centre += (size - 1) * span;
    span *= 2 * size - 1;
  }
  for (std::size_t i = 0; i < folded.size(); ++i) {
    auto rest = static_cast<std::int64_t>(i);
    std::int64_t position = 0;
    std::int64_t stride = 1;
    for (const std::int64_t size : folded_sizes) {
      position += rest % size * stride;
      rest /= size;
      stride *= 2 * size - 1;
    }
    if (folded[i] != 0) placed.push_back({position, folded[i]});
  }
  std::vector<double> half(static_cast<std::size_t>(centre + 1), 0.0);
  for (std::size_t i = 0; i < placed.size(); ++i) {
    for (std::size_t j = i; j < placed.size(); ++j) {
      half[static_cast<std::size_t>(placed[j].position - placed[i].position)] += placed[i].tap * placed[j].tap;
    }
  }

  // Both signs of an offset get the same terms in the same order, and so the same bits.
  std::vector<OverlapTap> both;
  for (std::size_t difference = 0; difference < half.size(); ++difference) {
    if (half[difference] == 0) continue;
    OverlapTap plus{{}, half[difference]};
    OverlapTap minus = plus;
    std::int64_t rest = static_cast<std::int64_t>(difference) + centre;
    for (std::size_t k = 0; k < axes.size(); ++k) {
      const std::int64_t d = rest % (2 * folded_sizes[k] - 1) - (folded_sizes[k] - 1);
      rest /= 2 * folded_sizes[k] - 1;
      const auto axis = static_cast<std::size_t>(axes[k]);
      plus.offset[axis] = canonical_offset(d, extents.size(axes[k]));
      minus.offset[axis] = canonical_offset(-d, extents.size(axes[k]));
    }
    both.push_back(plus);
    if (difference > 0) both.push_back(minus);
  }
  return {axes, ordered(std::move(both))};
}

std::vector<Overlap> table_overlaps(const Extents& extents, const GroupSpec& group) {
  const std::string& file = group.kernel.file;
  const NpyArray array = read_npy(file);
  check_taps(file, array.values);
  std::vector<Overlap> overlaps;
  if (array.shape.size() == 1) {
    for (const int axis : group.axes) {
      overlaps.push_back(axis_overlap(extents, axis, ring_overlap(array.values, extents.size(axis))));
    }
    return overlaps;
  }
  if (array.shape.size() != group.axes.size()) {
    refuse(file, fmt::format("{} dimensions; a group of {} axes takes 1{}", array.shape.size(), group.axes.size(),
                             group.axes.size() > 1 ? fmt::format(" or {}", group.axes.size()) : ""));
  }
  std::vector<int> axes = group.axes;
  std::sort(axes.begin(), axes.end());
  return {array_overlap(extents, axes, {array.shape.rbegin(), array.shape.rend()}, array.values)};
}

}  // namespace noiseloom
