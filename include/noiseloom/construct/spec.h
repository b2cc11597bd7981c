// What void and cluster is asked for, as plain values: the settings of [optimizer] that it alone has, and its problem.
#pragma once

#include <cstdint>
#include <vector>

#include "noiseloom/core/extents.h"

namespace noiseloom {

// What holds every level equally often: the whole volume, or each slice of it.
enum class Equalize { volume, slice };

struct OrderSpec {
  double density = 0.10;     // share of the pixels in the initial pattern, [0, 0.5]
  std::vector<int> bounded;  // axes that do not wrap around
  int bits = 0;              // 0: samples as fine as float32 holds them; else 2^bits levels
  Equalize equalize = Equalize::volume;
};

// How construction goes about it (construct/slice_construction.h).
struct ConstructSpec {
  double density = 0.03;  // share of the pixels of a slice in its start pattern, [0, 0.5]
  double sharpness = 0;   // exponent of the overlap in space, (0, 8]; 0: found from the problem
};

// What void and cluster solves (construct/void_and_cluster.h).
struct VacGroup {
  std::vector<int> axes;  // indices into Extents, each once
  double sigma_px = 1.9;
};

struct VacSpec {
  Extents extents;
  std::vector<VacGroup> groups;
  std::vector<bool> toroidal;  // per axis; empty: all
  double density = 0.10;       // fraction of pixels in the initial pattern (rounded down), [0, 0.5]
  std::uint64_t seed = 1;
};

}  // namespace noiseloom
