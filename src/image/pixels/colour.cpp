#include "noiseloom/image/colour.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "noiseloom/core/error.h"
#include "noiseloom/core/number_type.h"
#include "noiseloom/image/image_reader.h"

namespace noiseloom {
namespace {

// Where the colour of each pixel stands among its channels: one place, or three.
std::vector<std::size_t> colour_channels(const ImageShape& shape, const std::string& path) {
  const auto place = [&shape](std::string_view name) {
    return std::find(shape.channel_names.begin(), shape.channel_names.end(), name) - shape.channel_names.begin();
  };
  const auto has = [&](std::string_view name) { return place(name) < std::ssize(shape.channel_names); };
  const auto at = [&](std::string_view name) { return static_cast<std::size_t>(place(name)); };
  if (has("R") && has("G") && has("B")) return {at("R"), at("G"), at("B")};
  if (has("Y")) return {at("Y")};
  const int colours = shape.channels - (shape.alpha >= 0 ? 1 : 0);
  if (colours == 1) return {shape.alpha == 0 ? std::size_t{1} : std::size_t{0}};
  throw UserError(path, fmt::format("channels {}: accepted: R, G and B; Y; or a single one, each with or without A",
                                    fmt::join(shape.channel_names, ", ")));
}

float number_of(const std::byte* bytes, PixelType type) {
  if (type == PixelType::uint8) return static_cast<float>(std::to_integer<unsigned>(*bytes)) / 255;
  if (type == PixelType::uint16) {
    std::uint16_t code = 0;
    std::memcpy(&code, bytes, sizeof code);
    return static_cast<float>(code) / 65535;
  }
  if (type == PixelType::float16) {
    std::uint16_t bits = 0;
    std::memcpy(&bits, bytes, sizeof bits);
    return static_cast<float>(half_to_double(bits));
  }
  float value = 0;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

}  // namespace

InputArrayPtr read_colour(const std::string& path) {
  ImageReader reader(path);
  if (reader.num_parts() != 1) {
    throw UserError(path, fmt::format("holds {} images; a density is one", reader.num_parts()));
  }
  if (!reader.window(0).empty()) {
    throw UserError(path, fmt::format("{}: a density must cover its whole picture, and no more", reader.window(0)));
  }
  const ImageShape& shape = reader.shape(0);
  const std::vector<std::size_t> colours = colour_channels(shape, path);
  const auto channels = static_cast<std::size_t>(shape.channels);
  const std::size_t bytes = bytes_per_number(shape.type);
  std::vector<std::byte> row(static_cast<std::size_t>(shape.width) * channels * bytes);
  std::vector<float> values;
  values.reserve(static_cast<std::size_t>(shape.width) * static_cast<std::size_t>(shape.height) * colours.size());
  for (int y = 0; y < shape.height; ++y) {
    reader.read_rows(0, y, 1, row);
    for (std::size_t x = 0; x < static_cast<std::size_t>(shape.width); ++x) {
      for (const std::size_t c : colours) values.push_back(number_of(&row[(x * channels + c) * bytes], shape.type));
    }
  }
  const auto depth = static_cast<std::int64_t>(colours.size());
  return std::make_shared<const InputArray>(InputArray{{shape.height, shape.width, depth}, std::move(values)});
}

}  // namespace noiseloom
