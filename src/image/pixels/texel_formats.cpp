#include "image/pixels/texel_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <string_view>

namespace noiseloom {
namespace {

constexpr const char* accepted = "accepted: R, RG, RGB or RGBA of 8 or 16 bits (unorm), half or float";

// Formats of blocks: several pixels share their bits, which changes noise.
struct Blocks {
  std::uint32_t first;
  std::uint32_t last;
  const char* name;
};
constexpr Blocks vulkan_blocks[] = {
    {131, 134, "BC1"},
    {135, 136, "BC2"},
    {137, 138, "BC3"},
    {139, 140, "BC4"},
    {141, 142, "BC5"},
    {143, 144, "BC6H"},
    {145, 146, "BC7"},
    {147, 152, "ETC2"},
    {153, 156, "EAC"},
    {157, 184, "ASTC"},
    {1000054000, 1000054007, "PVRTC"},
    {1000066000, 1000066013, "ASTC"},
};
constexpr Blocks dxgi_blocks[] = {
    {70, 72, "BC1"}, {73, 75, "BC2"},  {76, 78, "BC3"}, {79, 81, "BC4"},
    {82, 84, "BC5"}, {94, 96, "BC6H"}, {97, 99, "BC7"},
};

template <std::size_t N>
std::string why_not(const Blocks (&blocks)[N], std::uint32_t format, const std::string& name) {
  const auto* const found = std::find_if(std::begin(blocks), std::end(blocks),
                                         [&](const Blocks& b) { return b.first <= format && format <= b.last; });
  return found != std::end(blocks) ? fmt::format("{} blocks ({} {}), which are lossy: they change noise; {}",
                                                 found->name, name, format, accepted)
                                   : fmt::format("{} {} is not read; {}", name, format, accepted);
}

}  // namespace

const std::vector<TexelFormat>& texel_formats() {
  using enum PixelType;
  static const std::vector<TexelFormat> rows = {
      {uint8, "R", 9, 61},           {uint8, "RG", 16, 49},        {uint8, "RGB", 23, 0},
      {uint8, "RGBA", 37, 28},       {uint16, "R", 70, 56},        {uint16, "RG", 77, 35},
      {uint16, "RGB", 84, 0},        {uint16, "RGBA", 91, 11},     {float16, "R", 76, 54},
      {float16, "RG", 83, 34},       {float16, "RGB", 90, 0},      {float16, "RGBA", 97, 10},
      {float32, "R", 100, 41},       {float32, "RG", 103, 16},     {float32, "RGB", 106, 6},
      {float32, "RGBA", 109, 2},     {uint8, "BGRA", 44, 87},      {uint8, "BGRX", 0, 88},
      {uint8, "BGR", 30, 0},         {uint8, "A", 1000470001, 65}, {uint8, "R", 15, 0, true},
      {uint8, "RG", 22, 0, true},    {uint8, "RGB", 29, 0, true},  {uint8, "RGBA", 43, 29, true},
      {uint8, "BGRA", 50, 91, true}, {uint8, "BGRX", 0, 93, true},
  };
  return rows;
}

const TexelFormat* texel_format(PixelType type, int channels) {
  constexpr std::string_view order = "RGBA";
  for (const TexelFormat& format : texel_formats())
    if (format.type == type && !format.is_srgb && format.order == order.substr(0, static_cast<std::size_t>(channels)))
      return &format;
  return nullptr;
}

std::string why_vulkan_format_not_read(std::uint32_t format) {
  if (format == 0) return "Basis Universal or another format without a VkFormat, which is lossy: it changes noise";
  return why_not(vulkan_blocks, format, "VkFormat");
}
std::string why_dxgi_format_not_read(std::uint32_t format) { return why_not(dxgi_blocks, format, "DXGI format"); }

}  // namespace noiseloom
