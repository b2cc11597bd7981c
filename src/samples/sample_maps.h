// Measure-preserving maps from boxes to the spaces of two and more dimensions, and back.
//
// vector: the unit cube itself. disk: the square's concentric map [Shirley, Chiu 1997,
// doi:10.1080/10867651.1997.10487479]. hemisphere: the disk lifted by Lambert's equal-area projection;
// hemisphere-cosine: lifted straight up (Malley). sphere: the box [0, 2) x [0, 1) is two such squares that share an
// edge, the second mirrored and turned down, so the map is continuous across the shared part of the equator. All maps
// are near to isometric: a stratum that is nearly square in the box is nearly round in the space.
#pragma once

#include "noiseloom/samples/spec.h"
#include "samples/strata.h"

namespace noiseloom {

// The box that is mapped; kind: vector, sphere, hemisphere, hemisphere_cosine or disk.
Box domain(SampleKind kind, int channels);
// u in the domain -> sample, in double.
void to_sample(SampleKind kind, int channels, const double* u, double* sample);
// The inverse, from a sample as it is stored.
void to_domain(SampleKind kind, int channels, const float* sample, double* u);
// What the space promises of a stored sample: |p| <= 1 on the disk, z > 0 on the hemispheres, z != 0 on the sphere (so
// that the sign of z tells the halves apart and no density is 0).
bool lies_in_space(SampleKind kind, const float* sample);

}  // namespace noiseloom
