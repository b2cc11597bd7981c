// Images to textures. An arrangement says where each slice lies (file, part, first row); it is found and checked before
// a pixel is read.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>

#include "image/texture_loaders.h"
#include "noiseloom/image/image_io.h"
#include "noiseloom/image/sequence.h"

namespace noiseloom::loaders {
namespace {

struct Place {
  std::size_t file;
  int part;
  int row;
};

struct Arrangement {
  std::vector<std::string> files;
  std::vector<Place> slices;
  std::string kind;  // "64 images", "a strip of 64 slices", "64 parts", "one image"
};

[[noreturn]] void size_differs(const std::string& path, const std::string& found, const RunConfig& config) {
  throw UserError(path, fmt::format("{}, but the config says {}", found, expected_size(config)));
}

std::string size_of(const ImageShape& shape) { return fmt::format("{} x {} pixels", shape.width, shape.height); }

// One file: a single slice, a strip or several parts.
Arrangement arrange_one(const std::string& path, const Extents& extents, const std::optional<RunConfig>& config) {
  ImageReader reader(path);
  const ImageShape& shape = reader.shape(0);
  const std::int64_t slices = extents.num_slices();
  Arrangement arrangement{{path}, {}, ""};
  if (reader.num_parts() > 1) {
    if (config && (reader.num_parts() != slices || shape.width != extents.width() || shape.height != extents.height()))
      size_differs(path, fmt::format("{} parts of {}", reader.num_parts(), size_of(shape)), *config);
    for (int part = 0; part < reader.num_parts(); ++part) arrangement.slices.push_back({0, part, 0});
    arrangement.kind = fmt::format("{} parts of one image", reader.num_parts());
    return arrangement;
  }
  const int height = narrow<int>(extents.height());
  if (config && (shape.width != extents.width() || shape.height != extents.height() * slices))
    size_differs(path, size_of(shape), *config);
  for (int s = 0; s < slices; ++s) arrangement.slices.push_back({0, 0, s * height});
  arrangement.kind = slices == 1 ? "one image" : fmt::format("a strip of {} slices", slices);
  return arrangement;
}

Arrangement arrange_many(const std::string& path, std::vector<std::string> files,
                         const std::optional<RunConfig>& config) {
  if (config && std::cmp_not_equal(files.size(), config->problem.extents.num_slices()))
    size_differs(path, fmt::format("{} image{}", files.size(), files.size() == 1 ? "" : "s"), *config);
  Arrangement arrangement{std::move(files), {}, ""};
  for (std::size_t f = 0; f < arrangement.files.size(); ++f) arrangement.slices.push_back({f, 0, 0});
  arrangement.kind = fmt::format("{} images", arrangement.files.size());
  return arrangement;
}

// The size that the images themselves suggest: as many slices as there are files or parts, else squares in a strip.
Extents suggested_extents(const std::vector<std::string>& files, std::vector<std::string>& notes) {
  ImageReader reader(files.front());
  const ImageShape& shape = reader.shape(0);
  std::int64_t slices = static_cast<std::int64_t>(files.size()) * reader.num_parts();
  std::int64_t height = shape.height;
  if (slices == 1 && shape.height > shape.width && shape.height % shape.width == 0) {
    height = shape.width;
    slices = shape.height / shape.width;
    notes.push_back(
        fmt::format("The image was taken as a strip of {} slices of {} x {}.", slices, shape.width, height));
  }
  return slices == 1 ? Extents({shape.width, height}) : Extents({shape.width, height, slices});
}

Arrangement arrange(const std::string& path, const std::optional<RunConfig>& config, Extents& extents,
                    std::vector<std::string>& notes) {
  const bool many = std::filesystem::is_directory(path) || !std::filesystem::exists(path);
  std::vector<std::string> files = many ? find_sequence(path) : std::vector<std::string>{path};
  if (!config) {
    extents = suggested_extents(files, notes);
  } else if (!many && extents.num_slices() > 1) {  // the first of a sequence?
    ImageReader reader(path);
    std::vector<std::string> sequence = sequence_from_first(path);
    if (reader.num_parts() == 1 && reader.shape(0).height == extents.height() && sequence.size() > 1) {
      const std::size_t wanted = static_cast<std::size_t>(extents.num_slices());
      if (sequence.size() > wanted) {
        sequence.resize(wanted);
        notes.push_back(
            fmt::format("More numbered images follow than the config's {} slices; they were left out.", wanted));
      }
      files = std::move(sequence);
    }
  }
  return files.size() == 1 ? arrange_one(files.front(), extents, config) : arrange_many(path, std::move(files), config);
}

// Channels of the texture for an image of these channels; UserError where the config's samples do not fit.
int channels_to_take(const std::string& path, const ImageShape& shape, const std::optional<RunConfig>& config) {
  const int wanted = config ? config_channels(*config) : 0;
  if (wanted == 0) return shape.channels;
  const bool fits = wanted == 1   ? true
                    : wanted <= 3 ? shape.channels >= wanted && shape.channels <= 4
                                  : shape.channels == wanted;
  if (!fits)
    throw UserError(path, fmt::format("{} channel{} ({}), but samples of the config have {}", shape.channels,
                                      shape.channels == 1 ? "" : "s", to_string(shape.type), wanted));
  return wanted;
}

// Stored numbers of one slice, interleaved with all channels of the image, as 0..1 (integers) or as they are (floats).
class SliceDecoder {
 public:
  explicit SliceDecoder(const ImageShape& shape) : shape_(shape) {}
  double operator()(std::span<const std::byte> bytes, std::size_t index) const {
    switch (shape_.type) {
      case PixelType::uint8:
        return dequantise(std::to_integer<std::uint8_t>(bytes[index]), 8);
      case PixelType::uint16: {
        std::uint16_t b;
        std::memcpy(&b, bytes.data() + 2 * index, sizeof b);
        return dequantise(b, 16);
      }
      case PixelType::float32: {
        float v;
        std::memcpy(&v, bytes.data() + 4 * index, sizeof v);
        return static_cast<double>(v);
      }
    }
    return 0;
  }

 private:
  ImageShape shape_;
};

// Without a config: grey stored as RGB, and an unused blue or alpha, are not channels of the sample.
int channels_in_use(const Texture& texture) {
  if (texture.channels < 2) return texture.channels;
  const std::size_t cells = static_cast<std::size_t>(texture.extents.cells_per_slice());
  const auto equal = [&](std::size_t a, std::size_t b) {
    for (SliceIndex s = 0; s < texture.extents.num_slices(); ++s)
      if (!std::equal(texture.slice(s) + a * cells, texture.slice(s) + (a + 1) * cells, texture.slice(s) + b * cells))
        return false;
    return true;
  };
  const auto constant = [&](std::size_t c) {
    const float first = texture.slice(0)[c * cells];
    for (SliceIndex s = 0; s < texture.extents.num_slices(); ++s)
      if (std::any_of(texture.slice(s) + c * cells, texture.slice(s) + (c + 1) * cells,
                      [first](float v) { return v != first; }))
        return false;
    return true;
  };
  int used = texture.channels;
  if (used == 4 && constant(3)) used = 3;
  if (used == 2 && constant(1)) return 1;
  if (used == 3 && equal(0, 1) && equal(0, 2)) return 1;
  if (used == 3 && constant(2)) used = constant(1) ? 1 : 2;
  return used;
}

Texture first_channels(const Texture& texture, int channels) {
  Texture kept = make_texture(texture.extents, channels);
  for (SliceIndex s = 0; s < texture.extents.num_slices(); ++s)
    std::copy_n(texture.slice(s), kept.floats_per_slice(), kept.slice(s));
  return kept;
}

void check_part(const std::string& path, const ImageShape& shape, const ImageShape& first, int height) {
  if (shape.width != first.width || shape.channels != first.channels || shape.type != first.type ||
      shape.height < height)
    throw UserError(path, fmt::format("{}, {} channels, {}; the images before have {}, {} channels, {}", size_of(shape),
                                      shape.channels, to_string(shape.type), size_of(first), first.channels,
                                      to_string(first.type)));
}

}  // namespace

TextureFile images(const std::string& path, const std::optional<RunConfig>& config) {
  TextureFile file;
  file.config = config;
  Extents extents = config ? config->problem.extents : Extents();
  const Arrangement arrangement = arrange(path, config, extents, file.notes);
  const ImageShape first = ImageReader(arrangement.files.front()).shape(0);
  const int height = narrow<int>(extents.height());
  if (first.width != extents.width() || (arrangement.files.size() > 1 && first.height != height))
    size_differs(arrangement.files.front(), size_of(first), *config);
  const int channels = channels_to_take(arrangement.files.front(), first, config);
  const ValueRange range = stored_range(config);
  const SliceDecoder decode(first);
  const std::size_t cells = static_cast<std::size_t>(extents.cells_per_slice());
  file.texture = make_texture(extents, channels);
  ImageShape one_slice = first;
  one_slice.height = height;
  std::vector<std::byte> bytes(one_slice.num_bytes());
  std::optional<ImageReader> reader;
  std::size_t opened = arrangement.files.size();
  for (std::size_t s = 0; s < arrangement.slices.size(); ++s) {
    const Place& place = arrangement.slices[s];
    if (place.file != opened) reader.emplace(arrangement.files[place.file]);
    opened = place.file;
    check_part(arrangement.files[opened], reader->shape(place.part), first, height);
    reader->read_rows(place.part, place.row, height, bytes);
    float* const slice = file.texture.slice(static_cast<SliceIndex>(s));
    for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c)
      for (std::size_t cell = 0; cell < cells; ++cell) {
        const double stored = decode(bytes, cell * static_cast<std::size_t>(first.channels) + c);
        slice[c * cells + cell] =
            static_cast<float>(first.type == PixelType::float32 ? stored : from_unit(range, stored));
      }
  }
  file.source = fmt::format("{}, {}", arrangement.kind, to_string(first.type));
  if (first.type == PixelType::float32) decode_floats(file);
  if (!config) {
    const int used = channels_in_use(file.texture);
    if (used < channels) file.texture = first_channels(file.texture, used);
  }
  return file;
}

}  // namespace noiseloom::loaders
