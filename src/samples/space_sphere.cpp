// sphere: unit vectors. The box [0, 2) x [0, 1) is two of the squares of a hemisphere that share an edge, the second
// mirrored and turned down, so the map is continuous across the shared part of the equator. z is never 0, so that its
// sign tells the halves apart.
#include <cmath>

#include "noiseloom/core/math.h"
#include "samples/disk_map.h"
#include "samples/mapped_space.h"
#include "samples/spaces.h"

namespace noiseloom {
namespace {

Box two_squares() {
  Box box = unit_box(2);
  box.high[0] = 2;
  return box;
}

void to_sample(int /*channels*/, const double* u, double* sample) {
  const bool down = u[0] >= 1;
  hemisphere_from_square(down ? 2 - u[0] : u[0], u[1], sample);
  if (down) sample[2] = -sample[2];
}

void to_domain(int /*channels*/, const float* sample, double* u) {
  square_from_hemisphere(sample, u);
  if (std::signbit(sample[2])) u[0] = 2 - u[0];
}

}  // namespace

SpacePtr sphere_space() {
  return std::make_unique<MappedSpace>(
      SpaceTraits{.name = "sphere",
                  .meaning = "a unit vector, any direction",
                  .aliases = "direction unit-vector unitvec",
                  .channels = 3,
                  .dimensions = 2,
                  .distance = DistanceKind::angle,
                  .range = ValueRange{-1, 1},
                  .support = Support::unit_vectors,
                  .nvidia_name = "unitvec3",
                  .ea_name = "sphere_uniform"},
      BoxMap{.domain = two_squares(),
             .to_sample = to_sample,
             .to_domain = to_domain,
             .contains = [](const float* sample) { return sample[2] != 0; },
             .density = [](const float*) { return 0.25 / math::pi; },
             .share_below = [](int /*channel*/, double value) { return sphere_share_below(value); }});
}

}  // namespace noiseloom
