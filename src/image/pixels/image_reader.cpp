#include "noiseloom/image/image_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include "image/pixels/image_claim.h"
#include "image/pixels/image_library.h"
#include "image/pixels/texture_header.h"
#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

struct Extension {
  const char* text;
  const char* why_not;  // empty: is read
};

constexpr const char* lossy = "lossy: it changes noise";
constexpr const char* not_yet = "not read by this version; convert it to .png or .exr";

constexpr std::array<Extension, 24> known_extensions = {{
    {".png", ""},     {".exr", ""},      {".tif", ""},      {".tiff", ""},     {".tx", ""},       {".hdr", ""},
    {".ktx2", ""},    {".dds", ""},      {".bmp", ""},      {".tga", ""},      {".pgm", ""},      {".ppm", ""},
    {".pnm", ""},     {".jpg", lossy},   {".jpeg", lossy},  {".jxl", lossy},   {".avif", lossy},  {".heic", lossy},
    {".webp", lossy}, {".gif", not_yet}, {".ktx", not_yet}, {".psd", not_yet}, {".jp2", not_yet}, {".pfm", not_yet},
}};

const Extension* known_extension(const std::string& extension) {
  const auto found = std::find_if(known_extensions.begin(), known_extensions.end(),
                                  [&](const Extension& known) { return extension == known.text; });
  return found == known_extensions.end() ? nullptr : &*found;
}

// No lossless format packs more than about 1100 bytes of an image into one of its file (deflate: 1032); an image of a
// million pixels may claim what it likes.
constexpr std::int64_t most_pixels_per_byte = 1100;
constexpr std::int64_t pixels_of_any_file = std::int64_t{1} << 20;
constexpr std::int64_t most_bytes_per_pixel = 64;  // of what is decoded
constexpr std::int64_t megabyte = std::int64_t{1} << 20;

// Claim and size of the file, checked against each other.
struct Checked {
  ImageClaim claim;
  std::int64_t most_pixels = 0;
};

Checked checked_claim(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) throw UserError(path, "no such file");
  if (!fs::is_regular_file(status)) throw UserError(path, "a folder or device, not an image file");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw EnvironmentError(path + ": cannot be read: " + std::strerror(errno));
  const auto size = static_cast<std::int64_t>(fs::file_size(path));
  const std::string extension = lower_case_extension(path);
  Checked checked{read_image_claim(file, extension), pixels_of_any_file + most_pixels_per_byte * size};
  const ImageClaim& claim = checked.claim;
  if (claim.format.empty()) {
    const std::string why = why_not_read(extension);
    throw UserError(path, fmt::format("not an image that can be read{}; accepted: {}",
                                      why.empty() ? "" : fmt::format(" ({}: {})", extension, why), image_extensions()));
  }
  if (!claim.unreadable.empty()) throw UserError(path, claim.unreadable);
  if (claim.width < 1 || claim.height < 1)
    throw UserError(
        path, fmt::format("not an image that can be read: its header says {} x {} pixels", claim.width, claim.height));
  if (claim.width > checked.most_pixels / claim.height || claim.least_bytes > size)
    throw UserError(path, fmt::format("its header says {} x {} pixels, but a file of {} bytes cannot hold so many",
                                      claim.width, claim.height, size));
  return checked;
}

void check_part(const std::string& path, const ImagePart& part, std::int64_t most_bytes) {
  const ImageShape& shape = part.shape;
  if (!part.other_type.empty())
    throw UserError(path,
                    fmt::format("numbers of type {}; accepted: 8 and 16 bit unsigned, half, float", part.other_type));
  if (!part.flat) throw UserError(path, "a volume image; accepted: flat images, one a slice");
  if (part.deep) throw UserError(path, "a deep image; accepted: flat images with one value a channel");
  if (shape.width < 1 || shape.height < 1 || shape.channels < 1)
    throw UserError(path, fmt::format("not an image that can be read: {} x {} pixels, {} channels", shape.width,
                                      shape.height, shape.channels));
  const double tile = static_cast<double>(part.tile_width) * part.tile_height * shape.channels;
  const double pixels = static_cast<double>(shape.width) * shape.height * shape.channels;
  if (std::max(tile, pixels) * static_cast<double>(bytes_per_number(shape.type)) > static_cast<double>(most_bytes))
    throw UserError(path, fmt::format("its header says {} x {} pixels with {} channels in tiles of {} x {}, but a file "
                                      "of its size cannot hold so many",
                                      shape.width, shape.height, shape.channels, part.tile_width, part.tile_height));
}

std::string window_of(const ImagePart& part) {
  const ImageShape& shape = part.shape;
  if (part.x == part.full_x && part.y == part.full_y && shape.width == part.full_width &&
      shape.height == part.full_height)
    return "";
  return fmt::format("data window {} x {} at {}, {} in a display window of {} x {} at {}, {}", shape.width,
                     shape.height, part.x, part.y, part.full_width, part.full_height, part.full_x, part.full_y);
}

}  // namespace

struct ImageReader::Impl {
  std::string path;
  std::unique_ptr<ImageInput> input;
  std::vector<ImageShape> shapes;
  std::vector<std::string> windows;
  // Tiles cross rows: a tiled part is read whole, at its first row.
  std::vector<bool> tiled;
  bool is_srgb = false;
  std::vector<std::pair<std::string, std::string>> facts;
  int whole_part = -1;
  std::vector<std::byte> whole;

  [[noreturn]] void fail() { throw UserError(path, "cannot read the pixels: " + words_of(input->error())); }
  void read_whole(int part) {
    if (whole_part == part) return;
    const ImageShape& shape = shapes[static_cast<std::size_t>(part)];
    whole.assign(shape.num_bytes(), std::byte{});
    if (!input->seek(part) || !input->read_all(shape.type, whole.data())) fail();
    whole_part = part;
  }
};

ImageReader::ImageReader(const std::string& path) : impl_(std::make_unique<Impl>()) {
  const Checked checked = checked_claim(path);
  const std::int64_t most_bytes = checked.most_pixels * most_bytes_per_pixel;
  impl_->path = path;
  impl_->input = texture_input(checked.claim.format);
  if (!impl_->input) {
    const ImageLibrary& library = image_library();
    library.limit_image_size(static_cast<int>(std::min<std::int64_t>(most_bytes / megabyte + 1, 1 << 30)));
    impl_->input = library.input(checked.claim.format);
    if (!impl_->input) throw EnvironmentError(path + ": " + words_of(library.error()));
  }
  if (!impl_->input->open(path))
    throw UserError(path, "not an image that can be read: " + words_of(impl_->input->error()));
  constexpr int most_parts = 1 << 16;
  for (int part = 0; part < most_parts && impl_->input->seek(part); ++part) {
    const ImagePart found = impl_->input->part();
    check_part(path, found, most_bytes);
    impl_->shapes.push_back(found.shape);
    impl_->windows.push_back(window_of(found));
    impl_->tiled.push_back(found.tile_width > 0);
    if (part == 0) impl_->facts = found.facts;
    impl_->is_srgb = impl_->is_srgb || found.is_srgb;
  }
  impl_->input->error();  // seeking past the last part is no fault
  if (impl_->shapes.empty()) throw UserError(path, "not an image that can be read: it has no pixels");
}
ImageReader::~ImageReader() = default;
ImageReader::ImageReader(ImageReader&&) noexcept = default;

int ImageReader::num_parts() const { return static_cast<int>(impl_->shapes.size()); }
const ImageShape& ImageReader::shape(int part) const { return impl_->shapes.at(static_cast<std::size_t>(part)); }
const std::string& ImageReader::window(int part) const { return impl_->windows.at(static_cast<std::size_t>(part)); }

bool ImageReader::is_srgb() const { return impl_->is_srgb; }
const std::vector<std::pair<std::string, std::string>>& ImageReader::facts() const { return impl_->facts; }

void ImageReader::read_rows(int part, int first_row, int num_rows, std::span<std::byte> bytes) {
  const ImageShape& image = shape(part);
  NOISELOOM_CHECK_LE(first_row + num_rows, image.height);
  NOISELOOM_CHECK_EQ(bytes.size() * static_cast<std::size_t>(image.height),
                     image.num_bytes() * static_cast<std::size_t>(num_rows));
  if (impl_->tiled[static_cast<std::size_t>(part)]) {
    impl_->read_whole(part);
    const std::size_t row_bytes = image.num_bytes() / static_cast<std::size_t>(image.height);
    std::memcpy(bytes.data(), impl_->whole.data() + static_cast<std::size_t>(first_row) * row_bytes, bytes.size());
    return;
  }
  if (!impl_->input->seek(part) || !impl_->input->read_rows(first_row, first_row + num_rows, image.type, bytes.data()))
    impl_->fail();
}

std::string lower_case_extension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool has_image_extension(const std::string& path) {
  const Extension* const known = known_extension(lower_case_extension(path));
  return known != nullptr && *known->why_not == '\0';
}

std::string image_extensions() {
  std::string list;
  for (const Extension& known : known_extensions)
    if (*known.why_not == '\0') list += (list.empty() ? "" : ", ") + std::string(known.text);
  return list;
}

std::string why_not_read(const std::string& extension) {
  const Extension* const known = known_extension(extension);
  return known == nullptr ? "" : known->why_not;
}

}  // namespace noiseloom
