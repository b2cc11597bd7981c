// disk: points with |p| <= 1.
#include "noiseloom/core/math.h"
#include "samples/disk_map.h"
#include "samples/mapped_space.h"
#include "samples/spaces.h"

namespace noiseloom {

SpacePtr disk_space() {
  return std::make_unique<MappedSpace>(
      SpaceTraits{.name = "disk",
                  .meaning = "a point of the unit disk",
                  .aliases = "disc lens aperture",
                  .channels = 2,
                  .dimensions = 2,
                  .distance = DistanceKind::euclidean,
                  .range = ValueRange{-1, 1},
                  .support = Support::unit_disk,
                  .nvidia_name = "disk",
                  .ea_name = "disk_uniform"},
      BoxMap{.domain = unit_box(2),
             .to_sample =
                 [](int /*channels*/, const double* u, double* sample) {
                   const DiskPoint p = disk_from_square(u[0], u[1]);
                   sample[0] = p.x;
                   sample[1] = p.y;
                 },
             .to_domain = [](int /*channels*/, const float* sample,
                             double* u) { square_from_disk(sample[0], sample[1], u); },
             .contains =
                 [](const float* sample) {
                   const double x = sample[0];
                   const double y = sample[1];
                   return x * x + y * y <= 1;
                 },
             .density = [](const float*) { return 1 / math::pi; },
             .share_below = [](int /*channel*/, double value) { return disk_share_below(value); }});
}

}  // namespace noiseloom
