// Which slices may move at the same time: those of one colour class.
//
// Slices that are coupled and all move against a frozen copy of each other chase the same background, and the error
// grows without bound; slices a few apart behave as if they had moved one after another. So the
// slices are divided into classes; one class moves at a time. The division depends on the problem alone, never on ranks
// or threads.
#pragma once

#include <vector>

#include "noiseloom/problem/footprint.h"

namespace noiseloom {

// For each slice axis, how far apart the members of a class stand: 1 without coupling, else at least min(4, reach + 1),
// and so far that the coupling of a slice to all other members, over all axes together, stays below 1.6 times that to
// its own cells (each as sum of |F| over the plane).
std::vector<std::int64_t> class_strides(const Footprint& footprint);

// Classes in the order in which they move; slices ascending. Every slice is in exactly one class.
std::vector<std::vector<SliceIndex>> colour_classes(const Footprint& footprint);

}  // namespace noiseloom
