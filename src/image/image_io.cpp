#include "noiseloom/image/image_io.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "image/image_library.h"

namespace noiseloom {

std::size_t bytes_per_number(PixelType type) {
  return type == PixelType::uint8 ? 1 : type == PixelType::uint16 ? 2 : 4;
}

std::string to_string(PixelType type) {
  return type == PixelType::uint8 ? "8 bit" : type == PixelType::uint16 ? "16 bit" : "float";
}

std::size_t ImageShape::num_bytes() const {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * static_cast<std::size_t>(channels) *
         bytes_per_number(type);
}

struct ImageReader::Impl {
  std::string path;
  std::unique_ptr<OIIO::ImageInput> input;
  std::vector<ImageShape> shapes;
};

namespace {

ImageShape shape_of(const std::string& path, const OIIO::ImageSpec& spec) {
  ImageShape shape{spec.width, spec.height, spec.nchannels, PixelType::uint8, spec.channelnames, spec.alpha_channel};
  if (spec.format == OIIO::TypeDesc::UINT8) {
    shape.type = PixelType::uint8;
  } else if (spec.format == OIIO::TypeDesc::UINT16) {
    shape.type = PixelType::uint16;
  } else if (spec.format == OIIO::TypeDesc::FLOAT || spec.format == OIIO::TypeDesc::HALF) {
    shape.type = PixelType::float32;
  } else {
    throw UserError(
        path, fmt::format("numbers of type {}; accepted: 8 and 16 bit unsigned, half, float", spec.format.c_str()));
  }
  if (spec.depth > 1) throw UserError(path, "a volume image; accepted: flat images, one a slice");
  return shape;
}

}  // namespace

ImageReader::ImageReader(const std::string& path) : impl_(std::make_unique<Impl>()) {
  if (!std::filesystem::exists(path)) throw UserError(path, "no such file");
  impl_->path = path;
  OIIO::ImageSpec hints;
  hints.attribute("oiio:UnassociatedAlpha", 1);  // else colours are multiplied by alpha
  hints.attribute("oiio:RawColor", 1);
  impl_->input = OIIO::ImageInput::open(path, &hints);
  if (!impl_->input) throw UserError(path, "not an image that can be read: " + words_of(OIIO::geterror()));
  for (int part = 0; impl_->input->seek_subimage(part, 0); ++part)
    impl_->shapes.push_back(shape_of(path, impl_->input->spec()));
  impl_->input->geterror();  // seeking past the last part is no fault
}
ImageReader::~ImageReader() = default;
ImageReader::ImageReader(ImageReader&&) noexcept = default;

int ImageReader::num_parts() const { return static_cast<int>(impl_->shapes.size()); }
const ImageShape& ImageReader::shape(int part) const { return impl_->shapes.at(static_cast<std::size_t>(part)); }

void ImageReader::read_rows(int part, int first_row, int num_rows, std::span<std::byte> bytes) {
  const ImageShape& whole = shape(part);
  NOISELOOM_CHECK_EQ(bytes.size() * static_cast<std::size_t>(whole.height),
                     whole.num_bytes() * static_cast<std::size_t>(num_rows));
  const bool done = impl_->input->read_scanlines(part, 0, first_row, first_row + num_rows, 0, 0, whole.channels,
                                                 oiio_type(whole.type), bytes.data());
  if (!done) throw UserError(impl_->path, "cannot read the pixels: " + words_of(impl_->input->geterror()));
}

bool has_image_extension(const std::string& path) {
  static const std::vector<std::string> known = {".png", ".exr", ".tif", ".tiff", ".hdr",
                                                 ".bmp", ".tga", ".pgm", ".ppm"};
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(known.begin(), known.end(), extension) != known.end();
}

}  // namespace noiseloom
