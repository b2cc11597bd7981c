// Grids of OpenVDB, as OpenImageIO gives them: one part a grid, in tiles of 8 x 8 x 8 voxels. The display window is the
// box of active voxels; the data window is that in whole tiles, and one voxel more.
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstdint>
#include <exception>

#include "image/library/openvdb.h"

namespace noiseloom {
namespace {

constexpr std::int64_t most_voxels = std::int64_t{1} << 27;

// One axis of the box, and of the tiles that cover it.
struct Axis {
  int first = 0;
  int size = 0;
  int tile = 0;
  int first_tile() const {  // whole tiles from 0 on, to either side
    const int over = first % tile;
    return first - (over < 0 ? over + tile : over);
  }
};

// Goes to the part of that name. Empty, or which names there are.
std::string find_grid(OIIO::ImageInput& input, const std::string& grid) {
  std::string names;
  for (int part = 0; input.seek_subimage(part, 0); ++part) {
    const std::string name = input.spec().get_string_attribute("openvdb:name");
    if (name == grid) return {};
    names += (names.empty() ? "\"" : ", \"") + name + "\"";
  }
  return "has no grid \"" + grid + "\"; it has " + (names.empty() ? "none" : names);
}

std::string read_tiles(OIIO::ImageInput& input, const std::array<Axis, 3>& axes, VolumeBox& volume) {
  const auto& [x_axis, y_axis, z_axis] = axes;
  std::vector<float> tile(static_cast<std::size_t>(x_axis.tile) * static_cast<std::size_t>(y_axis.tile) *
                          static_cast<std::size_t>(z_axis.tile));
  for (int z = z_axis.first_tile(); z < z_axis.first + z_axis.size; z += z_axis.tile)
    for (int y = y_axis.first_tile(); y < y_axis.first + y_axis.size; y += y_axis.tile)
      for (int x = x_axis.first_tile(); x < x_axis.first + x_axis.size; x += x_axis.tile) {
        if (!input.read_tile(x, y, z, OIIO::TypeDesc::FLOAT, tile.data()))
          return "its voxels cannot be read: " + input.geterror();
        const auto inside = [](const Axis& axis, int place) {
          return place >= axis.first && place < axis.first + axis.size;
        };
        std::size_t i = 0;
        for (int dz = z; dz < z + z_axis.tile; ++dz)
          for (int dy = y; dy < y + y_axis.tile; ++dy)
            for (int dx = x; dx < x + x_axis.tile; ++dx, ++i)
              if (inside(x_axis, dx) && inside(y_axis, dy) && inside(z_axis, dz))
                volume.values[(static_cast<std::size_t>(dz - z_axis.first) * static_cast<std::size_t>(y_axis.size) +
                               static_cast<std::size_t>(dy - y_axis.first)) *
                                  static_cast<std::size_t>(x_axis.size) +
                              static_cast<std::size_t>(dx - x_axis.first)] = tile[i];
      }
  return {};
}

}  // namespace

std::string read_openvdb(const std::string& path, const std::string& grid, VolumeBox& volume) try {
  const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create("openvdb");
  if (input == nullptr) {
    OIIO::geterror();
    return "is not read: the OpenImageIO that is installed knows no OpenVDB";
  }
  OIIO::ImageSpec spec;
  if (!input->open(path, spec)) {
    const std::string words = input->geterror();
    return "cannot be read as OpenVDB: " + (words.empty() ? "no reason was given" : words);
  }
  if (std::string error = find_grid(*input, grid); !error.empty()) return error;
  spec = input->spec();
  if (spec.nchannels != 1)
    return "the grid \"" + grid + "\" holds " + std::to_string(spec.nchannels) + " numbers a voxel: a density is one";
  const std::array<Axis, 3> axes = {Axis{spec.full_x, spec.full_width, spec.tile_width},
                                    Axis{spec.full_y, spec.full_height, spec.tile_height},
                                    Axis{spec.full_z, spec.full_depth, spec.tile_depth}};
  std::int64_t voxels = 1;
  for (const Axis& axis : axes) {
    if (axis.size < 1 || axis.tile < 1) return "the grid \"" + grid + "\" is empty";
    if (axis.size > most_voxels / voxels)
      return "the grid \"" + grid + "\" has an active box of " + std::to_string(spec.full_width) + " x " +
             std::to_string(spec.full_height) + " x " + std::to_string(spec.full_depth) +
             " voxels: accepted are 2^27 in all";
    voxels *= axis.size;
  }
  volume = {axes[0].size, axes[1].size, axes[2].size, std::vector<float>(static_cast<std::size_t>(voxels))};
  return read_tiles(*input, axes, volume);
} catch (const std::exception& error) {
  return std::string("cannot be read as OpenVDB: ") + error.what();
}

}  // namespace noiseloom
