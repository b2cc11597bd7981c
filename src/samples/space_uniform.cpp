// uniform: [0, 1); circle: the same with its ends joined, a circumference of 1 turn.
#include "samples/scalar_space.h"
#include "samples/spaces.h"

namespace noiseloom {
namespace {

constexpr ScalarMap unit_interval{.quantile = [](double below, double /*above*/) { return below; },
                                  .cumulative = [](double x) { return x; },
                                  .density = [](double x) { return x >= 0 && x < 1 ? 1.0 : 0.0; }};

}  // namespace

SpacePtr uniform_space() {
  return std::make_unique<ScalarSpace>(SpaceTraits{.name = "uniform",
                                                   .meaning = "one value in [0, 1)",
                                                   .aliases = "scalar real white vector1 vec1",
                                                   .distance = DistanceKind::absolute,
                                                   .range = ValueRange{0, 1},
                                                   .nvidia_name = "vec1",
                                                   .ea_name = "real_uniform"},
                                       unit_interval);
}

SpacePtr circle_space() {
  return std::make_unique<ScalarSpace>(SpaceTraits{.name = "circle",
                                                   .meaning = "one value in [0, 1) that wraps around",
                                                   .aliases = "angle toroidal",
                                                   .distance = DistanceKind::circle,
                                                   .range = ValueRange{0, 1},
                                                   .nvidia_name = "circle",
                                                   .ea_name = "circle_uniform"},
                                       unit_interval);
}

}  // namespace noiseloom
