// The formats of texels that KTX2 and DDS files are written in and read from, under both their names: Vulkan's VkFormat
// and Direct3D's DXGI_FORMAT. One table, so that neither container knows a format that the other side of it does not.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "noiseloom/image/image_io.h"

namespace noiseloom {

struct TexelFormat {
  PixelType type = PixelType::uint8;
  const char* order = "R";  // the channels as they lie in the file; X holds nothing
  std::uint32_t vulkan = 0;
  std::uint32_t dxgi = 0;  // 0: it has no such format
  bool is_srgb = false;    // a sampler bends the values; read, never written
};

const std::vector<TexelFormat>& texel_formats();

// What files are written with: channels in the order R, G, B, A; nullptr where there is none.
const TexelFormat* texel_format(PixelType type, int channels);

// Why a file of that format is not read: "BC7 blocks" or "VkFormat 1000: ...".
std::string why_vulkan_format_not_read(std::uint32_t format);
std::string why_dxgi_format_not_read(std::uint32_t format);

}  // namespace noiseloom
