// Which slices may move at the same time.
//
// Slices that are coupled and all move against a frozen copy of each other chase the same background, and the error
// grows without bound; slices a few apart behave as if they had moved one after another (DESIGN, section 4.4). So the
// slices are divided into classes; one class moves at a time. The division depends on the problem alone, never on ranks
// or threads.
#pragma once

#include <vector>

#include "noiseloom/problem/footprint.h"

namespace noiseloom {

// Smallest distance along one slice axis, from the coupling F(d) >= 0 of that axis (d = 0..size-1, folded, coupling[0]
// > 0), at which slices of one class may stand: 1 without coupling; at least min(4, reach + 1); and so large that the
// coupling to all others of the class stays below 1.6 F(0).
std::int64_t class_stride(const std::vector<double>& coupling);

// Classes in the order in which they move; slices ascending. Every slice is in exactly one class.
std::vector<std::vector<SliceIndex>> colour_classes(const Footprint& footprint);

}  // namespace noiseloom
