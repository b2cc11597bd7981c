#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "noiseloom/image/volume.h"

namespace noiseloom {

// What ImageLibrary::read_volume() does.
std::string read_openvdb(const std::string& path, const std::string& grid, VolumeBox& volume);

}  // namespace noiseloom
