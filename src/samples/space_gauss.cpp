// gauss: a number of the normal distribution, mean 0 and variance 1; gauss2: two of them, the disk drawn out along its
// radius [BoxMuller58].
#include <cmath>

#include "noiseloom/core/math.h"
#include "samples/disk_map.h"
#include "samples/mapped_space.h"
#include "samples/scalar_space.h"
#include "samples/spaces.h"

namespace noiseloom {
namespace {

constexpr ScalarMap normal{.quantile =
                               [](double below, double above) {
                                 return below <= above ? math::inverse_normal_cdf(below)
                                                       : -math::inverse_normal_cdf(above);
                               },
                           .cumulative = [](double x) { return 0.5 * (1 + math::erf(x * std::sqrt(0.5))); },
                           .density = [](double x) { return math::exp(-0.5 * x * x) / std::sqrt(math::two_pi); }};

// The share of the plane outside the circle through a point.
double share_outside(const float* sample) {
  const double x = sample[0];
  const double y = sample[1];
  return math::exp(-0.5 * (x * x + y * y));
}

}  // namespace

SpacePtr gauss_space() {
  return std::make_unique<ScalarSpace>(SpaceTraits{.name = "gauss",
                                                   .meaning = "one value, normal density",
                                                   .aliases = "gaussian normal",
                                                   .distance = DistanceKind::absolute,
                                                   .range = std::nullopt,
                                                   .support = Support::line,
                                                   .has_constant_density = false,
                                                   .nvidia_name = "vec1",
                                                   .ea_name = "real_gauss"},
                                       normal);
}

SpacePtr gauss2_space() {
  return std::make_unique<MappedSpace>(
      SpaceTraits{.name = "gauss2",
                  .meaning = "a point of the plane, normal density in x and in y",
                  .aliases = "gaussian2 gauss2d gaussian-filter normal2",
                  .channels = 2,
                  .dimensions = 2,
                  .distance = DistanceKind::euclidean,
                  .range = std::nullopt,
                  .support = Support::line,
                  .has_constant_density = false,
                  .nvidia_name = "vec2_gauss",
                  .ea_name = "vector2_gauss"},
      BoxMap{.domain = unit_box(2),
             .to_sample =
                 [](int /*channels*/, const double* u, double* sample) {
                   const DiskPoint p = disk_from_square(u[0], u[1]);
                   const double outside = one_minus_square(p.radius);
                   const double scale = p.radius > 0 ? std::sqrt(-2 * math::log(outside)) / p.radius : 0;
                   sample[0] = p.x * scale;
                   sample[1] = p.y * scale;
                 },
             .to_domain =
                 [](int /*channels*/, const float* sample, double* u) {
                   const double x = sample[0];
                   const double y = sample[1];
                   const double length = std::sqrt(x * x + y * y);
                   const double scale = length > 0 ? std::sqrt(1 - share_outside(sample)) / length : 0;
                   square_from_disk(x * scale, y * scale, u);
                 },
             .contains = [](const float* sample) { return share_outside(sample) > 0; },
             .density = [](const float* sample) { return share_outside(sample) / math::two_pi; },
             .share_below = [](int /*channel*/, double value) { return normal.cumulative(value); }});
}

}  // namespace noiseloom
