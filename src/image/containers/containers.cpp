#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "image/containers/container_writers.h"
#include "noiseloom/core/error.h"
#include "noiseloom/image/container.h"

namespace noiseloom {
namespace {

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// "png: 8, 16; exr: 32f": what `list` finds in every row, rows with nothing to choose left out.
template <class List>
std::string by_container(List list) {
  std::string text;
  for (const Container& container : containers()) {
    const std::vector<std::string> words = list(container);
    if (!words.empty())
      text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", container.name, fmt::join(words, ", "));
  }
  return text;
}

}  // namespace

const std::vector<Container>& containers() {
  using enum PixelType;
  using enum ExportLayout;
  constexpr auto pixels = ContainerContent::pixels;
  constexpr auto places = ContainerContent::places;
  constexpr auto by_type = StoredNumbers::by_type;
  using Layouts = std::vector<ExportLayout>;
  static const Layouts flat = {slices, strip, row, atlas};
  static const Layouts flat_or_parts = {slices, strip, row, atlas, parts};
  static const Layouts texture = {array, volume, slices};
  static const Layouts texture_or_strip = {array, volume, slices, strip};
  static const Layouts source = {array, function};
  static const std::vector<int> grey_or_colour = {1, 3, 4};
  static const std::vector<int> any = {1, 2, 3, 4};
  // clang-format off
  static const std::vector<Container> rows = {
      {"png", pixels, {".png"}, {uint8, uint16}, flat, by_type, 4, true, png_pixel, grey_or_colour, make_png_writer},
      {"exr", pixels, {".exr"}, {float32, float16}, flat_or_parts, by_type, 0, true, exr_pixel, any, make_exr_writer},
      {"tiff", pixels, {".tif", ".tiff"}, {uint8, uint16, float32}, flat, by_type, 0, true, tiff_pixel, grey_or_colour, make_tiff_writer},
      {"hdr", pixels, {".hdr"}, {float32}, flat, StoredNumbers::unit, 3, false, rgb_pixel, {3}, make_hdr_writer},
      {"ktx2", pixels, {".ktx2"}, {uint8, uint16, float16, float32}, texture, by_type, 4, true, texture_pixel, any, make_ktx2_writer},
      {"dds", pixels, {".dds"}, {uint8, uint16, float16, float32}, texture_or_strip, by_type, 4, true, texture_pixel, any, make_dds_writer},
      {"npy", pixels, {".npy"}, {float32}, {array}, StoredNumbers::the_values, 0, false, plain_pixel, any, make_npy_writer},
      {"raw", pixels, {".raw", ".bin"}, {float32, uint8, uint16, float16}, {array}, by_type, 0, false, plain_pixel, any, make_raw_writer},
      {"header", pixels, {".h", ".hpp"}, {uint8, uint16, uint32, float32}, {array}, by_type, 0, false, plain_pixel, any, make_header_writer},
      {"hlsl", pixels, {".hlsl"}, {uint8, uint16, uint32, float32}, source, by_type, 4, false, plain_pixel, {}, make_hlsl_writer},
      {"glsl", pixels, {".glsl"}, {uint8, uint16, uint32, float32}, source, by_type, 4, false, plain_pixel, {}, make_glsl_writer},
      {"wgsl", pixels, {".wgsl"}, {uint8, uint16, uint32, float32}, source, by_type, 4, false, plain_pixel, {}, make_wgsl_writer},
      {"godot", pixels, {".godot.png"}, {uint8}, {atlas}, by_type, 4, false, png_pixel, {1, 3, 4}, make_godot_writer},
      {"mpv", pixels, {".hook"}, {uint8, uint16, float16, float32}, {array}, by_type, 4, false, texture_pixel, any, make_mpv_writer},
      {"remix", pixels, {".remix.h"}, {uint8}, {array}, by_type, 1, false, plain_pixel, {}, make_remix_writer},
      {"pbrt", pixels, {".pbrt.cpp"}, {uint16}, {array}, by_type, 1, false, plain_pixel, {}, make_pbrt_writer},
      {"imagemagick", pixels, {".xml"}, {uint32}, {array}, by_type, 1, false, plain_pixel, {}, make_imagemagick_writer},
      {"ghostscript", pixels, {".ps"}, {uint32}, {slices}, by_type, 1, false, plain_pixel, {}, make_ghostscript_writer},
      {"gimp", pixels, {".scm"}, {uint32}, {slices}, by_type, 1, false, plain_pixel, {}, make_gimp_writer},
      {"csv", places, {".csv"}, {}, {table}, by_type, 0, false, nullptr, {}, make_csv_points_writer},
      {"npy", places, {".npy"}, {}, {table}, by_type, 0, false, nullptr, {}, make_npy_points_writer},
  };
  // clang-format on
  return rows;
}

const Container* find_container(const std::string& name, ContainerContent content) {
  for (const Container& container : containers())
    if (container.name == name && container.content == content) return &container;
  return nullptr;
}

const Container* container_of_file(const std::string& path) {
  const std::string ending = lower_case(std::filesystem::path(path).extension().string());
  for (const Container& container : containers())
    if (std::find(container.endings.begin(), container.endings.end(), ending) != container.endings.end())
      return &container;
  return nullptr;
}

bool holds_channels(const Container& container, int channels, bool with_density, std::string& why) {
  if (container.most_channels > 0 && channels > container.most_channels) {
    why = fmt::format("{} holds {} channels, the samples have {}", container.name, container.most_channels, channels);
    return false;
  }
  if (with_density && !container.has_alpha) {
    why = fmt::format("--pdf: {} has no alpha channel", container.name);
    return false;
  }
  if (with_density && channels > 3) {
    why = fmt::format("--pdf needs the fourth channel, but the samples have {} of their own", channels);
    return false;
  }
  return true;
}

std::string to_string(ExportLayout layout) {
  switch (layout) {
    case ExportLayout::slices:
      return "slices";
    case ExportLayout::strip:
      return "strip";
    case ExportLayout::row:
      return "row";
    case ExportLayout::atlas:
      return "atlas";
    case ExportLayout::parts:
      return "exr-multipart";
    case ExportLayout::array:
      return "array";
    case ExportLayout::volume:
      return "volume";
    case ExportLayout::function:
      return "function";
    case ExportLayout::table:
      return "table";
  }
  return "";
}

std::string depth_name(PixelType type) {
  switch (type) {
    case PixelType::uint8:
      return "8";
    case PixelType::uint16:
      return "16";
    case PixelType::uint32:
      return "32";
    case PixelType::float16:
      return "16f";
    case PixelType::float32:
      return "32f";
  }
  return "";
}

std::string container_names() {
  std::vector<std::string> names;
  for (const Container& container : containers())
    if (std::find(names.begin(), names.end(), container.name) == names.end()) names.push_back(container.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string container_depths() {
  return by_container([](const Container& container) {
    std::vector<std::string> words;
    for (const PixelType type : container.types) words.push_back(depth_name(type));
    return words;
  });
}

std::string container_layouts() {
  return by_container([](const Container& container) {
    std::vector<std::string> words;
    if (container.layouts.size() > 1)
      for (const ExportLayout layout : container.layouts) words.push_back(to_string(layout));
    return words;
  });
}

}  // namespace noiseloom
