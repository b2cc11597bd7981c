// Where the texels of an image lie in the space that it covers, and how large they are there.
//
//   square       the image fills [0, 1)^2; x grows to the right and y downward, as texture coordinates do
//   disk         it fills [-1, 1]^2 in the same sense; what lies outside of the unit disk is left out
//   sphere       equirectangular, y up: the column at u (0 to 1, left to right) and the row at v (0 to 1, downward)
//   look
//                along (sin a cos b, cos a, sin a sin b), a = pi v, b = 2 pi u
//   hemisphere   the same image; only its upper half, y > 0, is used
//
// Positions are in texels: 0 to width, 0 to height. Equal parts of a texel have equal measure, so that a density which
// is constant in each texel is constant in these coordinates, too. On the sphere, y therefore runs within a row as cos
// a does; a texel that the rim of the disk cuts is squeezed into the part that lies inside.
#pragma once

#include <vector>

#include "noiseloom/samples/spec.h"
#include "samples/mass_grid.h"

namespace noiseloom {

class ImageGeometry {
 public:
  ImageGeometry(ImageDomain domain, int width, int height);

  int channels() const { return is_direction() ? 3 : 2; }
  // Area or solid angle of a texel; 0 where it lies outside.
  double measure(int x, int y) const;
  // A position in texels -> channels() coordinates.
  void to_sample(const TexelPoint& point, double* sample) const;
  // The inverse, from a sample as it is stored; clamped to the grid. Directions need no exact length.
  TexelPoint to_texels(const float* sample) const;
  // The axis along which a box is longer in the space.
  GridAxis longer_axis(const TexelBox& box) const;

 private:
  bool is_direction() const { return domain_ == ImageDomain::sphere || domain_ == ImageDomain::hemisphere; }
  // Of directions: (1 - cos a) / 2 at a position on the y axis.
  double depth_at(double y) const;
  // The part of a texel that lies in the disk.
  class ClippedTexel;

  ImageDomain domain_;
  int width_;
  int height_;
  std::vector<double> depth_;  // of directions: (1 - cos a) / 2 at the edges of the rows, 0 to 1 (hemisphere: to 1/2)
};

}  // namespace noiseloom
