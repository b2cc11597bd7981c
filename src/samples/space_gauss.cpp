// gauss: a number of the normal distribution, mean 0 and variance 1.
#include <cmath>

#include "noiseloom/core/math.h"
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

}  // namespace noiseloom
