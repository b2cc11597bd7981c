// tent: a number in [0, 1) with density 4 min(x, 1 - x), as dithering with triangular noise takes it.
#include <algorithm>
#include <cmath>

#include "samples/scalar_space.h"
#include "samples/spaces.h"

namespace noiseloom {
namespace {

constexpr ScalarMap tent{
    .quantile = [](double below,
                   double above) { return below <= above ? std::sqrt(0.5 * below) : 1 - std::sqrt(0.5 * above); },
    .cumulative = [](double x) { return x < 0.5 ? 2 * x * x : 1 - 2 * (1 - x) * (1 - x); },
    .density = [](double x) { return x < 0 || x >= 1 ? 0.0 : 4 * std::min(x, 1 - x); }};

}  // namespace

SpacePtr tent_space() {
  return std::make_unique<ScalarSpace>(SpaceTraits{.name = "tent",
                                                   .meaning = "one value, triangular density",
                                                   .aliases = "triangle triangular",
                                                   .distance = DistanceKind::absolute,
                                                   .range = ValueRange{0, 1},
                                                   .has_constant_density = false,
                                                   .nvidia_name = "vec1",
                                                   .ea_name = "real_tent"},
                                       tent);
}

}  // namespace noiseloom
