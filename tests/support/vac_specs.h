// Void and cluster in one line.
#pragma once

#include <utility>
#include <vector>

#include "noiseloom/optimize/void_and_cluster.h"

namespace noiseloom::testing_support {

// The defaults of a mask; the same sigma in all groups.
inline VacSpec vac_spec(std::vector<std::int64_t> sizes, std::vector<std::vector<int>> groups, double sigma = 1.9,
                        std::uint64_t seed = 1) {
  VacSpec spec{.extents = Extents(std::move(sizes)), .groups = {}, .toroidal = {}};
  for (auto& axes : groups) spec.groups.push_back({std::move(axes), sigma});
  spec.seed = seed;
  return spec;
}

}  // namespace noiseloom::testing_support
