// tent: a number in [0, 1) with density 4 min(x, 1 - x), as dithering with triangular noise takes it; triangle: an
// offset in x and in y, each with density 1 - |x|, as a reconstruction filter of radius 1 takes it.
#include <algorithm>
#include <cmath>

#include "samples/mapped_space.h"
#include "samples/scalar_space.h"
#include "samples/spaces.h"

namespace noiseloom {
namespace {

constexpr ScalarMap tent{
    .quantile = [](double below,
                   double above) { return below <= above ? std::sqrt(0.5 * below) : 1 - std::sqrt(0.5 * above); },
    .cumulative = [](double x) { return x < 0.5 ? 2 * x * x : 1 - 2 * (1 - x) * (1 - x); },
    .density = [](double x) { return x < 0 || x >= 1 ? 0.0 : 4 * std::min(x, 1 - x); }};

// The share of the offsets in one direction below x.
double signed_tent_below(double x) { return tent.cumulative(0.5 * (x + 1)); }

}  // namespace

SpacePtr tent_space() {
  return std::make_unique<ScalarSpace>(SpaceTraits{.name = "tent",
                                                   .meaning = "one value, triangular density",
                                                   .aliases = "triangular",
                                                   .distance = DistanceKind::absolute,
                                                   .range = ValueRange{0, 1},
                                                   .has_constant_density = false,
                                                   .nvidia_name = "vec1",
                                                   .ea_name = "real_tent"},
                                       tent);
}

SpacePtr triangle_space() {
  return std::make_unique<MappedSpace>(
      SpaceTraits{.name = "triangle",
                  .meaning = "an offset within 1 in x and in y, density (1 - |x|)(1 - |y|)",
                  .aliases = "tent2 bilinear triangle-filter triangle2",
                  .channels = 2,
                  .dimensions = 2,
                  .distance = DistanceKind::euclidean,
                  .range = ValueRange{-1, 1},
                  .support = Support::signed_unit_interval,
                  .has_constant_density = false,
                  .nvidia_name = "vec2_triangle",
                  .ea_name = "vector2_tent"},
      BoxMap{.domain = unit_box(2),
             .to_sample =
                 [](int channels, const double* u, double* sample) {
                   for (int c = 0; c < channels; ++c) sample[c] = 2 * tent.quantile(u[c], 1 - u[c]) - 1;
                 },
             .to_domain =
                 [](int channels, const float* sample, double* u) {
                   for (int c = 0; c < channels; ++c) u[c] = signed_tent_below(sample[c]);
                 },
             .contains = [](const float* sample) { return std::fabs(sample[0]) < 1 && std::fabs(sample[1]) < 1; },
             .density =
                 [](const float* sample) {
                   const auto factor = [](float x) { return std::max(0.0, 1 - std::fabs(static_cast<double>(x))); };
                   return factor(sample[0]) * factor(sample[1]);
                 },
             .share_below = [](int /*channel*/, double value) { return signed_tent_below(value); }});
}

}  // namespace noiseloom
