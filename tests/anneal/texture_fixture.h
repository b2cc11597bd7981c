// A small random texture, its energy by a double loop over all pairs of cells, and the change by which a swap moves it.
#pragma once

#include <functional>
#include <random>
#include <string>
#include <vector>

#include "noiseloom/anneal/slice_field.h"
#include "noiseloom/anneal/swap_delta.h"
#include "noiseloom/problem/footprint.h"
#include "noiseloom/problem/value_kernel.h"
#include "support/filter_specs.h"

namespace noiseloom::test {

struct Space {
  std::string name;
  DistanceKind distance;
  int channels;
};

std::vector<Space> all_spaces();
ValueKernel kernel_of(const Space& space, ValueKernelKind kind, int num_axes);

// In double, from the definitions.
double oracle_kernel(const ValueKernel& kernel, const float* a, const float* b);

inline CellPair pair(Cell i, Cell j) { return {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j)}; }

class Texture {
 public:
  Texture(const Footprint& footprint, const ValueKernel& kernel, unsigned seed);

  const SliceField& field(SliceIndex slice) const { return fields_[static_cast<std::size_t>(slice)]; }
  SliceField& field(SliceIndex slice) { return fields_[static_cast<std::size_t>(slice)]; }
  std::function<const SliceField&(SliceIndex)> field_of() const {
    return [this](SliceIndex slice) -> const SliceField& { return field(slice); };
  }

  // sum over ordered pairs j != k of F(j - k) K(s_j, s_k)
  double energy() const;
  // The same of the terms that a swap of two cells of `slice` can change, in magnitude.
  double magnitude(SliceIndex slice, Cell i, Cell j) const;

 private:
  void draw(float* sample);
  double between(SliceIndex slice, Cell cell, SliceIndex other_slice, Cell other) const;
  // visit(F(d), slice of cell + d, cell + d) for all taps d.
  template <class Visit>
  void for_taps(SliceIndex slice, Cell cell, const Visit& visit) const;

  const Footprint& footprint_;
  ValueKernel kernel_;
  std::mt19937 engine_;
  std::vector<SliceField> fields_;
};

}  // namespace noiseloom::test
