// The built-in sample spaces, one function each; the table that lists them stands in spaces.cpp.
#pragma once

#include <memory>
#include <vector>

#include "noiseloom/samples/space.h"

namespace noiseloom {

using SpacePtr = std::unique_ptr<const SampleSpace>;

// A space with parameters.
struct SpaceFamily {
  SpaceTraits traits;
  // The space of these values, in the order of traits.parameters and within their bounds.
  SpacePtr (*make)(const SpaceTraits& traits, const std::vector<double>& values);
};

SpacePtr uniform_space();
SpacePtr circle_space();
SpacePtr tent_space();
SpacePtr gauss_space();
SpacePtr cube_space(int channels);  // 2 to 8
SpacePtr disk_space();
SpacePtr sphere_space();
SpacePtr hemisphere_space();
SpacePtr hemisphere_cosine_space();
SpaceFamily cone_family();
SpaceFamily ggx_family();
SpacePtr axis_space();
SpacePtr rotation_space();
SpacePtr exponential_space();
SpacePtr gauss2_space();
SpacePtr triangle_space();
SpaceFamily ring_family();
SpacePtr hexagon_space();
SpaceFamily star_family();
SpaceFamily sobol_family();

}  // namespace noiseloom
