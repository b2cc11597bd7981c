// hemisphere: unit vectors with z > 0; hemisphere-cosine: the same with density z / pi, the disk lifted straight up
// (Malley's method); axis: those of the hemisphere, each of which stands for its opposite too.
#include <algorithm>
#include <cmath>

#include "noiseloom/core/math.h"
#include "samples/disk_map.h"
#include "samples/mapped_space.h"
#include "samples/spaces.h"

namespace noiseloom {
namespace {

constexpr int z_channel = 2;

bool is_above(const float* sample) { return sample[2] > 0; }

BoxMap hemisphere_map() {
  return {.domain = unit_box(2),
          .to_sample = [](int /*channels*/, const double* u,
                          double* sample) { hemisphere_from_square(u[0], u[1], sample); },
          .to_domain = [](int /*channels*/, const float* sample, double* u) { square_from_hemisphere(sample, u); },
          .contains = is_above,
          .density = [](const float*) { return 0.5 / math::pi; },
          .share_below =
              [](int channel, double value) {
                return channel == z_channel ? std::clamp(value, 0.0, 1.0) : sphere_share_below(value);
              }};
}

}  // namespace

SpacePtr hemisphere_space() {
  return std::make_unique<MappedSpace>(SpaceTraits{.name = "hemisphere",
                                                   .meaning = "a unit vector with z >= 0, uniform",
                                                   .aliases = "hemisphere-uniform",
                                                   .channels = 3,
                                                   .dimensions = 2,
                                                   .distance = DistanceKind::angle,
                                                   .range = ValueRange{-1, 1},
                                                   .support = Support::upper_unit_vectors,
                                                   .nvidia_name = "unitvec3_hemisphere",
                                                   .ea_name = "sphere_uniformhemisphere"},
                                       hemisphere_map());
}

SpacePtr axis_space() {
  return std::make_unique<MappedSpace>(SpaceTraits{.name = "axis",
                                                   .meaning = "a unit vector that is the same as its opposite, z >= 0",
                                                   .aliases = "line undirected fibre fiber",
                                                   .channels = 3,
                                                   .dimensions = 2,
                                                   .distance = DistanceKind::axis,
                                                   .range = ValueRange{-1, 1},
                                                   .support = Support::unit_vectors,
                                                   .nvidia_name = "axis",
                                                   .ea_name = "axis_uniform"},
                                       hemisphere_map());
}

SpacePtr hemisphere_cosine_space() {
  return std::make_unique<MappedSpace>(
      SpaceTraits{.name = "hemisphere-cosine",
                  .meaning = "a unit vector with z >= 0, density cos / pi",
                  .aliases = "cosine cosine-hemisphere lambert",
                  .channels = 3,
                  .dimensions = 2,
                  .distance = DistanceKind::angle,
                  .range = ValueRange{-1, 1},
                  .support = Support::upper_unit_vectors,
                  .has_constant_density = false,
                  .nvidia_name = "unitvec3_cosine",
                  .ea_name = "sphere_coshemi"},
      BoxMap{.domain = unit_box(2),
             .to_sample =
                 [](int /*channels*/, const double* u, double* sample) {
                   const DiskPoint p = disk_from_square(u[0], u[1]);
                   sample[0] = p.x;
                   sample[1] = p.y;
                   sample[2] = std::sqrt(one_minus_square(p.radius));
                 },
             .to_domain = [](int /*channels*/, const float* sample,
                             double* u) { square_from_disk(sample[0], sample[1], u); },
             .contains = is_above,
             .density = [](const float* sample) { return std::max(0.0, static_cast<double>(sample[2])) / math::pi; },
             .share_below =
                 [](int channel, double value) {
                   const double z = std::max(value, 0.0);
                   return channel == z_channel ? z * z : disk_share_below(value);
                 }});
}

}  // namespace noiseloom
