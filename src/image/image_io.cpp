#include "noiseloom/image/image_io.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "noiseloom/image/image_reader.h"

namespace noiseloom {
namespace {

OIIO::TypeDesc oiio_type(PixelType type) {
  switch (type) {
    case PixelType::uint8:
      return OIIO::TypeDesc::UINT8;
    case PixelType::uint16:
      return OIIO::TypeDesc::UINT16;
    case PixelType::float32:
      return OIIO::TypeDesc::FLOAT;
  }
  return OIIO::TypeDesc::FLOAT;
}

OIIO::ImageSpec oiio_spec(const ImageJob& job, int height, int block) {
  const ImageShape& shape = job.block;
  OIIO::ImageSpec spec(shape.width, height, shape.channels, oiio_type(shape.type));
  if (!shape.channel_names.empty()) spec.channelnames = shape.channel_names;
  spec.alpha_channel = shape.alpha;
  spec.attribute("oiio:UnassociatedAlpha", 1);  // else colours are divided by alpha
  spec.attribute("ImageDescription", job.description);
  spec.attribute("Software", "noiseloom");
  spec.attribute("DateTime", "1970:01:01 00:00:00");  // else the time of writing: equal textures are equal files
  // Noise does not compress, and plain files are read by the smallest of readers.
  if (job.format == ImageFormat::exr || job.format == ImageFormat::tiff) spec.attribute("compression", "none");
  if (job.stacking == Stacking::parts)
    spec.attribute("oiio:subimagename", job.part_names.at(static_cast<std::size_t>(block)));
  return spec;
}

[[noreturn]] void write_failed(const std::string& path, const std::string& words) {
  throw EnvironmentError(fmt::format("{}: cannot write the image: {}", path, words));
}

std::string words_of(const std::string& library_error) {
  return library_error.empty() ? "the image library gave no reason" : library_error;
}

void write_blocks(const std::string& path, const ImageJob& job, const BlockBytes& blocks) {
  auto out = OIIO::ImageOutput::create(path);
  if (!out) write_failed(path, words_of(OIIO::geterror()));
  const OIIO::TypeDesc type = oiio_type(job.block.type);
  const int rows = job.block.height;
  if (job.stacking == Stacking::parts) {
    std::vector<OIIO::ImageSpec> specs;
    for (int b = 0; b < job.num_blocks; ++b) specs.push_back(oiio_spec(job, rows, b));
    if (!out->open(path, job.num_blocks, specs.data())) write_failed(path, words_of(out->geterror()));
    for (int b = 0; b < job.num_blocks; ++b) {
      if (b > 0 && !out->open(path, specs[static_cast<std::size_t>(b)], OIIO::ImageOutput::AppendSubimage))
        write_failed(path, words_of(out->geterror()));
      if (!out->write_image(type, blocks(b).data())) write_failed(path, words_of(out->geterror()));
    }
  } else {
    if (!out->open(path, oiio_spec(job, rows * job.num_blocks, 0))) write_failed(path, words_of(out->geterror()));
    for (int b = 0; b < job.num_blocks; ++b)
      if (!out->write_scanlines(b * rows, (b + 1) * rows, 0, type, blocks(b).data()))
        write_failed(path, words_of(out->geterror()));
  }
  if (!out->close()) write_failed(path, words_of(out->geterror()));
}

void compare_with_file(const std::string& path, const ImageJob& job, const BlockBytes& blocks) {
  ImageReader reader(path);
  const ImageShape& block = job.block;
  const bool parts = job.stacking == Stacking::parts;
  const ImageShape& found = reader.shape(0);
  const int height = parts ? block.height : block.height * job.num_blocks;
  if (found.width != block.width || found.height != height || found.channels != block.channels ||
      (parts && reader.num_parts() != job.num_blocks))
    write_failed(path, "reading it back gave another size");
  std::vector<std::byte> bytes(block.num_bytes());
  for (int b = 0; b < job.num_blocks; ++b) {
    reader.read_rows(parts ? b : 0, parts ? 0 : b * block.height, block.height, bytes);
    if (job.format == ImageFormat::hdr) continue;
    const std::span<const std::byte> expected = blocks(b);
    if (std::memcmp(bytes.data(), expected.data(), bytes.size()) != 0)
      write_failed(path, "reading it back gave other values");
  }
}

}  // namespace

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

void use_one_image_thread() {
  OIIO::attribute("threads", 1);
  OIIO::attribute("exr_threads", -1);
}

void write_image(const std::string& path, const ImageJob& job, const BlockBytes& blocks) {
  use_one_image_thread();
  write_blocks(path, job, blocks);
  try {
    compare_with_file(path, job, blocks);
  } catch (const UserError& error) {
    write_failed(path, fmt::format("reading it back failed; is the disk full? ({})", error.what()));
  }
}

}  // namespace noiseloom
