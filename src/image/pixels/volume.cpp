#include "noiseloom/image/volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "image/pixels/image_library.h"
#include "noiseloom/core/apart.h"
#include "noiseloom/core/error.h"

namespace noiseloom {

namespace {

using BoxSizes = std::array<std::int32_t, 3>;

VolumeBox volume_of(const std::string& path, const std::string& grid) {
  const ImageLibrary& library = image_library();  // here, where it can be said that it is not there
  // It crashes on some damaged files.
  const ApartResult result = run_apart([&] {
    VolumeBox volume;
    const std::string error = library.read_volume(path, grid, volume);
    if (!error.empty()) return 'e' + error;
    const BoxSizes sizes = {volume.width, volume.height, volume.depth};
    std::string bytes = "v";
    bytes.append(reinterpret_cast<const char*>(sizes.data()), sizeof(sizes));
    bytes.append(reinterpret_cast<const char*>(volume.values.data()), volume.values.size() * sizeof(float));
    return bytes;
  });
  if (!result.is_whole)
    throw UserError(path,
                    result.signal != 0
                        ? fmt::format("is damaged, or no OpenVDB file: reading it ended with signal {}", result.signal)
                        : "is damaged, or there is not enough memory to read it");
  std::string_view bytes(result.bytes);
  if (bytes.front() == 'e') throw UserError(path, std::string(bytes.substr(1)));
  bytes.remove_prefix(1);
  BoxSizes sizes{};
  std::memcpy(sizes.data(), bytes.data(), sizeof(sizes));
  bytes.remove_prefix(sizeof(sizes));
  VolumeBox volume{sizes[0], sizes[1], sizes[2], std::vector<float>(bytes.size() / sizeof(float))};
  std::memcpy(volume.values.data(), bytes.data(), bytes.size());
  return volume;
}

}  // namespace

VolumeBox read_volume(const std::string& path, const std::string& grid) {
  const VolumeBox volume = volume_of(path, grid);
  for (std::size_t i = 0; i < volume.values.size(); ++i) {
    const float value = volume.values[i];
    if (value >= 0 && std::isfinite(value)) continue;
    const auto width = static_cast<std::size_t>(volume.width);
    const auto height = static_cast<std::size_t>(volume.height);
    throw UserError(path, fmt::format("the grid \"{}\" holds {} at voxel {}, {}, {} of its active box: a density is "
                                      "finite and at least 0",
                                      grid, value, i % width, i / width % height, i / width / height));
  }
  if (std::all_of(volume.values.begin(), volume.values.end(), [](float value) { return value == 0; }))
    throw UserError(path, fmt::format("the grid \"{}\" is 0 everywhere", grid));
  return volume;
}

}  // namespace noiseloom
