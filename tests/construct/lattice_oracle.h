// The slow twins of construct/lattice.h: R pair by pair, and places by sorting the phases of all pixels.
#pragma once

#include <cstdint>
#include <vector>

#include "noiseloom/construct/lattice.h"
#include "noiseloom/problem/footprint.h"

namespace noiseloom::oracle {

// Of one slice, which is some places ahead of the first.
std::vector<std::uint32_t> places_of_slice(const Lattice& lattice, const Extents& extents, SliceIndex slice);

// R of the places of all slices as uniform samples.
double relative_error(const Extents& extents, const FilterSpec& filter, const Lattice& lattice);

// Places in the order of the phase, then of the second, then of memory, of pixels counted from (shift_x, shift_y).
std::vector<std::uint32_t> places_by_phase(const Lattice& lattice, const Extents& extents, std::int64_t shift_x,
                                           std::int64_t shift_y);

}  // namespace noiseloom::oracle
