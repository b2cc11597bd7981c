// Filters from files.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "problem/filters/overlap.h"

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

// What is squared time to correlate: about a second.
constexpr std::int64_t most_taps_of_line = std::int64_t{1} << 17;
constexpr std::int64_t most_taps_of_array = std::int64_t{1} << 16;

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

// Where taps are folded onto an axis that is shorter, they may add up to nothing, or to nothing but rounding.
void check_something_is_left(const std::string& file, std::span<const double> taps, const Overlap& overlap) {
  double zero = 0;  // F(0), the sum of the squares of the folded taps
  for (const OverlapTap& tap : overlap.taps) zero = tap.offset == Offset{} ? tap.weight : zero;
  double magnitude = 0;
  for (const double tap : taps) magnitude += std::abs(tap);
  if (std::sqrt(zero) > 0x1p-45 * magnitude) return;
  refuse(file, "the taps cancel each other where they are folded onto the texture, whose axes are shorter");
}

}  // namespace

Overlap array_overlap(const Extents& extents, const std::vector<int>& axes, const std::vector<std::int64_t>& sizes,
                      std::span<const double> taps) {
  std::vector<std::int64_t> folded_sizes;
  const std::vector<double> folded = folded_array(extents, axes, sizes, taps, folded_sizes);

  // Rows are spaced so that the difference of two flat positions names the offset uniquely. A row of taps is a run of
  // positions one after another.
  const std::int64_t width = folded_sizes[0];
  const auto num_rows = std::ssize(folded) / width;
  std::vector<std::int64_t> row_position(static_cast<std::size_t>(num_rows), 0);
  std::int64_t centre = width - 1;  // the greatest difference
  std::int64_t spacing = 2 * width - 1;
  std::int64_t rows_below = 1;
  for (std::size_t k = 1; k < folded_sizes.size(); ++k) {
    for (std::int64_t row = 0; row < num_rows; ++row) {
      row_position[static_cast<std::size_t>(row)] += row / rows_below % folded_sizes[k] * spacing;
    }
    centre += (folded_sizes[k] - 1) * spacing;
    rows_below *= folded_sizes[k];
    spacing *= 2 * folded_sizes[k] - 1;
  }
  // Every difference gets its terms in ascending order of the first tap.
  std::vector<double> half(static_cast<std::size_t>(centre + 1), 0.0);
  for (std::int64_t row = 0; row < num_rows; ++row) {
    for (std::int64_t x = 0; x < width; ++x) {
      const double tap = folded[static_cast<std::size_t>(row * width + x)];
      if (tap == 0) continue;
      for (std::int64_t other = row; other < num_rows; ++other) {
        const std::int64_t first = other == row ? x : 0;
        const std::int64_t apart =
            row_position[static_cast<std::size_t>(other)] - row_position[static_cast<std::size_t>(row)] - x;
        const double* from = folded.data() + other * width;
        double* to = half.data() + apart;
        for (std::int64_t k = first; k < width; ++k) to[k] += tap * from[k];
      }
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
  const InputArrayPtr array = group.kernel.array ? group.kernel.array : read_double_array(file);
  const auto& taps = std::get<SharedValues<double>>(array->values);
  check_taps(file, taps);
  std::vector<Overlap> overlaps;
  // Taps are folded onto the texture first, so the shorter of both counts.
  const auto refuse_more = [&](std::int64_t count, std::int64_t most) {
    if (count <= most) return;
    refuse(file, fmt::format("{} taps within the texture; at most {} in {}", count, most,
                             array->shape.size() == 1 ? "one dimension" : "several dimensions"));
  };
  if (array->shape.size() == 1) {
    for (const int axis : group.axes) refuse_more(std::min(array->shape[0], extents.size(axis)), most_taps_of_line);
    for (const int axis : group.axes) {
      overlaps.push_back(axis_overlap(extents, axis, ring_overlap(taps, extents.size(axis))));
      check_something_is_left(file, taps, overlaps.back());
    }
    return overlaps;
  }
  if (array->shape.size() != group.axes.size()) {
    refuse(file, fmt::format("{} dimensions; a group of {} axes takes 1{}", array->shape.size(), group.axes.size(),
                             group.axes.size() > 1 ? fmt::format(" or {}", group.axes.size()) : ""));
  }
  std::vector<int> axes = group.axes;
  std::sort(axes.begin(), axes.end());
  std::int64_t count = 1;
  for (std::size_t k = 0; k < axes.size(); ++k) {
    count *= std::min(array->shape[axes.size() - 1 - k], extents.size(axes[k]));
    refuse_more(count, most_taps_of_array);
  }
  overlaps.push_back(array_overlap(extents, axes, {array->shape.rbegin(), array->shape.rend()}, taps));
  check_something_is_left(file, taps, overlaps.back());
  return overlaps;
}

}  // namespace noiseloom
