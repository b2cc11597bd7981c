// The exponent by which construction sharpens the overlap in space (src/construct/stamp_kernel.h), found from the
// filter.
//
// R of a construction does not depend on the size of its slices, and the exponent that is best for a volume is best for
// one slice of it (64x64x16 of gauss 1.3435 x ema: 1.5 for both; box 5 x ema: 1.1 for both;
// tests/bench/construct_bench, --sharpness). So a few exponents are tried on a small twin: one slice, at most 64 pixels
// wide and high, of the filter without its slice axes (of a table over space and slices, which cannot be parted, a few
// slices). The one with the least R is taken. On a circle the best exponents are higher (128x128, gauss 1.0: R 0.050
// with 1, 0.029 with 3.5) and depend on slices that act on each other, so that the twin of these is a small volume. The
// choice depends on the filter, the scale, and on the extents where they are smaller than the twin's, never on the
// seed, the machine, ranks or threads: R is computed in a fixed order of doubles.
#pragma once

#include <functional>
#include <vector>

#include "noiseloom/construct/slice_construction.h"
#include "noiseloom/core/extents.h"
#include "noiseloom/problem/spec.h"

namespace noiseloom {

struct SharpnessTrial {
  double sharpness;
  double relative_error;  // of the twin
};

// Whether all groups are of gauss-energy, which asks for blue noise and not for the least R: then the overlap itself
// makes the slices bluest (128x128x32: half of the power below 0.05 cycles a pixel), and nothing is tried.
bool asks_for_blue_noise(const FilterSpec& filter);

// What was tried, in ascending order; empty where nothing is to be found, as the filter asks for blue noise or reaches
// no other pixel of a slice. Where `goes_on`, which is asked in every round of a trial, says no, what is returned means
// nothing: trials take 0.05 s as a rule, but seconds on a circle whose slices act on each other, and longer where a
// table joins space and many slice axes. Throws UserError for a table that cannot be used.
std::vector<SharpnessTrial> try_sharpness(
    const Extents& extents, const FilterSpec& filter, SampleScale scale = SampleScale::line,
    const std::function<bool()>& goes_on = [] { return true; });

// The exponent of the trial with the least R, the lowest of equals; 1 where nothing was tried.
double best_sharpness(const std::vector<SharpnessTrial>& trials);

}  // namespace noiseloom
