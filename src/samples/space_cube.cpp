// vector2 to vector8: points of the unit cube [0, 1)^C.
#include <algorithm>
#include <string>

#include "samples/mapped_space.h"
#include "samples/spaces.h"

namespace noiseloom {
namespace {

// By the number of channels, from 2.
struct Words {
  const char* meaning;
  const char* aliases;
};
constexpr Words words[] = {{"a point of the unit square", "vec2 uniform2 square vector"},
                           {"a point of the unit cube", "vec3 uniform3 cube"},
                           {"four values in [0, 1)", "vec4 uniform4"},
                           {"five values in [0, 1)", "vec5"},
                           {"six values in [0, 1)", "vec6"},
                           {"seven values in [0, 1)", "vec7"},
                           {"eight values in [0, 1)", "vec8"}};

}  // namespace

SpacePtr cube_space(int channels) {
  const std::string number = std::to_string(channels);
  return std::make_unique<MappedSpace>(
      SpaceTraits{.name = "vector" + number,
                  .meaning = words[channels - 2].meaning,
                  .aliases = words[channels - 2].aliases,
                  .channels = channels,
                  .dimensions = channels,
                  .distance = DistanceKind::euclidean,
                  .range = ValueRange{0, 1},
                  .nvidia_name = "vec" + number,
                  .ea_name = "vector" + number + "_uniform"},
      BoxMap{.domain = unit_box(channels),
             .to_sample = [](int count, const double* u, double* sample) { std::copy(u, u + count, sample); },
             .to_domain = [](int count, const float* sample, double* u) { std::copy(sample, sample + count, u); },
             .contains = [](const float*) { return true; },
             .density = [](const float*) { return 1.0; },
             .share_below = [](int /*channel*/, double value) { return value; }});
}

}  // namespace noiseloom
