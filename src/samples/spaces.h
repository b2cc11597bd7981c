// The built-in sample spaces, one function each; the table that lists them stands in spaces.cpp.
#pragma once

#include <memory>

#include "noiseloom/samples/space.h"

namespace noiseloom {

using SpacePtr = std::unique_ptr<const SampleSpace>;

SpacePtr uniform_space();
SpacePtr circle_space();
SpacePtr tent_space();
SpacePtr gauss_space();
SpacePtr cube_space(int channels);  // 2 to 8
SpacePtr disk_space();
SpacePtr sphere_space();
SpacePtr hemisphere_space();
SpacePtr hemisphere_cosine_space();

}  // namespace noiseloom
