// From the numbers of a file to samples: which channels hold them, and what the numbers stand for.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <numeric>

#include "image/loaders/texture_loaders.h"
#include "noiseloom/files/npy.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom::loaders {
namespace {

using Channels = std::vector<std::size_t>;

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::string count_of(std::size_t channels) { return fmt::format("{} channel{}", channels, channels == 1 ? "" : "s"); }

bool is_constant(const Texture& texture, std::size_t channel) {
  const std::size_t cells = static_cast<std::size_t>(texture.extents.cells_per_slice());
  const float first = texture.slice(SliceIndex(0))[channel * cells];
  for (const SliceIndex s : texture.extents.slices())
    if (std::any_of(texture.slice(s) + channel * cells, texture.slice(s) + (channel + 1) * cells,
                    [first](float v) { return v != first; }))
      return false;
  return true;
}

bool are_equal(const Texture& texture, std::size_t a, std::size_t b) {
  const std::size_t cells = static_cast<std::size_t>(texture.extents.cells_per_slice());
  for (const SliceIndex s : texture.extents.slices())
    if (!std::equal(texture.slice(s) + a * cells, texture.slice(s) + (a + 1) * cells, texture.slice(s) + b * cells))
      return false;
  return true;
}

// Where nothing says how many channels a sample has: grey stored as RGB, and an unused blue or alpha, are none.
std::size_t channels_in_use(const Texture& texture) {
  std::size_t used = static_cast<std::size_t>(texture.channels);
  if (used == 4 && is_constant(texture, 3)) used = 3;
  if (used == 2 && is_constant(texture, 1)) return 1;
  if (used == 3 && are_equal(texture, 0, 1) && are_equal(texture, 0, 2)) return 1;
  if (used == 3 && is_constant(texture, 2)) used = is_constant(texture, 1) ? 1 : 2;
  return used;
}

// The channel of that name, in any case, or of that number.
std::optional<std::size_t> find_channel(const std::vector<std::string>& names, const std::string& text) {
  const auto same = [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
  };
  for (std::size_t c = 0; c < names.size(); ++c)
    if (std::equal(text.begin(), text.end(), names[c].begin(), names[c].end(), same)) return c;
  std::size_t number = names.size();
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size() || number >= names.size()) return std::nullopt;
  return number;
}

// "RG", "0,2", "G"
Channels channels_given(const std::string& text, const std::vector<std::string>& names, const std::string& path) {
  std::vector<std::string> items;
  if (text.find(',') == std::string::npos && !find_channel(names, text)) {
    for (const char letter : text) items.emplace_back(1, letter);
  } else {
    for (std::size_t at = 0; at <= text.size();) {
      const std::size_t end = std::min(text.find(',', at), text.size());
      items.push_back(text.substr(at, end - at));
      at = end + 1;
    }
  }
  Channels channels;
  for (const std::string& item : items) {
    const auto found = find_channel(names, item);
    if (!found)
      throw UserError(path,
                      fmt::format("--channels {}: no channel \"{}\"; the file has {}", text, item, joined(names)));
    channels.push_back(*found);
  }
  return channels;
}

Channels channels_to_take(const Stored& stored, const std::optional<RunConfig>& config, const Request& request) {
  const int wanted = config_channels(config);
  const std::size_t found = static_cast<std::size_t>(stored.texture.channels);
  if (!request.reading.channels.empty()) {
    Channels given = channels_given(request.reading.channels, stored.channel_names, request.path);
    if (wanted != 0 && given.size() != static_cast<std::size_t>(wanted))
      throw UserError(request.path, fmt::format("--channels {} names {}, but samples of the config have {}",
                                                request.reading.channels, count_of(given.size()), wanted));
    return given;
  }
  if (!channels_fit(stored.texture.channels, wanted))
    throw UserError(
        request.path,
        fmt::format("{} ({}), but samples of the config have {}{}", count_of(found), joined(stored.channel_names),
                    wanted, found > static_cast<std::size_t>(wanted) ? "; say which to take by --channels" : ""));
  Channels first(wanted == 0 ? channels_in_use(stored.texture) : static_cast<std::size_t>(wanted));
  std::iota(first.begin(), first.end(), std::size_t{0});
  return first;
}

std::vector<std::string> channels_left(const Stored& stored, const Channels& taken) {
  std::vector<std::string> names;
  for (std::size_t c = 0; c < stored.channel_names.size(); ++c) {
    const bool copy = std::any_of(taken.begin(), taken.end(),
                                  [&](std::size_t t) { return t == c || are_equal(stored.texture, t, c); });
    if (!copy && !is_constant(stored.texture, c)) names.push_back(stored.channel_names[c]);
  }
  return names;
}

Texture with_channels(Texture texture, const Channels& channels) {
  bool all = channels.size() == static_cast<std::size_t>(texture.channels);
  for (std::size_t i = 0; i < channels.size() && all; ++i) all = channels[i] == i;
  if (all) return texture;
  Texture kept = make_texture(texture.extents, narrow<int>(channels.size()));
  const std::size_t cells = static_cast<std::size_t>(texture.extents.cells_per_slice());
  for (const SliceIndex s : texture.extents.slices())
    for (std::size_t i = 0; i < channels.size(); ++i)
      std::copy_n(texture.slice(s) + channels[i] * cells, cells, kept.slice(s) + i * cells);
  return kept;
}

// Stored floats of a signed space are either the values themselves or, if none is negative, 0.5 + 0.5 v: images that
// cannot hold negative numbers.
void decode_floats(TextureFile& file) {
  const ValueRange range = stored_range(file.config);
  if (range == ValueRange{}) return;
  std::vector<float>& values = file.texture.values;
  if (std::any_of(values.begin(), values.end(), [](float v) { return v < 0; })) return;
  for (float& v : values) v = static_cast<float>(from_unit(range, static_cast<double>(v)));
  file.step *= range.hi - range.lo;
  file.notes.push_back("No value is negative, so values were decoded as 2 v - 1.");
}

}  // namespace

TextureFile interpret(Stored stored, const Request& request) {
  TextureFile file;
  file.config = request.config ? request.config : stored.config;
  file.source = std::move(stored.source);
  file.notes = std::move(stored.notes);
  file.step = stored.step;
  const Channels taken = channels_to_take(stored, file.config, request);
  file.further_channels = channels_left(stored, taken);
  if (const std::vector<std::string>& left = file.further_channels; !left.empty()) {
    std::vector<std::string> names;
    for (const std::size_t c : taken) names.push_back(stored.channel_names[c]);
    file.notes.push_back(
        fmt::format("Of the channels, {} {} taken; {} {} values of {} own, which --channels would take.", joined(names),
                    names.size() == 1 ? "was" : "were", joined(left), left.size() == 1 ? "holds" : "hold",
                    left.size() == 1 ? "its" : "their"));
  }
  file.texture = with_channels(std::move(stored.texture), taken);
  if (stored.coding == Stored::Coding::open) decode_floats(file);
  if (stored.coding != Stored::Coding::codes) return file;
  const ValueRange range = stored.range ? *stored.range : stored_range(file.config);
  for (float& v : file.texture.values) v = static_cast<float>(from_unit(range, static_cast<double>(v)));
  file.step *= range.hi - range.lo;
  return file;
}

int config_channels(const RunConfig& config) {
  const SampleSpec& samples = config.problem.samples;
  if (!samples.is_file()) return num_channels(samples);
  const std::int64_t cells = config.problem.extents.cells_per_slice();
  const std::int64_t slices = config.problem.extents.num_slices();
  std::vector<std::int64_t> shape;
  try {
    shape = read_npy_shape(samples.file);
  } catch (const UserError&) {  // the list is no longer there: the texture itself will tell
    return 0;
  }
  const bool vectors = shape.size() == 2 && shape[0] == cells && shape[1] <= 8;
  const bool scalars_per_slice = shape.size() == 2 && shape[0] == slices && shape[1] == cells;
  if (vectors && scalars_per_slice) return 0;
  if (shape.size() == 1 || scalars_per_slice) return 1;
  if (vectors || (shape.size() == 3 && shape[2] >= 1 && shape[2] <= 8)) return static_cast<int>(shape.back());
  return 0;
}

int config_channels(const std::optional<RunConfig>& config) { return config ? config_channels(*config) : 0; }

bool channels_fit(int found, int wanted) {
  if (wanted == 0) return found >= 1;
  return wanted <= 3 ? found >= wanted && found <= 4 : found == wanted;
}

ValueRange stored_range(const std::optional<RunConfig>& config) {
  if (!config) return {};
  const SampleSpec& samples = config->problem.samples;
  if (const auto range = natural_range(samples)) return *range;
  return samples.is_file() && is_between_unit_vectors(samples.distance) ? ValueRange{-1, 1} : ValueRange{};
}

std::string expected_size(const Extents& extents) {
  return fmt::format("{} slice{} of {} x {}", extents.num_slices(), extents.num_slices() == 1 ? "" : "s",
                     extents.width(), extents.height());
}

}  // namespace noiseloom::loaders
