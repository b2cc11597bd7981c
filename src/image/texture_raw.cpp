// Raw arrays: [slice axes..., y, x, channel], little-endian, described by a .json beside them (which export writes) or
// by a config, and then the size of the file tells the type.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "image/texture_loaders.h"
#include "noiseloom/core/json.h"
#include "noiseloom/files/file_ops.h"
#include "noiseloom/image/image_io.h"

namespace noiseloom::loaders {
namespace {

std::vector<char> read_all(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::vector<char> bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in || in.bad()) throw EnvironmentError(path + ": cannot be read");
  return bytes;
}

struct RawFormat {
  PixelType type = PixelType::float32;
  ValueRange range;
  bool encoded = true;  // numbers are 0..1 of the range
  bool described = false;
  int channels = 1;
};

PixelType type_named(const std::string& name, const std::string& where) {
  if (name == "uint8") return PixelType::uint8;
  if (name == "uint16") return PixelType::uint16;
  if (name == "float32") return PixelType::float32;
  throw UserError(where, fmt::format("type = \"{}\": accepted: uint8, uint16, float32", name));
}

// "[5, 3, 2]"
std::vector<std::int64_t> parse_numbers(const std::string& text, const std::string& where) {
  std::vector<std::int64_t> numbers;
  std::size_t at = 1;
  while (at < text.size() && text[at] != ']') {
    std::size_t used = 0;
    try {
      numbers.push_back(std::stoll(text.substr(at), &used));
    } catch (const std::exception&) {
      throw UserError(where, fmt::format("shape = {}: must be a list of integers", text));
    }
    at = text.find_first_not_of(", ", at + used);
    if (at == std::string::npos) break;
  }
  return numbers;
}

// "[-1, 1]"
ValueRange parse_range_list(std::string text, const std::string& where) {
  std::erase_if(text, [](char c) { return c == ' ' || c == '[' || c == ']'; });
  std::replace(text.begin(), text.end(), ',', ':');
  try {
    return parse_range(text);
  } catch (const UserError&) {
    throw UserError(where, fmt::format("range = {}: must be [lo, hi] with lo < hi", text));
  }
}

// The format from the description beside the file; its config goes to `config` unless one was given.
RawFormat described_format(const std::string& sidecar, std::optional<RunConfig>& config) {
  const std::vector<char> text = read_all(sidecar);
  const auto members = parse_json_object(std::string(text.begin(), text.end()), sidecar);
  const auto member = [&](const std::string& key) {
    const auto found = members.find(key);
    if (found == members.end()) throw UserError(sidecar, fmt::format("\"{}\" is missing", key));
    return found->second;
  };
  RawFormat format;
  format.described = true;
  format.type = type_named(member("type"), sidecar);
  format.encoded = member("encoded") == "true";
  format.range = parse_range_list(member("range"), sidecar);
  const std::vector<std::int64_t> shape = parse_numbers(member("shape"), sidecar);
  if (shape.size() < 3) throw UserError(sidecar, "shape: must be [slice axes..., y, x, channel]");
  if (shape.back() < 1 || shape.back() > 1024) {
    throw UserError(sidecar,
                    fmt::format("shape = {}: {} channels; accepted: 1 to 1024", member("shape"), shape.back()));
  }
  format.channels = static_cast<int>(shape.back());
  if (!config)
    config =
        parse_config(member("config"), sidecar + ": config", parent_directory(sidecar), {}, MissingFiles::accepted);
  std::vector<std::int64_t> expected = config->problem.extents.file_dimensions();
  expected.push_back(format.channels);
  if (shape != expected)
    throw UserError(sidecar, fmt::format("shape = {}, but the config says {} ({} values a pixel)", member("shape"),
                                         expected_size(*config), format.channels));
  return format;
}

RawFormat format_by_size(const std::string& path, std::size_t size, const RunConfig& config) {
  RawFormat format;
  format.range = stored_range(config);
  format.channels = std::max(config_channels(config), 1);
  const std::size_t numbers =
      static_cast<std::size_t>(config.problem.extents.num_cells()) * static_cast<std::size_t>(format.channels);
  for (const PixelType type : {PixelType::uint8, PixelType::uint16, PixelType::float32}) {
    if (size != numbers * bytes_per_number(type)) continue;
    format.type = type;
    return format;
  }
  throw UserError(path, fmt::format("{} bytes, but the config says {} with {} values a pixel: {} bytes with 8 bits, {} "
                                    "with 16, {} as float",
                                    size, expected_size(config), format.channels, numbers, 2 * numbers, 4 * numbers));
}

double number_at(const std::vector<char>& bytes, PixelType type, std::size_t index) {
  if (type == PixelType::uint8) return dequantise(static_cast<std::uint8_t>(bytes[index]), 8);
  if (type == PixelType::uint16) {
    std::uint16_t b;
    std::memcpy(&b, bytes.data() + 2 * index, sizeof b);
    return dequantise(b, 16);
  }
  float v;
  std::memcpy(&v, bytes.data() + 4 * index, sizeof v);
  return static_cast<double>(v);
}

}  // namespace

TextureFile raw(const std::string& path, const std::optional<RunConfig>& config) {
  TextureFile file;
  file.config = config;
  const std::string sidecar = std::filesystem::path(path).replace_extension(".json").string();
  const bool described = std::filesystem::exists(sidecar);
  if (!described && !config)
    throw UserError(path, fmt::format("raw numbers need a description: {} beside it, or --config", sidecar));
  const std::vector<char> bytes = read_all(path);
  const RawFormat format =
      described ? described_format(sidecar, file.config) : format_by_size(path, bytes.size(), *config);
  const Extents& extents = file.config->problem.extents;
  const int wanted = config_channels(*file.config);
  if (wanted != 0 && wanted != format.channels)
    throw UserError(path, fmt::format("{} values a pixel, but samples of the config have {}", format.channels, wanted));
  file.texture = make_texture(extents, format.channels);
  const std::size_t numbers = file.texture.values.size();
  if (bytes.size() != numbers * bytes_per_number(format.type))
    throw UserError(
        path, fmt::format("{} bytes, but {} says {}", bytes.size(), sidecar, numbers * bytes_per_number(format.type)));
  std::vector<float> slice(file.texture.floats_per_slice());
  const bool decode = format.type != PixelType::float32 || (format.described && format.encoded);
  for (SliceIndex s = 0; s < extents.num_slices(); ++s) {
    for (std::size_t i = 0; i < slice.size(); ++i) {
      const double stored = number_at(bytes, format.type, static_cast<std::size_t>(s) * slice.size() + i);
      slice[i] = static_cast<float>(decode ? from_unit(format.range, stored) : stored);
    }
    interleaved_to_planar(slice, format.channels, file.texture.slice(s));
  }
  file.source = fmt::format("raw array, {}", to_string(format.type));
  if (!decode && !format.described) decode_floats(file);
  return file;
}

}  // namespace noiseloom::loaders
