// Reading volumes: grids of OpenVDB.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace noiseloom {

// The box of a grid that holds all of its active voxels. [z][y][x], y upward as OpenVDB has it; 0 where nothing is
// active.
struct VolumeBox {
  int width = 0;
  int height = 0;
  int depth = 0;
  std::vector<float> values;

  float at(int x, int y, int z) const {
    return values[(static_cast<std::size_t>(z) * static_cast<std::size_t>(height) + static_cast<std::size_t>(y)) *
                      static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
};

// The grid of that name, of one finite number of at least 0 a voxel, one of them above 0. Throws UserError where the
// file is no OpenVDB file, has no such grid, or one of something else or of more than 2^27 voxels.
VolumeBox read_volume(const std::string& path, const std::string& grid);

}  // namespace noiseloom
