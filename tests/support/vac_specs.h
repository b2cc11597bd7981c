// Void and cluster in one line.
#pragma once

#include <utility>
#include <vector>

#include "noiseloom/construct/void_and_cluster.h"

namespace noiseloom::testing_support {

// The defaults of a mask; the same sigma in all groups.
inline VacSpec vac_spec(std::vector<std::int64_t> sizes, std::vector<std::vector<int>> groups, double sigma = 1.9,
                        std::uint64_t seed = 1) {
  VacSpec spec{.extents = Extents(std::move(sizes)), .groups = {}, .toroidal = {}};
  for (auto& axes : groups) spec.groups.push_back({std::move(axes), sigma});
  spec.seed = seed;
  return spec;
}

// The position `by` further along every axis, around the torus.
inline std::uint64_t shifted(const Extents& extents, std::uint64_t position, const std::vector<std::int64_t>& by) {
  std::uint64_t result = 0;
  std::uint64_t unit = 1;
  for (int axis = 0; axis < extents.num_axes(); ++axis) {
    const auto size = static_cast<std::uint64_t>(extents.size(axis));
    const auto step = static_cast<std::uint64_t>(by[static_cast<std::size_t>(axis)]);
    result += (position / unit % size + step) % size * unit;
    unit *= size;
  }
  return result;
}

}  // namespace noiseloom::testing_support
