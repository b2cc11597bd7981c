// What a run takes depends on the filter through a few figures: how many taps it has, how far it reaches, which slices
// it couples and how strongly. They are found here without the list of all taps, which for a product over a long axis
// has millions and is what the run itself builds.
#pragma once

#include <cstdint>

#include "noiseloom/problem/footprint.h"

namespace noiseloom {

struct FilterOutline {
  Footprint plane;          // reaches along x and y as far as the filter
  Footprint slices;         // couples the same slices, each with the same weight for its own
  std::int64_t num_taps;    // without offset zero
  std::int64_t own_taps;    // of these, inside the slice itself
  bool is_product;          // Footprint::factors(): over plane and slice axes
  bool same_pixel_only;     // other slices: at the same pixel alone
  bool is_counted = false;  // the footprints are the filter's own, all figures exact

  std::int64_t num_coupled_slices() const { return std::ssize(slices.slices()) - 1; }
};

// Figures are exact for footprints of up to 300,000 taps, and beyond for products of separable kernels. gauss-energy
// over axes of the plane and of slices together counts the volume of the ball. Throws UserError for a table that cannot
// be used.
FilterOutline outline_of(const Extents& extents, const FilterSpec& filter, double cutoff);

// About how many taps, in time that does not depend on the answer.
double estimated_taps(const Extents& extents, const FilterSpec& filter);

}  // namespace noiseloom
