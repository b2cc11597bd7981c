#include "noiseloom/image/encoding.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

bool parse_number(std::string_view text, double& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() && std::isfinite(value);
}

PixelLayout named(std::vector<int> source, std::vector<std::string> names) {
  PixelLayout layout{std::move(source), std::move(names), -1};
  for (std::size_t i = 0; i < layout.names.size(); ++i)
    if (layout.names[i] == "A") layout.alpha = static_cast<int>(i);
  return layout;
}

PixelLayout numbered(int channels) {
  PixelLayout layout;
  for (int c = 0; c < channels; ++c) {
    layout.source.push_back(c);
    layout.names.push_back(fmt::format("c{}", c));
  }
  return layout;
}

// Three channels: a scalar three times, two channels and zero, or three.
std::vector<int> three_sources(int channels) {
  return {0, channels > 1 ? 1 : 0, channels == 3 ? 2 : channels == 2 ? zero_channel : 0};
}

}  // namespace

std::optional<ValueRange> natural_range(const SampleSpec& samples) {
  return samples.is_file() ? std::nullopt : space_traits(samples).range;
}

ValueRange parse_range(const std::string& text) {
  ValueRange range;
  const std::size_t colon = text.find(':');
  const bool parsed = colon != std::string::npos && parse_number(std::string_view(text).substr(0, colon), range.lo) &&
                      parse_number(std::string_view(text).substr(colon + 1), range.hi);
  if (!parsed || range.lo >= range.hi)
    throw UserError("command line",
                    fmt::format("--range {}: must be two numbers LO:HI with LO < HI, such as --range=-4:4", text));
  return range;
}

std::string shortest_number(double value) { return fmt::format("{}", value); }

PixelLayout png_pixel(int channels, bool with_density) {
  if (with_density) {
    std::vector<int> source = three_sources(channels);
    source.push_back(density_channel);
    return named(std::move(source), {"R", "G", "B", "A"});
  }
  switch (channels) {
    case 1:
      return named({0}, {"Y"});
    case 2:
      return named({0, 1, zero_channel}, {"R", "G", "B"});
    case 3:
      return named({0, 1, 2}, {"R", "G", "B"});
    default:
      return named({0, 1, 2, 3}, {"R", "G", "B", "A"});
  }
}

PixelLayout tiff_pixel(int channels, bool with_density) {
  return channels > 4 ? numbered(channels) : png_pixel(channels, with_density);
}

PixelLayout exr_pixel(int channels, bool with_density) {
  static const std::vector<std::vector<std::string>> names = {{"Y"}, {"R", "G"}, {"R", "G", "B"}, {"R", "G", "B", "A"}};
  if (channels > 4) return numbered(channels);
  std::vector<int> source;
  for (int c = 0; c < channels; ++c) source.push_back(c);
  std::vector<std::string> channel_names = names[static_cast<std::size_t>(channels - 1)];
  if (with_density) {
    source.push_back(density_channel);
    channel_names.emplace_back("A");
  }
  return named(std::move(source), std::move(channel_names));
}

PixelLayout rgb_pixel(int channels, bool) { return named(three_sources(channels), {"R", "G", "B"}); }

PixelLayout plain_pixel(int channels, bool) {
  PixelLayout layout = numbered(channels);
  layout.names.clear();
  return layout;
}

PixelLayout pixel_of_size(int size, int channels) {
  static const std::vector<std::string> names = {"R", "G", "B", "A"};
  std::vector<int> source;
  for (int c = 0; c < channels; ++c) source.push_back(c);
  if (size == 2 && channels == 1) source.push_back(zero_channel);
  if (size >= 3 && channels < 3) source = three_sources(channels);
  if (size == 4 && channels < 4) source.push_back(opaque_channel);
  return named(std::move(source), {names.begin(), names.begin() + size});
}

PixelLayout texture_pixel(int channels, bool with_density) {
  if (with_density) return png_pixel(channels, true);
  return pixel_of_size(channels == 3 ? 4 : channels, channels);
}

PixelLayout rgba_pixel(int channels, bool) {
  std::vector<int> source = three_sources(channels);
  source.push_back(opaque_channel);
  return named(std::move(source), {"R", "G", "B", "A"});
}

}  // namespace noiseloom
