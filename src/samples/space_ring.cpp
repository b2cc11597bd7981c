// ring: points of the unit disk outside a smaller circle, uniform: the lens of a mirror telescope. The box is the ring
// cut open: along its first side the angle, along its second one the square of the radius; it is as much longer than
// wide as the ring is.
#include <cmath>

#include "noiseloom/core/math.h"
#include "samples/disk_map.h"
#include "samples/mapped_space.h"
#include "samples/spaces.h"

namespace noiseloom {
namespace {

double square_of_radius(const float* sample) {
  const double x = sample[0];
  const double y = sample[1];
  return x * x + y * y;
}

SpacePtr make_ring(const SpaceTraits& traits, const std::vector<double>& values) {
  const double hole = values[0] * values[0];
  const double length = math::pi * (1 + values[0]) / (1 - values[0]);
  Box domain = unit_box(2);
  domain.high[0] = length;
  return std::make_unique<MappedSpace>(traits,
                                       BoxMap{.domain = domain,
                                              .to_sample =
                                                  [hole, length](int /*channels*/, const double* u, double* sample) {
                                                    const double radius = std::sqrt(hole + (1 - hole) * u[1]);
                                                    const double turns = u[0] / length;
                                                    sample[0] = radius * math::cos_2pi(turns);
                                                    sample[1] = radius * math::sin_2pi(turns);
                                                  },
                                              .to_domain =
                                                  [hole, length](int /*channels*/, const float* sample, double* u) {
                                                    const double square = square_of_radius(sample);
                                                    u[0] = length * turns_of(sample[0], sample[1]);
                                                    u[1] = (square - hole) / (1 - hole);
                                                  },
                                              .contains =
                                                  [hole](const float* sample) {
                                                    const double square = square_of_radius(sample);
                                                    return square >= hole && square <= 1;
                                                  },
                                              .density = [hole](const float*) { return 1 / (math::pi * (1 - hole)); }});
}

}  // namespace

SpaceFamily ring_family() {
  return {.traits = {.name = "ring",
                     .meaning = "a point of the unit disk outside a smaller circle",
                     .aliases = "annulus donut catadioptric",
                     .channels = 2,
                     .dimensions = 2,
                     .distance = DistanceKind::euclidean,
                     .range = ValueRange{-1, 1},
                     .support = Support::unit_disk,
                     .parameters = {{.name = "inner",
                                     .meaning = "Radius of the circle that is left out; that of the disk is 1.",
                                     .initial = 0.5,
                                     .least = 0,
                                     .most = 0.999}},
                     .nvidia_name = "ring",
                     .ea_name = "ring_uniform"},
          .make = make_ring};
}

}  // namespace noiseloom
