// Images to textures. An arrangement says where each slice lies (file, part, row, column); it is found and checked
// before a pixel is read.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <filesystem>

#include "image/loaders/texture_loaders.h"
#include "noiseloom/image/image_reader.h"
#include "noiseloom/image/sequence.h"

namespace noiseloom::loaders {
namespace {

struct Place {
  std::size_t file = 0;
  int part = 0;
  int row = 0;
  int column = 0;
};

struct Arrangement {
  std::vector<std::string> files;
  std::vector<Place> slices;
  std::string kind;  // "64 images", "a strip of 64 slices", "64 parts", "one image"
};

// What --layout says.
struct Layout {
  enum class Kind { found, image, strip, row, atlas, atlas_down };
  Kind kind = Kind::found;
  int columns = 1;  // of an atlas
  int rows = 1;
};

constexpr int most_columns = 65536;  // and rows

Layout parse_layout(const std::string& text) {
  if (text.empty()) return {};
  if (text == "image") return {Layout::Kind::image};
  if (text == "strip") return {Layout::Kind::strip};
  if (text == "row") return {Layout::Kind::row};
  const std::size_t colon = text.find(':');
  const std::string word = text.substr(0, colon);
  Layout layout{word == "atlas-down" ? Layout::Kind::atlas_down : Layout::Kind::atlas};
  const char* const last = text.data() + text.size();
  const auto [times, error] = std::from_chars(text.data() + std::min(colon, text.size() - 1) + 1, last, layout.columns);
  const auto [end, second_error] = times == last ? std::from_chars_result{last, std::errc::invalid_argument}
                                                 : std::from_chars(times + 1, last, layout.rows);
  if ((word != "atlas" && word != "atlas-down") || error != std::errc{} || second_error != std::errc{} || end != last ||
      *times != 'x' || layout.columns < 1 || layout.rows < 1 || layout.columns > most_columns ||
      layout.rows > most_columns)
    throw UserError("command line", fmt::format("--layout {}: accepted: image, strip (downward), row (to the right), "
                                                "atlas:CxR (C columns, R rows; atlas-down:CxR counts downward first)",
                                                text));
  return layout;
}

std::string size_of(const ImageShape& shape) { return fmt::format("{} x {} pixels", shape.width, shape.height); }

[[noreturn]] void size_differs(const std::string& path, const std::string& found, const Extents& extents,
                               const std::string& window = "", const std::string& hint = "") {
  throw UserError(
      path, fmt::format("{}, but the config says {}{}{}", found, expected_size(extents),
                        window.empty() ? "" : fmt::format(" ({}; only the former is in the file)", window), hint));
}

// Slices of one file, counted to the right and then down, or (atlas_down) down and then to the right.
void place_grid(Arrangement& arrangement, const Extents& extents, int columns, int rows, bool down) {
  const int width = narrow<int>(extents.width());
  const int height = narrow<int>(extents.height());
  for (int s = 0; s < extents.num_slices(); ++s) {
    const int column = down ? s / rows : s % columns;
    const int row = down ? s % rows : s / columns;
    arrangement.slices.push_back({0, 0, row * height, column * width});
  }
}

std::string grid_kind(int columns, int rows, std::int32_t slices) {
  if (columns * rows == 1) return "one image";
  if (columns == 1) return fmt::format("a strip of {} slices", slices);
  if (rows == 1) return fmt::format("a row of {} slices", slices);
  return fmt::format("an atlas of {} x {} slices", columns, rows);
}

Arrangement arrange_parts(const std::string& path, const ImageReader& reader, const Extents& extents) {
  const ImageShape& shape = reader.shape(0);
  Arrangement arrangement{{path}, {}, fmt::format("{} parts of one image", reader.num_parts())};
  if (reader.num_parts() != extents.num_slices() || shape.width != extents.width() || shape.height != extents.height())
    size_differs(path, fmt::format("{} parts of {}", reader.num_parts(), size_of(shape)), extents, reader.window(0));
  for (int part = 0; part < reader.num_parts(); ++part) arrangement.slices.push_back({0, part, 0, 0});
  return arrangement;
}

// One file: a single slice, a strip, a row, an atlas or several parts.
Arrangement arrange_one(const std::string& path, const ImageReader& reader, const Extents& extents,
                        const Layout& layout, std::vector<std::string>& notes) {
  if (reader.num_parts() > 1) return arrange_parts(path, reader, extents);
  const ImageShape& shape = reader.shape(0);
  const std::int64_t columns = shape.width / extents.width();
  const std::int64_t rows = shape.height / extents.height();
  const std::int32_t slices = extents.num_slices();
  const bool whole = columns * extents.width() == shape.width && rows * extents.height() == shape.height;
  const bool is_atlas = layout.kind == Layout::Kind::atlas || layout.kind == Layout::Kind::atlas_down;
  const bool fits = whole &&
                    (is_atlas ? columns == layout.columns && rows == layout.rows && columns * rows >= slices
                              : columns * rows == slices) &&
                    (layout.kind != Layout::Kind::image || slices == 1) &&
                    (layout.kind != Layout::Kind::strip || columns == 1) &&
                    (layout.kind != Layout::Kind::row || rows == 1);
  // Cells may be left over at the end, which only its maker knows.
  const std::string hint =
      whole && slices > 1 && columns * rows > slices && columns <= most_columns && rows <= most_columns
          ? fmt::format("; if it is an atlas of which the first {} of {} cells are used: --layout atlas:{}x{}", slices,
                        columns * rows, columns, rows)
          : "";
  if (!fits) size_differs(path, size_of(shape), extents, reader.window(0), hint);
  Arrangement arrangement{{path}, {}, grid_kind(narrow<int>(columns), narrow<int>(rows), slices)};
  if (layout.kind == Layout::Kind::found && columns > 1 && rows > 1)
    notes.push_back(
        fmt::format("The slices of the atlas were counted from left to right, then down (atlas:{}x{}); "
                    "--layout atlas-down:{}x{} counts downward first.",
                    columns, rows, columns, rows));
  place_grid(arrangement, extents, narrow<int>(columns), narrow<int>(rows), layout.kind == Layout::Kind::atlas_down);
  return arrangement;
}

Arrangement arrange_many(const std::string& path, std::vector<std::string> files, const Extents& extents) {
  if (std::cmp_not_equal(files.size(), extents.num_slices()))
    size_differs(path, fmt::format("{} image{}", files.size(), files.size() == 1 ? "" : "s"), extents);
  const ImageReader first(files.front());
  const ImageShape& shape = first.shape(0);
  if (shape.width != extents.width() || shape.height != extents.height() || first.num_parts() > 1)
    size_differs(files.front(), size_of(shape), extents, first.window(0));
  Arrangement arrangement{std::move(files), {}, ""};
  for (std::size_t f = 0; f < arrangement.files.size(); ++f) arrangement.slices.push_back({f, 0, 0, 0});
  arrangement.kind = fmt::format("{} images", arrangement.files.size());
  return arrangement;
}

// The sequence that begins at `path` and has the slices of the config; UserError naming those that begin there.
std::vector<std::string> sequence_for(const std::string& path, const Extents& extents,
                                      std::vector<std::string>& notes) {
  const std::size_t wanted = static_cast<std::size_t>(extents.num_slices());
  const std::vector<Sequence> sequences = sequences_from_first(path);
  std::vector<const Sequence*> exact;
  std::vector<const Sequence*> longer;
  std::string found;
  for (const Sequence& sequence : sequences) {
    if (sequence.files.size() == wanted) exact.push_back(&sequence);
    if (sequence.files.size() > wanted) longer.push_back(&sequence);
    if (!sequence.pattern.empty())
      found += fmt::format("{}{} as {}{}", found.empty() ? "" : ", ",
                           fmt::format("{} image{}", sequence.files.size(), sequence.files.size() == 1 ? "" : "s"),
                           sequence.pattern, sequence.gap.empty() ? "" : fmt::format(" ({})", sequence.gap));
  }
  if (exact.size() + longer.size() > 1 && exact.size() != 1)
    throw UserError(path, fmt::format("begins more than one sequence: {}; give one of these patterns", found));
  if (exact.size() == 1) return exact.front()->files;
  if (longer.empty())
    size_differs(path, found.empty() ? "one image" : "the numbered images from here on are " + found, extents);
  std::vector<std::string> files = longer.front()->files;
  files.resize(wanted);
  notes.push_back(fmt::format("More numbered images follow than the config's {} slices; they were left out.", wanted));
  return files;
}

Arrangement arrange(const Request& request, const Extents& extents, std::vector<std::string>& notes) {
  const std::string& path = request.path;
  const Layout layout = parse_layout(request.reading.layout);
  const bool many = std::filesystem::is_directory(path) || !std::filesystem::exists(path);
  std::vector<std::string> files = many ? find_sequence(path) : std::vector<std::string>{path};
  const ImageReader reader(files.front());
  const ImageShape& shape = reader.shape(0);
  const bool one_slice = shape.width == extents.width() && shape.height == extents.height() && reader.num_parts() == 1;
  if (!many && extents.num_slices() > 1 && one_slice && layout.kind == Layout::Kind::found)
    files = sequence_for(path, extents, notes);
  return files.size() == 1 ? arrange_one(files.front(), reader, extents, layout, notes)
                           : arrange_many(path, std::move(files), extents);
}

// What is wrong with the size that images say of themselves: they may have been cropped since.
std::optional<UserError> misfit_of_own_size(const std::string& path, const OwnFacts& own) {
  Request request{path, own.config, {}};
  request.reading.layout = reading_of_layout(own.layout);
  std::vector<std::string> notes;
  try {
    arrange(request, own.config.problem.extents, notes);
  } catch (const UserError& error) {
    return error;
  }
  return std::nullopt;
}

// Stored numbers as 0..1 (integers) or as they are (floats).
double number_of(std::span<const std::byte> bytes, PixelType type, std::size_t index) {
  switch (type) {
    case PixelType::uint8:
      return dequantise(std::to_integer<std::uint8_t>(bytes[index]), 8);
    case PixelType::uint16: {
      std::uint16_t b;
      std::memcpy(&b, bytes.data() + 2 * index, sizeof b);
      return dequantise(b, 16);
    }
    case PixelType::uint32: {
      std::uint32_t b;
      std::memcpy(&b, bytes.data() + 4 * index, sizeof b);
      return (b + 0.5) / 0x1p32;
    }
    case PixelType::float16: {
      std::uint16_t bits;
      std::memcpy(&bits, bytes.data() + 2 * index, sizeof bits);
      return half_to_double(bits);
    }
    case PixelType::float32: {
      float v;
      std::memcpy(&v, bytes.data() + 4 * index, sizeof v);
      return static_cast<double>(v);
    }
  }
  return 0;
}

void check_mate(const std::string& path, const ImageShape& shape, const ImageShape& first) {
  if (shape.width != first.width || shape.height != first.height || shape.channels != first.channels ||
      shape.type != first.type)
    throw UserError(path, fmt::format("{}, {} channels, {}; the images before have {}, {} channels, {}", size_of(shape),
                                      shape.channels, to_string(shape.type), size_of(first), first.channels,
                                      to_string(first.type)));
}

// Numbers of the file: 8 bits of a mantissa that three channels share.
double step_of(const std::string& path, PixelType type) {
  if (type == PixelType::uint8) return 1.0 / 256;
  if (type == PixelType::uint16) return 1.0 / 65536;
  if (type == PixelType::float16) return 1.0 / 1024;  // between numbers of 1 to 2
  return lower_case_extension(path) == ".hdr" ? 1.0 / 128 : 0;
}

// The rows of one band of slices, read once for all slices beside each other.
class BandReader {
 public:
  BandReader(const std::vector<std::string>& files, int height) : files_(files), height_(height) {}

  const std::vector<std::byte>& band(const Place& place) {
    if (open_ && place.file == file_ && place.part == part_ && place.row == row_) return bytes_;
    if (!open_ || place.file != file_) reader_.emplace(files_[place.file]);
    const ImageShape& shape = reader_->shape(place.part);
    if (!open_) first_ = shape;
    check_mate(files_[place.file], shape, first_);
    bytes_.resize(shape.num_bytes() / static_cast<std::size_t>(shape.height) * static_cast<std::size_t>(height_));
    reader_->read_rows(place.part, place.row, height_, bytes_);
    open_ = true;
    file_ = place.file;
    part_ = place.part;
    row_ = place.row;
    return bytes_;
  }

 private:
  const std::vector<std::string>& files_;
  int height_;
  std::optional<ImageReader> reader_;
  ImageShape first_;
  bool open_ = false;
  std::size_t file_ = 0;
  int part_ = 0;
  int row_ = 0;
  std::vector<std::byte> bytes_;
};

void read_slices(const Arrangement& arrangement, const ImageShape& shape, Texture& texture) {
  const std::size_t width = static_cast<std::size_t>(texture.extents.width());
  const std::size_t height = static_cast<std::size_t>(texture.extents.height());
  const std::size_t channels = static_cast<std::size_t>(shape.channels);
  BandReader bands(arrangement.files, static_cast<int>(height));
  for (std::size_t s = 0; s < arrangement.slices.size(); ++s) {
    const Place& place = arrangement.slices[s];
    const std::vector<std::byte>& band = bands.band(place);
    float* out = texture.slice(SliceIndex(s));
    for (std::size_t c = 0; c < channels; ++c)
      for (std::size_t y = 0; y < height; ++y) {
        const std::size_t row = y * static_cast<std::size_t>(shape.width) + static_cast<std::size_t>(place.column);
        for (std::size_t x = 0; x < width; ++x)
          *out++ = static_cast<float>(number_of(band, shape.type, (row + x) * channels + c));
      }
  }
}

std::vector<std::string> names_of(const ImageShape& shape) {
  std::vector<std::string> names = shape.channel_names;
  for (std::size_t c = names.size(); c < static_cast<std::size_t>(shape.channels); ++c)
    names.push_back(std::to_string(c));
  names.resize(static_cast<std::size_t>(shape.channels));
  return names;
}

}  // namespace

// As many slices as there are files or parts, else squares in a strip.
Extents suggested_image_extents(const std::string& path, const TextureReading& reading,
                                std::vector<std::string>& notes) {
  if (reading.layout.empty())
    if (const auto own = own_facts_of_images(path); own && !misfit_of_own_size(path, *own))
      return own->config.problem.extents;
  const Layout layout = parse_layout(reading.layout);
  const bool many = std::filesystem::is_directory(path) || !std::filesystem::exists(path);
  const std::vector<std::string> files = many ? find_sequence(path) : std::vector<std::string>{path};
  const ImageReader reader(files.front());
  const ImageShape& shape = reader.shape(0);
  const std::int64_t width = shape.width;
  const std::int64_t height = shape.height;
  const std::int64_t count = static_cast<std::int64_t>(files.size()) * reader.num_parts();
  const auto extents = [](std::int64_t x, std::int64_t y, std::int64_t slices) {
    return slices == 1 ? Extents({x, y}) : Extents({x, y, slices});
  };
  if (count > 1 || layout.kind == Layout::Kind::image) return extents(width, height, count);
  if (layout.kind == Layout::Kind::atlas || layout.kind == Layout::Kind::atlas_down) {
    if (width % layout.columns != 0 || height % layout.rows != 0)
      throw UserError(path, fmt::format("{} cannot be divided by --layout {}", size_of(shape), reading.layout));
    return extents(width / layout.columns, height / layout.rows, std::int64_t{layout.columns} * layout.rows);
  }
  const bool is_strip = height % width == 0 && layout.kind != Layout::Kind::row;
  const bool is_row = width % height == 0 && layout.kind != Layout::Kind::strip;
  if ((layout.kind == Layout::Kind::strip && !is_strip) || (layout.kind == Layout::Kind::row && !is_row))
    throw UserError(path,
                    fmt::format("{} is no --layout {} of squares; give the size: --set \"texture.size={{ x = .., y "
                                "= .., t = .. }}\"",
                                size_of(shape), reading.layout));
  if (is_row && width > height && layout.kind == Layout::Kind::found)
    throw UserError(path, fmt::format("{} fit two readings: one image (--layout image), or {} slices of {} x {} beside "
                                      "each other (--layout row)",
                                      size_of(shape), width / height, height, height));
  if (is_strip && height > width) {
    notes.push_back(
        fmt::format("The image was taken as a strip of {} slices of {} x {}.", height / width, width, width));
    return extents(width, width, height / width);
  }
  return is_row && width > height ? extents(height, height, width / height) : extents(width, height, 1);
}

Stored images(const Request& given) {
  Stored stored;
  Request request = given;
  std::optional<OwnFacts> own;
  try {
    own = own_facts_of_images(given.path);
  } catch (const UserError&) {
    if (!given.config) throw;  // whoever gives one need not care what the file says
  }
  if (own && !given.config && given.reading.layout.empty()) {
    if (const auto misfit = misfit_of_own_size(given.path, *own)) {
      std::vector<Fault> faults = misfit->faults();
      faults.back().text += "; the config is that in the file, which was cropped or put together anew since";
      if (!given.any_size) throw UserError(std::move(faults));
      stored.notes.push_back(fmt::format(
          "The size is not that of the run which the file names ({}): the file was cropped or put together anew since. "
          "What it says of itself was not believed.",
          expected_size(own->config.problem.extents)));
      own.reset();
    }
  }
  if (own && given.reading.layout.empty()) request.reading.layout = reading_of_layout(own->layout);
  if (own && !given.config && given.reading.layout.empty()) {
    stored.config = request.config = own->config;
    stored.notes.push_back("Size, samples and filter are those of the run that the file names.");
  }
  const Extents extents = request.config ? request.config->problem.extents
                                         : suggested_image_extents(request.path, request.reading, stored.notes);
  const Arrangement arrangement = arrange(request, extents, stored.notes);
  const ImageReader first(arrangement.files.front());
  const ImageShape shape = first.shape(0);
  if (!first.window(0).empty())
    stored.notes.push_back(fmt::format("The image has a {}; the data window was taken.", first.window(0)));
  stored.is_srgb = first.is_srgb();
  if (stored.is_srgb)
    stored.notes.push_back("The file is marked as sRGB, by which a sampler bends every value; it was read as it is.");
  stored.texture = make_texture(extents, shape.channels);
  read_slices(arrangement, shape, stored.texture);
  stored.channel_names = names_of(shape);
  stored.step = step_of(arrangement.files.front(), shape.type);
  stored.coding = is_integer(shape.type) ? Stored::Coding::codes : Stored::Coding::open;
  if (own && request.config && (stored.config || !natural_range(request.config->problem.samples))) {
    stored.range = own->range;
    if (!is_integer(shape.type)) stored.coding = own->range ? Stored::Coding::codes : Stored::Coding::values;
  }
  stored.source = fmt::format("{}, {}", arrangement.kind, to_string(shape.type));
  return stored;
}

}  // namespace noiseloom::loaders
