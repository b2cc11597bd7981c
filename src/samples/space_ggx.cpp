// ggx: the visible normals of a GGX microsurface: half vectors h in the local frame, z up, that a viewer sees whose
// direction v lies in the plane of x and z (x >= 0), at the angle `view` from z. Reflecting v at h gives the direction
// of the light: l = 2 (v . h) h - v.
//
// The microsurface, stretched until its roughness is 1, is a hemisphere; what v sees of that is a disk of which a part
// is hidden below the horizon, and the disk's points, squeezed into the rest, are lifted onto it [Heitz18]. The density
// over solid angle is that of visible normals [Heitz14]:
//
//   D_v(h) = G1(v) max(0, v . h) D(h) / v_z,   D(h) = 1 / (pi alpha^2 ((h_x^2 + h_y^2) / alpha^2 + h_z^2)^2)
//   G1(v) / v_z = 2 / (v_z + sqrt(v_z^2 + alpha^2 v_x^2))
//
// Compared by the length of their difference: of a smooth surface the normals are so near to each other that float32
// loses the angle between them.
#include <algorithm>
#include <cmath>

#include "noiseloom/core/math.h"
#include "samples/disk_map.h"
#include "samples/mapped_space.h"
#include "samples/spaces.h"

namespace noiseloom {
namespace {

class VisibleNormals {
 public:
  VisibleNormals(double alpha, double view_degrees)
      : alpha_(alpha), view_x_(math::sin_2pi(view_degrees / 360)), view_z_(math::cos_2pi(view_degrees / 360)) {
    const double length = std::sqrt(alpha * alpha * view_x_ * view_x_ + view_z_ * view_z_);
    stretched_x_ = alpha * view_x_ / length;
    stretched_z_ = view_z_ / length;
    seen_ = 0.5 * (1 + stretched_z_);
    masking_ = 2 / (view_z_ + length);
  }

  // The frame of the disk: y, and what is left of x and z across the stretched view.
  void to_sample(const double* u, double* sample) const {
    const DiskPoint p = disk_from_square(u[0], u[1]);
    const double rim = std::sqrt(one_minus_square(p.x));
    const double across = (1 - seen_) * rim + seen_ * p.y;
    // (rim - across) (rim + across), without cancellation
    const double square = seen_ * (rim - p.y) * (2 * (1 - seen_) * rim + seen_ * (rim + p.y));
    const double along = std::sqrt(std::max(0.0, square));
    const double x = alpha_ * (along * stretched_x_ - across * stretched_z_);
    const double y = alpha_ * p.x;
    const double z = std::max(0.0, across * stretched_x_ + along * stretched_z_);
    const double length = std::sqrt(x * x + y * y + z * z);
    sample[0] = x / length;
    sample[1] = y / length;
    sample[2] = z / length;
  }

  void to_domain(const float* sample, double* u) const {
    const double x = sample[0] / alpha_;
    const double y = sample[1] / alpha_;
    const double z = sample[2];
    const double length = std::sqrt(x * x + y * y + z * z);
    const double side = y / length;
    const double across = (z * stretched_x_ - x * stretched_z_) / length;
    const double rim = std::sqrt(std::max(0.0, one_minus_square(side)));
    square_from_disk(side, (across - (1 - seen_) * rim) / seen_, u);
  }

  double density(const float* sample) const {
    const double x = sample[0];
    const double y = sample[1];
    const double z = sample[2];
    if (z <= 0) return 0;
    const double slope = (x * x + y * y) / (alpha_ * alpha_) + z * z;
    return masking_ * std::max(0.0, view_x_ * x + view_z_ * z) / (math::pi * alpha_ * alpha_ * slope * slope);
  }

 private:
  double alpha_;
  double view_x_;
  double view_z_;
  double stretched_x_;  // the direction of the view as the stretched surface sees it
  double stretched_z_;
  double seen_;     // the share of the disk's diameter, across the view, that is not below the horizon
  double masking_;  // G1(v) / v_z
};

SpacePtr make_ggx(const SpaceTraits& traits, const std::vector<double>& values) {
  const VisibleNormals normals(values[0], values[1]);
  return std::make_unique<MappedSpace>(
      traits,
      BoxMap{
          .domain = unit_box(2),
          .to_sample = [normals](int /*channels*/, const double* u, double* sample) { normals.to_sample(u, sample); },
          .to_domain = [normals](int /*channels*/, const float* sample, double* u) { normals.to_domain(sample, u); },
          .contains = [normals](const float* sample) { return normals.density(sample) > 0; },
          .density = [normals](const float* sample) { return normals.density(sample); }});
}

}  // namespace

SpaceFamily ggx_family() {
  return {
      .traits = {.name = "ggx",
                 .meaning = "a half vector, z up: the visible normals of a GGX surface",
                 .aliases = "vndf visible-normals microfacet trowbridge-reitz",
                 .channels = 3,
                 .dimensions = 2,
                 .distance = DistanceKind::euclidean,
                 .range = ValueRange{-1, 1},
                 .support = Support::upper_unit_vectors,
                 .has_constant_density = false,
                 .parameters = {{.name = "roughness",
                                 .meaning = "alpha of the distribution; where the roughness of a material is squared "
                                            "before it is used, as in glTF, its square.",
                                 .initial = 0.3,
                                 .least = 1e-4,
                                 .most = 1},
                                {.name = "view",
                                 .meaning = "Between z and the direction to the viewer, which lies in the plane of x "
                                            "and z, at x >= 0.",
                                 .initial = 60,
                                 .least = 0,
                                 .most = 89.9,
                                 .unit = "degrees"}},
                 .nvidia_name = "unitvec3_ggx",
                 .ea_name = "sphere_ggx"},
      .make = make_ggx};
}

}  // namespace noiseloom
