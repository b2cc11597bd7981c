// cone: unit vectors within an angle of z, uniform in solid angle. The disk lifted by Lambert's equal-area projection
// onto the cap of the sphere of height 1 - cos(angle).
#include <cmath>

#include "noiseloom/core/math.h"
#include "samples/disk_map.h"
#include "samples/mapped_space.h"
#include "samples/spaces.h"

namespace noiseloom {
namespace {

// 1 - z of a stored unit vector, with full relative accuracy about either pole: there x and y have kept their digits.
double depth_of(const float* sample) {
  const double x = sample[0];
  const double y = sample[1];
  const double z = sample[2];
  const double square = x * x + y * y;
  return z >= 0 ? square / (1 + z) : 2 - square / (1 - z);
}

SpacePtr make_cone(const SpaceTraits& traits, const std::vector<double>& values) {
  const double half_sine = math::sin_2pi(values[0] / 720);
  const double height = 2 * half_sine * half_sine;  // 1 - cos(angle), without its cancellation
  return std::make_unique<MappedSpace>(
      traits, BoxMap{.domain = unit_box(2),
                     .to_sample =
                         [height](int /*channels*/, const double* u, double* sample) {
                           const DiskPoint p = disk_from_square(u[0], u[1]);
                           const double depth = p.radius * p.radius * height;
                           const double scale = std::sqrt(height * (2 - depth));
                           sample[0] = p.x * scale;
                           sample[1] = p.y * scale;
                           sample[2] = 1 - depth;
                         },
                     .to_domain =
                         [height](int /*channels*/, const float* sample, double* u) {
                           const double x = sample[0];
                           const double y = sample[1];
                           const double radius = std::sqrt(depth_of(sample) / height);
                           const double length = std::sqrt(x * x + y * y);
                           const double scale = length > 0 ? radius / length : 0;
                           square_from_disk(x * scale, y * scale, u);
                         },
                     .contains = [height](const float* sample) { return depth_of(sample) <= height; },
                     .density = [height](const float*) { return 1 / (math::two_pi * height); }});
}

}  // namespace

SpaceFamily cone_family() {
  return {.traits = {.name = "cone",
                     .meaning = "a unit vector within an angle of z, uniform",
                     .aliases = "cap spherical-cap spotlight sun",
                     .channels = 3,
                     .dimensions = 2,
                     .distance = DistanceKind::euclidean,
                     .range = ValueRange{-1, 1},
                     .support = Support::unit_vectors,
                     .parameters = {{.name = "angle",
                                     .meaning = "Between z and the border of the cone.",
                                     .initial = 30,
                                     .least = 0.01,
                                     .most = 180,
                                     .unit = "degrees"}},
                     .nvidia_name = "unitvec3_cone",
                     .ea_name = "sphere_cone"},
          .make = make_cone};
}

}  // namespace noiseloom
