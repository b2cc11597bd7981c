#include "noiseloom/image/texture_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <new>

#include "image/loaders/texture_loaders.h"
#include "noiseloom/config/stored_config.h"
#include "noiseloom/files/generations.h"
#include "noiseloom/files/hdf5_array.h"
#include "noiseloom/files/npy.h"
#include "noiseloom/files/order_codec.h"
#include "noiseloom/files/pixel_order.h"
#include "noiseloom/files/run_file.h"
#include "noiseloom/image/image_reader.h"
#include "noiseloom/image/naming.h"
#include "noiseloom/image/sample_check.h"
#include "noiseloom/image/sequence.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {

std::string place_of(const Texture& texture, std::size_t index) {
  const std::size_t cells = static_cast<std::size_t>(texture.extents.cells_per_slice());
  const std::size_t width = static_cast<std::size_t>(texture.extents.width());
  const std::size_t cell = index % cells;
  const std::size_t plane = index / cells;
  const std::size_t channels = static_cast<std::size_t>(texture.channels);
  return fmt::format("x {}, y {}, slice {}, channel {}", cell % width, cell / width, plane / channels,
                     plane % channels);
}

Texture make_texture(const Extents& extents, int channels) {
  Texture texture{extents, channels, {}};
  const double bytes = static_cast<double>(extents.num_cells()) * channels * sizeof(float);
  try {
    if (bytes > 0x1p62) throw std::bad_alloc();
    texture.values.resize(texture.floats_per_slice() * static_cast<std::size_t>(extents.num_slices()));
  } catch (const std::bad_alloc&) {
    throw EnvironmentError(
        fmt::format("a texture of {} with {} value{} a pixel takes {:.0f} MB of memory, which the "
                    "system does not give",
                    extents.to_string(), channels, channels == 1 ? "" : "s", bytes / 1e6));
  }
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
  for (const SliceIndex s : texture.extents.slices()) {
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
namespace {

// The config's filter on the run file's texture; axes are matched by their names.
RunConfig with_filter_of(RunConfig stored, const RunConfig& given, const std::string& path) {
  FilterSpec filter = given.problem.filter;
  const Extents& extents = stored.problem.extents;
  for (GroupSpec& group : filter.groups)
    for (int& axis : group.axes) {
      const std::string& name = given.problem.extents.name(axis);
      axis = extents.axis(name);
      if (axis < 0) {
        std::string names;
        for (int a = 0; a < extents.num_axes(); ++a) names += (a == 0 ? "" : ", ") + extents.name(a);
        throw UserError(
            path, fmt::format("the filter of the config given is over axis {}, but the run file has {}", name, names));
      }
    }
  stored.problem.filter = std::move(filter);
  return stored;
}

std::vector<OrderPlace> places_of(const PixelOrder& order, const Extents& extents) {
  const std::size_t cells = static_cast<std::size_t>(extents.cells_per_slice());
  const std::int32_t count = std::min(most_slices_with_places, extents.num_slices());
  std::vector<OrderPlace> places(cells * static_cast<std::size_t>(count));
  for (const SliceIndex s : first_indices<SliceIndex>(count))
    order.read_slice(s, std::span(places).subspan(cells * static_cast<std::size_t>(s), cells));
  return places;
}

}  // namespace

TextureFile run_file(const Request& request) {
  const std::string& path = request.path;
  const RunFileReader reader = open_to_look_at(path);
  const RunFileContent& content = reader.content();
  const int samples = reader.dataset("/samples");
  if (samples < 0) throw UserError(path, "holds no /samples");
  require_finished_order(content, path);
  TextureFile file;
  file.source = "run file";
  if (!reader.change().empty()) file.notes.push_back(reader.change());
  file.config = stored_config(content, path);
  if (request.config) file.config = with_filter_of(*file.config, *request.config, path);
  file.history = content.history;
  if (const auto found = content.checksums.find("/samples"); found != content.checksums.end())
    file.checksum = found->second;
  const int channels = content.datasets[static_cast<std::size_t>(samples)].channels;
  if (reader.dataset(order_name) >= 0) file.places = places_of(PixelOrder(reader, path), content.extents);
  file.texture = make_texture(content.extents, channels);
  std::vector<float> slice(file.texture.floats_per_slice());
  for (const SliceIndex s : content.extents.slices()) {
    reader.read_slice(samples, s, std::as_writable_bytes(std::span(slice)));
    interleaved_to_planar(slice, channels, file.texture.slice(s));
  }
  return file;
}

}  // namespace loaders

namespace {

namespace fs = std::filesystem;

enum class FileKind { images, run_file, npy, raw, hdf5 };

FileKind kind_of(const std::string& path) {
  if (fs::is_directory(path)) return FileKind::images;
  if (!fs::exists(path)) {
    if (split_dataset_name(path)) return FileKind::hdf5;
    if (is_sequence_pattern(path)) return FileKind::images;
    const std::string no_pattern = why_no_file_name(fs::path(path).filename().string());
    throw UserError(path, "no such file" + previous_generation_note(path) +
                              (no_pattern.empty() ? "" : "; if it stands for many: " + no_pattern));
  }
  if (!fs::is_regular_file(path)) throw UserError(path, "a device, not a file");
  if (looks_like_run_file(path)) return FileKind::run_file;
  const std::string extension = lower_case_extension(path);
  if (extension == ".npy") return FileKind::npy;
  if (extension == ".raw" || extension == ".bin") return FileKind::raw;
  if (is_hdf5(path)) return FileKind::hdf5;
  if (extension == ".h5" || extension == ".hdf5") return may_be_run_file(path) ? FileKind::run_file : FileKind::hdf5;
  return FileKind::images;
}

loaders::Stored load_stored(FileKind kind, const loaders::Request& request) {
  switch (kind) {
    case FileKind::npy:
      return loaders::npy(request);
    case FileKind::raw:
      return loaders::raw(request);
    case FileKind::hdf5:
      return loaders::hdf5_dataset(request);
    default:
      return loaders::images(request);
  }
}

}  // namespace

TextureFile load_texture(const std::string& path, const std::optional<RunConfig>& config,
                         const TextureReading& reading) {
  const FileKind kind = kind_of(path);
  const loaders::Request request{path, config, reading};
  if (kind == FileKind::run_file) {
    TextureFile file = loaders::run_file(request);
    check_finite(file.texture, path);
    return file;
  }
  TextureFile file = loaders::interpret(load_stored(kind, request), request);
  check_finite(file.texture, path);
  if (!file.config) return file;
  const SampleSpec& samples = file.config->problem.samples;
  check_in_space(file.texture, samples, file.step, path);
  if (are_unit_vectors(samples)) normalise_directions(file.texture, path);
  return file;
}

StoredTexture load_stored_texture(const std::string& path, const std::optional<RunConfig>& config,
                                  const TextureReading& reading) {
  const FileKind kind = kind_of(path);
  const loaders::Request request{path, config, reading, true};
  StoredTexture found;
  if (kind == FileKind::run_file) {
    TextureFile file = loaders::run_file(request);
    found.texture = std::move(file.texture);
    for (int c = 0; c < found.texture.channels; ++c) found.channel_names.push_back(std::to_string(c));
    found.values = true;
    found.config = std::move(file.config);
    found.source = std::move(file.source);
    found.notes = std::move(file.notes);
    return found;
  }
  loaders::Stored stored = load_stored(kind, request);
  found.texture = std::move(stored.texture);
  found.channel_names = std::move(stored.channel_names);
  found.codes = stored.coding == loaders::Stored::Coding::codes;
  found.values = stored.coding == loaders::Stored::Coding::values;
  found.step = stored.step;
  found.is_srgb = stored.is_srgb;
  found.config = config ? config : std::move(stored.config);
  found.source = std::move(stored.source);
  found.notes = std::move(stored.notes);
  return found;
}

Extents suggested_extents(const std::string& path, int channels, const TextureReading& reading) {
  std::vector<std::string> notes;
  switch (kind_of(path)) {
    case FileKind::npy:
      return loaders::suggested_array_extents(path, read_npy_shape(path), channels, reading);
    case FileKind::hdf5:
      return loaders::suggested_array_extents(path, hdf5_array_shape(path), channels, reading);
    case FileKind::raw:
      throw UserError(path,
                      "raw numbers do not say their size: --set \"texture.size={ x = 128, y = 128 }\" or --config");
    default:
      return loaders::suggested_image_extents(path, reading, notes);
  }
}

}  // namespace noiseloom
