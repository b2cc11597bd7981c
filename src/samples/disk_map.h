// Measure-preserving maps between the unit square, the disk and the upper half of the sphere, and back: the square's
// concentric map to the disk [ShirleyChiu97], and the disk lifted by Lambert's equal-area projection. All are near to
// isometric.
#pragma once

namespace noiseloom {

struct DiskPoint {
  double x;
  double y;
  double radius;
};

// u, v in [0, 1) -> a point with radius <= 1, and back to u[0], u[1].
DiskPoint disk_from_square(double u, double v);
void square_from_disk(double x, double y, double* u);

// The angle of a point of the plane in turns, [0, 1); 0 for the point 0. From the axis that is nearer, where acos keeps
// its digits.
double turns_of(double x, double y);

// The share of a uniform disk with one coordinate below `value`, and of a uniform sphere (Archimedes: any coordinate of
// a sphere is uniform; it is the same for the upper half, but for z).
double disk_share_below(double value);
inline double sphere_share_below(double value) { return (value + 1) / 2; }

// 1 - r^2, written so that it keeps its relative accuracy at the rim.
inline double one_minus_square(double r) { return (1 - r) * (1 + r); }

// u, v in [0, 1) -> a unit vector with z >= 0, and back, for either sign of z.
void hemisphere_from_square(double u, double v, double* sample);
void square_from_hemisphere(const float* sample, double* u);

}  // namespace noiseloom
