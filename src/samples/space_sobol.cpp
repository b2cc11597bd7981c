// sobol-owen: points of the unit cube that are nets. Slice z of n pixels holds points z n to (z + 1) n - 1 of one
// scrambled Sobol sequence, so that each slice is a net and so is each aligned run of 2^k slices, the whole among them.
// Swaps within slices keep that.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "noiseloom/core/error.h"
#include "noiseloom/samples/sobol.h"
#include "samples/mapped_space.h"
#include "samples/spaces.h"

namespace noiseloom {
namespace {

class SobolSpace : public MappedSpace {
 public:
  using MappedSpace::MappedSpace;

  // Ids number the strata of the cube. A net with t = 0 has one point in each; else several points of a stratum, or of
  // none, are numbered on in their order.
  void list_of_slice(std::int64_t n, SliceIndex slice, std::uint64_t seed, const JitterOf& /*jitter*/,
                     float* samples) const override {
    const auto channels = static_cast<std::size_t>(traits().channels);
    const std::int64_t first = n * slice.value();
    NOISELOOM_CHECK(first + n <= std::int64_t{1} << sobol_bits);
    std::vector<float> points(static_cast<std::size_t>(n) * channels);
    std::vector<std::pair<std::int64_t, std::size_t>> order;  // stratum, point
    order.reserve(static_cast<std::size_t>(n));
    for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
      const auto codes = sobol_point(static_cast<std::uint32_t>(first) + static_cast<std::uint32_t>(i));
      for (std::size_t c = 0; c < channels; ++c) {
        points[i * channels + c] = sobol_value(owen_scrambled(codes[c], static_cast<int>(c), seed));
      }
      order.emplace_back(invert(n, &points[i * channels]), i);
    }
    std::sort(order.begin(), order.end());
    for (const auto& [stratum, i] : order) {
      samples = std::copy_n(&points[i * channels], channels, samples);
    }
  }
};

SpacePtr make_sobol(const SpaceTraits& family, const std::vector<double>& values) {
  SpaceTraits traits = family;
  traits.channels = traits.dimensions = static_cast<int>(std::lround(values[0]));
  traits.distance = traits.channels == 1 ? DistanceKind::absolute : DistanceKind::euclidean;
  const std::string number = std::to_string(traits.channels);
  traits.nvidia_name = "vec" + number + "_sobol";
  traits.ea_name = (traits.channels == 1 ? "real" : "vector" + number) + "_sobol";
  return std::make_unique<SobolSpace>(
      traits,
      BoxMap{.domain = unit_box(traits.channels),
             .to_sample = [](int count, const double* u, double* sample) { std::copy(u, u + count, sample); },
             .to_domain = [](int count, const float* sample, double* u) { std::copy(sample, sample + count, u); },
             .contains = [](const float*) { return true; },
             .density = [](const float*) { return 1.0; },
             .share_below = [](int /*channel*/, double value) { return value; }});
}

}  // namespace

SpaceFamily sobol_family() {
  return {.traits = {.name = "sobol-owen",
                     .meaning = "a point of the unit square; the points of a slice, and of all slices, are nets",
                     .aliases = "sobol owen net nets low-discrepancy lds",
                     .channels = 2,
                     .dimensions = 2,
                     .distance = DistanceKind::euclidean,
                     .range = ValueRange{0, 1},
                     .is_net = true,
                     .parameters = {{.name = "channels",
                                     .meaning = "Numbers in a sample: 1 and 2 make (0, m, s)-nets in base 2, 3 and 4 "
                                                "make the nets that Sobol's sequence has.",
                                     .initial = 2,
                                     .least = 1,
                                     .most = max_sobol_dimensions,
                                     .whole = true,
                                     .unit = ""}},
                     .nvidia_name = "vec2_sobol",
                     .ea_name = "vector2_sobol"},
          .make = make_sobol};
}

}  // namespace noiseloom
