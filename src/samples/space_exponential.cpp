// exponential: a number x >= 0 with density exp(-x): the free flight through a medium, in mean free paths.
#include "noiseloom/core/math.h"
#include "samples/scalar_space.h"
#include "samples/spaces.h"

namespace noiseloom {
namespace {

// The far end of the last stratum is infinite; its samples are not, as no jitter is 1.
constexpr ScalarMap exponential{.quantile = [](double /*below*/, double above) { return -math::log(above); },
                                .cumulative = [](double x) { return x > 0 ? 1 - math::exp(-x) : 0; },
                                .density = [](double x) { return x >= 0 ? math::exp(-x) : 0; }};

}  // namespace

SpacePtr exponential_space() {
  return std::make_unique<ScalarSpace>(SpaceTraits{.name = "exponential",
                                                   .meaning = "one value >= 0, density exp(-x): free flight",
                                                   .aliases = "free-flight freeflight exp transmittance",
                                                   .distance = DistanceKind::absolute,
                                                   .range = std::nullopt,
                                                   .support = Support::half_line,
                                                   .has_constant_density = false,
                                                   .nvidia_name = "vec1",
                                                   .ea_name = "real_exponential"},
                                       exponential);
}

}  // namespace noiseloom
