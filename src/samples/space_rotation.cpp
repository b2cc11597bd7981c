// rotation: unit quaternions (x, y, z, w) with w >= 0, w the cosine of half the angle, uniform over all rotations
// [Shoemake92]. A quaternion and its opposite are the same rotation; samples are compared by the sine of half the
// angle of the rotation between them.
//
// The pair (x, y) of a uniform point of the sphere of quaternions is a uniform point of the disk, and (z, w) lies
// evenly on the circle that is left, of which half is enough. The box is the square of the disk and that half circle,
// in the proportions of their mean lengths.
#include <cmath>

#include "noiseloom/core/math.h"
#include "samples/disk_map.h"
#include "samples/mapped_space.h"
#include "samples/spaces.h"

namespace noiseloom {
namespace {

constexpr double half_circle = 1.2;  // pi times the mean radius of 2/3, where the square's side is sqrt(pi)

void quaternion_from_box(int /*channels*/, const double* u, double* sample) {
  const DiskPoint p = disk_from_square(u[0], u[1]);
  const double radius = std::sqrt(one_minus_square(p.radius));
  const double turns = 0.5 * u[2] / half_circle;
  sample[0] = p.x;
  sample[1] = p.y;
  sample[2] = radius * math::cos_2pi(turns);
  sample[3] = radius * math::sin_2pi(turns);
}

void box_from_quaternion(int /*channels*/, const float* sample, double* u) {
  square_from_disk(sample[0], sample[1], u);
  const double z = sample[2];
  const double w = sample[3];
  // On the side of w > 0 an angle of a whole turn is one of 0.
  const double turns = turns_of(z, w);
  u[2] = 2 * half_circle * (turns > 0.75 ? 0 : turns);
}

double share_below(int channel, double value) {
  if (channel < 3) return disk_share_below(value);  // the marginal of the sphere in four dimensions is the disk's
  return value <= 0 ? 0 : 2 * disk_share_below(value) - 1;
}

}  // namespace

SpacePtr rotation_space() {
  Box domain = unit_box(3);
  domain.high[2] = half_circle;
  return std::make_unique<MappedSpace>(SpaceTraits{.name = "rotation",
                                                   .meaning = "a rotation as a unit quaternion x, y, z, w >= 0",
                                                   .aliases = "quaternion so3 orientation",
                                                   .channels = 4,
                                                   .dimensions = 3,
                                                   .distance = DistanceKind::axis,
                                                   .range = ValueRange{-1, 1},
                                                   .support = Support::unit_vectors,
                                                   .nvidia_name = "rotation",
                                                   .ea_name = "rotation_uniform"},
                                       BoxMap{.domain = domain,
                                              .to_sample = quaternion_from_box,
                                              .to_domain = box_from_quaternion,
                                              .contains = [](const float* sample) { return sample[3] > 0; },
                                              .density = [](const float*) { return 1 / (math::pi * math::pi); },
                                              .share_below = share_below});
}

}  // namespace noiseloom
