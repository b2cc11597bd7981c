// Headerless numbers: [slice axes..., y, x, channel], described by a .json beside them (which export writes), or by a
// config and the size of the file. Where several types fit that size, the user is asked, unless the numbers themselves
// leave no doubt: those of noise, read as floats that they are not, do not all lie in the space of the samples.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "image/loaders/texture_loaders.h"
#include "noiseloom/core/json.h"
#include "noiseloom/files/file_ops.h"
#include "noiseloom/image/sample_check.h"

namespace noiseloom::loaders {
namespace {

// One way to read the bytes.
struct RawFormat {
  NumberType type;
  int channels = 1;  // numbers a pixel
};

constexpr struct {
  const char* name;
  NumberType type;
} type_names[] = {
    {"uint8", {NumberType::Kind::unsigned_integer, 1, false}},
    {"uint16", {NumberType::Kind::unsigned_integer, 2, false}},
    {"uint16be", {NumberType::Kind::unsigned_integer, 2, true}},
    {"float16", {NumberType::Kind::floating, 2, false}},
    {"float16be", {NumberType::Kind::floating, 2, true}},
    {"float32", {NumberType::Kind::floating, 4, false}},
    {"float32be", {NumberType::Kind::floating, 4, true}},
    {"float64", {NumberType::Kind::floating, 8, false}},
    {"float64be", {NumberType::Kind::floating, 8, true}},
};

std::string type_list() {
  std::string list;
  for (const auto& row : type_names) list += (list.empty() ? "" : ", ") + std::string(row.name);
  return list;
}

const NumberType* type_named(const std::string& name) {
  const auto* const found =
      std::find_if(std::begin(type_names), std::end(type_names), [&](const auto& row) { return name == row.name; });
  return found == std::end(type_names) ? nullptr : &found->type;
}

std::string name_of(const RawFormat& format) {
  for (const auto& row : type_names)
    if (row.type == format.type)
      return format.channels == 1 ? row.name : fmt::format("{}x{}", row.name, format.channels);
  return "";
}

// "uint8x4"; `channels` where it says no number.
RawFormat format_given(const std::string& text, int channels) {
  const std::size_t times = text.rfind('x');
  const NumberType* const type = type_named(text.substr(0, times));
  RawFormat format{type != nullptr ? *type : NumberType{}, channels};
  bool sound = type != nullptr;
  if (times != std::string::npos && sound) {
    const auto [end, error] = std::from_chars(text.data() + times + 1, text.data() + text.size(), format.channels);
    sound = error == std::errc{} && end == text.data() + text.size() && format.channels >= 1 && format.channels <= 1024;
  }
  if (!sound)
    throw UserError("command line", fmt::format("--type {}: accepted: {}; xN behind it for N numbers a pixel (uint8x4)",
                                                text, type_list()));
  return format;
}

std::vector<char> read_all(const std::string& path, std::uintmax_t most) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) throw EnvironmentError(path + ": cannot be read: " + error.message());
  if (size > most) throw UserError(path, fmt::format("{} bytes; accepted: at most {}", size, most));
  std::vector<char> bytes(size);
  std::ifstream in(path, std::ios::binary);
  in.read(bytes.data(), static_cast<std::streamsize>(size));
  if (!in) throw EnvironmentError(path + ": cannot be read");
  return bytes;
}

// "[5, 3, 2]"
std::vector<std::int64_t> parse_numbers(const std::string& text, const std::string& where) {
  std::vector<std::int64_t> numbers;
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  while (at != end) {
    if (*at == '[' || *at == ']' || *at == ',' || *at == ' ' || *at == '\n') {
      ++at;
      continue;
    }
    std::int64_t number = 0;
    const auto [next, error] = std::from_chars(at, end, number);
    if (error != std::errc{}) throw UserError(where, fmt::format("shape = {}: must be a list of integers", text));
    numbers.push_back(number);
    at = next;
  }
  return numbers;
}

// "[-1, 1]"
ValueRange parse_range_list(std::string text, const std::string& where) {
  const std::string written = text;
  std::erase_if(text, [](char c) { return c == ' ' || c == '[' || c == ']' || c == '\n'; });
  std::replace(text.begin(), text.end(), ',', ':');
  try {
    return parse_range(text);
  } catch (const UserError&) {
    throw UserError(where, fmt::format("range = {}: must be [lo, hi] with lo < hi", written));
  }
}

using Members = std::map<std::string, std::string>;

// The description of the numbers in the file beside them; none where there is none, or it describes something else.
std::optional<Members> description_in(const std::string& sidecar, std::string& why_not) {
  constexpr std::uintmax_t most_bytes = 1U << 24;
  if (!std::filesystem::is_regular_file(sidecar)) return std::nullopt;
  try {
    const std::vector<char> text = read_all(sidecar, most_bytes);
    Members members = parse_json_object(std::string(text.begin(), text.end()), sidecar);
    for (const char* const key : {"type", "shape", "encoded", "range", "config"})
      if (!members.contains(key)) {
        why_not = fmt::format("{} describes something else (it has no \"{}\")", sidecar, key);
        return std::nullopt;
      }
    return members;
  } catch (const UserError& error) {
    why_not = error.what();
    return std::nullopt;
  }
}

// The description's format; range, coding and, unless the request has one, config go to `stored`.
RawFormat described_format(const std::string& sidecar, const Members& members, const Request& request, Stored& stored) {
  const NumberType* const type = type_named(members.at("type"));
  if (type == nullptr)
    throw UserError(sidecar, fmt::format("type = \"{}\": accepted: {}", members.at("type"), type_list()));
  const std::vector<std::int64_t> shape = parse_numbers(members.at("shape"), sidecar);
  if (shape.size() < 3) throw UserError(sidecar, "shape: must be [slice axes..., y, x, channel]");
  if (shape.back() < 1 || shape.back() > 1024)
    throw UserError(sidecar,
                    fmt::format("shape = {}: {} channels; accepted: 1 to 1024", members.at("shape"), shape.back()));
  const RawFormat format{*type, static_cast<int>(shape.back())};
  stored.range = parse_range_list(members.at("range"), sidecar);
  const bool encoded = type->is_integer() || members.at("encoded") == "true";
  stored.coding = encoded ? Stored::Coding::codes : Stored::Coding::values;
  if (!request.config)
    stored.config =
        parse_config(members.at("config"), sidecar + ": config", parent_directory(sidecar), {}, MissingFiles::accepted);
  const RunConfig& config = request.config ? *request.config : *stored.config;
  std::vector<std::int64_t> expected = config.problem.extents.file_dimensions();
  expected.push_back(format.channels);
  if (shape != expected)
    throw UserError(sidecar, fmt::format("shape = {}, but the config says {} ({} values a pixel)", members.at("shape"),
                                         expected_size(config.problem.extents), format.channels));
  return format;
}

class RawFile {
 public:
  RawFile(const Request& request, const RunConfig& config)
      : request_(request),
        extents_(config.problem.extents),
        samples_(config.problem.samples),
        wanted_(config_channels(config)),
        bytes_(read_all(request.path, ~std::uintmax_t{0})) {}

  std::size_t num_bytes() const { return bytes_.size(); }
  std::size_t bytes_of(const RawFormat& format) const {
    return static_cast<std::size_t>(extents_.num_cells()) * static_cast<std::size_t>(format.channels) *
           static_cast<std::size_t>(format.type.bytes);
  }

  // What the option says, else the one reading that fits.
  RawFormat found_format() const {
    if (!request_.reading.type.empty()) return format_given(request_.reading.type, std::max(wanted_, 1));
    std::vector<RawFormat> fitting;
    for (const auto& row : type_names)
      for (int channels = 1; channels <= 8; ++channels)
        if (const RawFormat format{row.type, channels}; fits(format)) fitting.push_back(format);
    std::vector<RawFormat> certain;
    for (const RawFormat& format : fitting)
      if (!format.type.is_integer() && lies_in(samples_, format)) certain.push_back(format);
    if (certain.size() == 1) return certain.front();
    SampleSpec any;
    any.space = "file";
    std::erase_if(fitting, [&](const RawFormat& format) { return !format.type.is_integer() && !lies_in(any, format); });
    const std::vector<RawFormat>& left = certain.empty() ? fitting : certain;
    if (left.size() == 1) return left.front();
    if (left.empty()) size_fits_nothing();
    std::string names;
    for (const RawFormat& format : left)
      names += fmt::format("{}--type {}", names.empty() ? "" : ", ", name_of(format));
    throw UserError(request_.path, fmt::format("{} bytes for {} fit {} readings; say which: {}", bytes_.size(),
                                               expected_size(extents_), left.size(), names));
  }

  // With all channels, [slice][channel][y][x].
  Texture read(const RawFormat& format) const {
    Texture texture = make_texture(extents_, format.channels);
    std::vector<float> slice(texture.floats_per_slice());
    for (const SliceIndex s : extents_.slices()) {
      for (std::size_t i = 0; i < slice.size(); ++i)
        slice[i] = static_cast<float>(unit_or_value(format, static_cast<std::size_t>(s) * slice.size() + i));
      interleaved_to_planar(slice, format.channels, texture.slice(s));
    }
    return texture;
  }

 private:
  double unit_or_value(const RawFormat& format, std::size_t index) const {
    const std::size_t width = static_cast<std::size_t>(format.type.bytes);
    const double number = number_at(bytes_.data() + index * width, format.type);
    return format.type.is_integer() ? (number + 0.5) / std::ldexp(1.0, 8 * format.type.bytes) : number;
  }
  bool fits(const RawFormat& format) const {
    return bytes_.size() == bytes_of(format) && channels_fit(format.channels, wanted_);
  }
  // Of the first pixels; more do not make it more certain.
  bool lies_in(const SampleSpec& samples, const RawFormat& format) const {
    constexpr std::int64_t most_pixels = 65536;
    const std::size_t pixels = static_cast<std::size_t>(std::min(most_pixels, extents_.num_cells()));
    const std::size_t channels = static_cast<std::size_t>(wanted_ == 0 ? format.channels : wanted_);
    std::vector<float> pixel(channels);
    for (std::size_t p = 0; p < pixels; ++p) {
      for (std::size_t c = 0; c < channels; ++c) {
        const double value = unit_or_value(format, p * static_cast<std::size_t>(format.channels) + c);
        pixel[c] = static_cast<float>(value);
        if (pixel[c] == 0 && value != 0) return false;  // a double that is too small for a float
      }
      if (!may_be_sample(samples, pixel)) return false;
    }
    return true;
  }
  [[noreturn]] void size_fits_nothing() const {
    const std::size_t numbers =
        bytes_of({NumberType{NumberType::Kind::unsigned_integer, 1, false}, std::max(wanted_, 1)});
    throw UserError(
        request_.path,
        fmt::format("{} bytes, but the config says {} with {} values a pixel: {} bytes with 8 bits, {} "
                    "with 16, {} as float",
                    bytes_.size(), expected_size(extents_), std::max(wanted_, 1), numbers, 2 * numbers, 4 * numbers));
  }

  const Request& request_;
  const Extents& extents_;
  const SampleSpec& samples_;
  int wanted_;
  std::vector<char> bytes_;
};

}  // namespace

Stored raw(const Request& request) {
  const std::string& path = request.path;
  Stored stored;
  const std::string sidecar = std::filesystem::path(path).replace_extension(".json").string();
  std::string why_not = fmt::format("there is no {}", sidecar);
  std::optional<Members> description;
  if (request.reading.type.empty()) description = description_in(sidecar, why_not);
  if (!description && !request.config)
    throw UserError(path,
                    fmt::format("headerless numbers need a description: the .json that export writes beside them, "
                                "or --config and, where several types fit, --type; {}",
                                why_not));
  RawFormat format;
  if (description) format = described_format(sidecar, *description, request, stored);
  const RunConfig& config = request.config ? *request.config : *stored.config;
  const RawFile file(request, config);
  if (!description) {
    format = file.found_format();
    stored.coding = format.type.is_integer() ? Stored::Coding::codes : Stored::Coding::open;
    if (std::filesystem::exists(sidecar) && request.reading.type.empty())
      stored.notes.push_back(fmt::format("The config was used, as {}.", why_not));
  }
  if (file.num_bytes() != file.bytes_of(format))
    throw UserError(
        path, fmt::format(
                  "{} bytes, but {} says {}", file.num_bytes(),
                  description ? sidecar : "--type " + name_of(format) + " for " + expected_size(config.problem.extents),
                  file.bytes_of(format)));
  if (format.type.is_integer()) stored.step = std::ldexp(1.0, -8 * format.type.bytes);
  stored.texture = file.read(format);
  for (int c = 0; c < format.channels; ++c) stored.channel_names.push_back(std::to_string(c));
  stored.source = fmt::format("raw array, {}", name_of(format));
  return stored;
}

}  // namespace noiseloom::loaders
