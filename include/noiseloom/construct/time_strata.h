// Places of the pixels of every slice that are stratified over time as well [STBN22s, section 4.3]: blue over space,
// and every pixel visits each of T strata once in the T slices of a stack, in an order of its own.
//
// A place p of n pixels lies in stratum floor(p T / n). As in slice_construction.h every slice is filled point by point
// at the largest void of the filter's overlap; but a pixel that has been filled in one slice of its stack is closed in
// the others until the stratum is complete. A stratum is complete when every slice has n / T pixels more and every
// pixel is filled once more. Of a slice and a pixel that is not filled in it, those that are left make a bipartite
// graph of equal degrees, so that a stratum can always be completed; where a slice is left without an open pixel, one
// is made for it along the shortest chain of slices that hand a pixel on (an augmenting path).
//
// Everything is decided by integers and a keyed hash, so the places depend on nothing but the arguments. They are
// computed as a whole by whoever asks: 4 bytes a pixel of the texture for energies and as many for places.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "noiseloom/core/extents.h"
#include "noiseloom/problem/spec.h"

namespace noiseloom {

// [slice][y][x], places from 0. `axis`: a slice axis, along which T slices make a stack; requires fits_time_strata.
// `sharpness`: as ConstructSpec has it, 0 being found from the filter. Where `goes_on`, which is asked some ten times a
// second and oftener, says no, what is returned means nothing. Throws UserError for a table that cannot be used.
std::vector<std::vector<std::uint32_t>> time_strata(
    const Extents& extents, const FilterSpec& filter, int axis, double sharpness, std::uint64_t seed,
    const std::function<bool()>& goes_on = [] { return true; });

}  // namespace noiseloom
