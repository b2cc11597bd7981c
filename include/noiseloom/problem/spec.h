// What the user asked for, as plain values: the part of a config that defines the problem (not how it is solved). What
// a pixel holds stands in samples/spec.h.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "noiseloom/core/extents.h"
#include "noiseloom/samples/spec.h"

namespace noiseloom {

enum class KernelKind { box, gauss, binomial, ema, table, gauss_energy, eye };

struct KernelSpec {
  KernelKind kind = KernelKind::box;
  int size = 3;        // box: taps per axis
  double sigma = 1.0;  // gauss, gauss_energy: pixels
  // gauss_energy: along these axes of the group, indices into Extents, the energy is the overlap of a box of box_size
  // taps instead: that of the sum of so many slices in a row, for every such run.
  std::vector<int> box_axes;
  int box_size = 0;
  // gauss_energy, of void and cluster: the slices along these axes of the group are tiles that fit one another at every
  // edge; and the energy has a tail, at least tail / (tail + r^(2 tail_power)) at distance r, in pixels. 0: no tail; a
  // power of 1.
  std::vector<int> tile_axes;
  double tail = 0;
  double tail_power = 0;
  double frames_per_second = 60;  // eye: of the display
  double pixels_per_degree = 40;  // eye: of the field of view
  int n = 2;                      // binomial: n + 1 taps per axis
  double alpha = 0.1;             // ema: weight of the current frame, (0, 1]
  double rejection = 0.1;         // ema: probability beta that the history is rejected, [0, 1]
  std::string file;               // table: .npy of 1 dimension (taps of each axis) or of as many as the group has axes
  InputArrayPtr array;            // table: its contents where they are known; else whoever needs them reads the file
};

struct GroupSpec {
  std::vector<int> axes;  // indices into Extents, in the order written
  KernelSpec kernel;
  double weight = 0;  // sum: given or equal, adding up to 1; product: unused

  bool is_box_along(int axis) const {
    return std::find(kernel.box_axes.begin(), kernel.box_axes.end(), axis) != kernel.box_axes.end();
  }
  bool is_tile_along(int axis) const {
    return std::find(kernel.tile_axes.begin(), kernel.tile_axes.end(), axis) != kernel.tile_axes.end();
  }
};

enum class Combine { product, sum };

struct FilterSpec {
  Combine combine = Combine::product;
  std::vector<GroupSpec> groups;
};

enum class ValueKernelKind { distance, stbn };

struct ValueKernelSpec {
  ValueKernelKind kind = ValueKernelKind::distance;
  double sigma_s = 1.0;  // stbn only
};

// What the strata of the samples are spread over: the pixels of every slice, one in each; or also over the axis t, of
// length T, so that every pixel visits each of T strata once in T slices [STBN22s, section 4.3].
enum class Stratify { slice, slice_and_time };

// Whether the length T of a slice axis divides the pixels of a slice, so that strata can be spread over it too.
inline bool fits_time_strata(const Extents& extents, int axis) {
  return extents.cells_per_slice() % extents.size(axis) == 0;
}

struct ProblemSpec {
  Extents extents;
  SampleSpec samples;
  Stratify stratify = Stratify::slice;
  std::uint64_t seed = 1;
  FilterSpec filter;
  ValueKernelSpec value_kernel;
};

}  // namespace noiseloom
