#include "noiseloom/image/texture_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "image/texture_loaders.h"
#include "noiseloom/config/stored_config.h"
#include "noiseloom/files/order_codec.h"
#include "noiseloom/files/pixel_order.h"
#include "noiseloom/files/run_file.h"
#include "noiseloom/image/sequence.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {
namespace {

// "channel 1 at x 5, y 7, slice 3"
std::string place_of(const Texture& texture, std::size_t index) {
  const std::size_t cells = static_cast<std::size_t>(texture.extents.cells_per_slice());
  const std::size_t width = static_cast<std::size_t>(texture.extents.width());
  const std::size_t cell = index % cells;
  const std::size_t plane = index / cells;
  const std::size_t channels = static_cast<std::size_t>(texture.channels);
  return fmt::format("x {}, y {}, slice {}, channel {}", cell % width, cell / width, plane / channels,
                     plane % channels);
}

}  // namespace

Texture make_texture(const Extents& extents, int channels) {
  Texture texture{extents, channels, {}};
  texture.values.resize(texture.floats_per_slice() * static_cast<std::size_t>(extents.num_slices()));
  return texture;
}

void interleaved_to_planar(std::span<const float> interleaved, int channels, float* planes) {
  const std::size_t step = static_cast<std::size_t>(channels);
  const std::size_t cells = interleaved.size() / step;
  for (std::size_t c = 0; c < step; ++c)
    for (std::size_t cell = 0; cell < cells; ++cell) planes[c * cells + cell] = interleaved[cell * step + c];
}

std::vector<float> interleaved_slice(const Texture& texture, SliceIndex slice) {
  const std::size_t channels = static_cast<std::size_t>(texture.channels);
  const std::size_t cells = static_cast<std::size_t>(texture.extents.cells_per_slice());
  const float* const planes = texture.slice(slice);
  std::vector<float> interleaved(texture.floats_per_slice());
  for (std::size_t c = 0; c < channels; ++c)
    for (std::size_t cell = 0; cell < cells; ++cell) interleaved[cell * channels + c] = planes[c * cells + cell];
  return interleaved;
}

void check_finite(const Texture& texture, const std::string& name) {
  const auto bad =
      std::find_if(texture.values.begin(), texture.values.end(), [](float v) { return !std::isfinite(v); });
  if (bad == texture.values.end()) return;
  const std::size_t index = static_cast<std::size_t>(bad - texture.values.begin());
  throw UserError(name, fmt::format("the value at {} is {}: must be finite", place_of(texture, index), *bad));
}

void normalise_directions(Texture& texture, const std::string& name) {
  const std::size_t cells = static_cast<std::size_t>(texture.extents.cells_per_slice());
  const std::size_t channels = static_cast<std::size_t>(texture.channels);
  for (SliceIndex s = 0; s < texture.extents.num_slices(); ++s) {
    float* const slice = texture.slice(s);
    for (std::size_t cell = 0; cell < cells; ++cell) {
      double squares = 0;
      for (std::size_t c = 0; c < channels; ++c) {
        const double v = slice[c * cells + cell];
        squares += v * v;
      }
      const double length = std::sqrt(squares);
      if (!(length > 0) || !std::isfinite(length)) {
        const std::size_t index = static_cast<std::size_t>(s) * channels * cells + cell;
        throw UserError(name, fmt::format("the direction at {} has length {}: must be a unit vector",
                                          place_of(texture, index), length));
      }
      for (std::size_t c = 0; c < channels; ++c)
        slice[c * cells + cell] = static_cast<float>(slice[c * cells + cell] / length);
    }
  }
}

namespace loaders {

int config_channels(const RunConfig& config) {
  return config.problem.samples.kind == SampleKind::file ? 0 : num_channels(config.problem.samples);
}

ValueRange stored_range(const std::optional<RunConfig>& config) {
  if (!config) return {};
  const SampleSpec& samples = config->problem.samples;
  if (const auto range = natural_range(samples)) return *range;
  return samples.kind == SampleKind::file && samples.distance == DistanceKind::angle ? ValueRange{-1, 1} : ValueRange{};
}

std::string expected_size(const RunConfig& config) {
  const Extents& extents = config.problem.extents;
  return fmt::format("{} slice{} of {} x {}", extents.num_slices(), extents.num_slices() == 1 ? "" : "s",
                     extents.width(), extents.height());
}

void decode_floats(TextureFile& file) {
  const ValueRange range = stored_range(file.config);
  if (range == ValueRange{}) return;
  std::vector<float>& values = file.texture.values;
  if (std::any_of(values.begin(), values.end(), [](float v) { return v < 0; })) return;
  for (float& v : values) v = static_cast<float>(from_unit(range, v));
  file.notes.push_back("No value is negative, so values were decoded as 2 v - 1.");
}

namespace {

// The config's filter on the run file's texture, which must have the same size.
RunConfig with_filter_of(RunConfig stored, const RunConfig& given, const std::string& path) {
  if (!(stored.problem.extents == given.problem.extents))
    throw UserError(
        path, fmt::format("holds {} (axes {}), but the config given says {} (axes {})", expected_size(stored),
                          stored.problem.extents.to_string(), expected_size(given), given.problem.extents.to_string()));
  stored.problem.filter = given.problem.filter;
  return stored;
}

std::vector<std::uint64_t> ranks_of(const PixelOrder& order, const Extents& extents) {
  const std::size_t cells = static_cast<std::size_t>(extents.cells_per_slice());
  const SliceIndex count = std::min(ranked_slices, extents.num_slices());
  std::vector<std::uint64_t> ranks(cells * static_cast<std::size_t>(count));
  for (SliceIndex s = 0; s < count; ++s)
    order.read_slice(s, std::span(ranks).subspan(cells * static_cast<std::size_t>(s), cells));
  return ranks;
}

}  // namespace

TextureFile run_file(const std::string& path, const std::optional<RunConfig>& config) {
  const RunFileReader reader(path, Changed::accepted);
  const RunFileContent& content = reader.content();
  const int samples = reader.dataset("/samples");
  if (samples < 0) throw UserError(path, "holds no /samples");
  require_finished_order(content, path);
  TextureFile file;
  file.source = "run file";
  if (!reader.change().empty()) file.notes.push_back(reader.change());
  file.config = stored_config(content, path);
  if (config) file.config = with_filter_of(*file.config, *config, path);
  file.history = content.history;
  if (const auto found = content.checksums.find("/samples"); found != content.checksums.end())
    file.checksum = found->second;
  const int channels = content.datasets[static_cast<std::size_t>(samples)].channels;
  if (reader.dataset("/order") >= 0) file.ranks = ranks_of(PixelOrder(reader, path), content.extents);
  file.texture = make_texture(content.extents, channels);
  std::vector<float> slice(file.texture.floats_per_slice());
  for (SliceIndex s = 0; s < content.extents.num_slices(); ++s) {
    reader.read_slice(samples, s, std::as_writable_bytes(std::span(slice)));
    interleaved_to_planar(slice, channels, file.texture.slice(s));
  }
  return file;
}

}  // namespace loaders

namespace {

TextureFile load_any(const std::string& path, const std::optional<RunConfig>& config) {
  namespace fs = std::filesystem;
  if (fs::is_directory(path) || (!fs::exists(path) && is_sequence_pattern(path))) return loaders::images(path, config);
  if (!fs::exists(path)) throw UserError(path, "no such file");
  if (looks_like_run_file(path)) return loaders::run_file(path, config);
  const std::string extension = fs::path(path).extension().string();
  if (extension == ".npy") return loaders::npy(path, config);
  if (extension == ".raw" || extension == ".bin") return loaders::raw(path, config);
  if (extension == ".h5" || extension == ".hdf5")
    throw UserError(path, "not a run file of noiseloom, or one whose beginning is damaged");
  return loaders::images(path, config);
}

}  // namespace

TextureFile load_texture(const std::string& path, const std::optional<RunConfig>& config) {
  TextureFile file = load_any(path, config);
  check_finite(file.texture, path);
  const bool directions = file.config &&
                          distance_kind(file.config->problem.samples, file.texture.channels) == DistanceKind::angle &&
                          file.source != "run file";
  if (directions) normalise_directions(file.texture, path);
  return file;
}

}  // namespace noiseloom
