#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include "image/image_library.h"
#include "noiseloom/core/error.h"
#include "noiseloom/files/digest.h"
#include "noiseloom/image/image_io.h"
#include "noiseloom/image/image_reader.h"

namespace noiseloom {
namespace {

// The library finds the format by its name; the ending of the file may be anything (a temporary name, ".PNG").
const char* library_name(ImageFormat format) {
  switch (format) {
    case ImageFormat::png:
      return "png";
    case ImageFormat::tiff:
      return "tiff";
    case ImageFormat::exr:
      return "openexr";
    case ImageFormat::hdr:
      return "hdr";
  }
  return "";
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

}  // namespace

struct ImageWriter::Impl {
  std::string path;
  ImageJob job;
  std::unique_ptr<OIIO::ImageOutput> output;
  std::vector<OIIO::ImageSpec> parts;  // Stacking::parts
  std::vector<std::uint64_t> written;  // digest of each block

  void require(bool done) const {
    if (!done) write_failed(path, words_of(output->geterror()));
  }
  void open();
  void write(int block, std::span<const std::byte> bytes);
  void compare_with_file() const;
};

void ImageWriter::Impl::open() {
  use_one_image_thread();
  output = OIIO::ImageOutput::create(library_name(job.format));
  if (!output) write_failed(path, words_of(OIIO::geterror()));
  if (job.stacking == Stacking::down) {
    require(output->open(path, oiio_spec(job, job.block.height * job.num_blocks, 0)));
    return;
  }
  for (int b = 0; b < job.num_blocks; ++b) parts.push_back(oiio_spec(job, job.block.height, b));
  require(output->open(path, job.num_blocks, parts.data()));
}

void ImageWriter::Impl::write(int block, std::span<const std::byte> bytes) {
  const OIIO::TypeDesc type = oiio_type(job.block.type);
  const int rows = job.block.height;
  if (job.stacking == Stacking::down) {
    require(output->write_scanlines(block * rows, (block + 1) * rows, 0, type, bytes.data()));
    return;
  }
  if (block > 0) require(output->open(path, parts[static_cast<std::size_t>(block)], OIIO::ImageOutput::AppendSubimage));
  require(output->write_image(type, bytes.data()));
}

void ImageWriter::Impl::compare_with_file() const {
  ImageReader reader(path);
  const ImageShape& block = job.block;
  const bool in_parts = job.stacking == Stacking::parts;
  const ImageShape& found = reader.shape(0);
  const int height = in_parts ? block.height : block.height * job.num_blocks;
  if (found.width != block.width || found.height != height || found.channels != block.channels ||
      (in_parts && reader.num_parts() != job.num_blocks))
    write_failed(path, "reading it back gave another size");
  std::vector<std::byte> bytes(block.num_bytes());
  for (int b = 0; b < job.num_blocks; ++b) {
    reader.read_rows(in_parts ? b : 0, in_parts ? 0 : b * block.height, block.height, bytes);
    if (job.format != ImageFormat::hdr && digest_of(bytes) != written[static_cast<std::size_t>(b)])
      write_failed(path, "reading it back gave other values");
  }
}

ImageWriter::ImageWriter(const std::string& path, const ImageJob& job) : impl_(std::make_unique<Impl>()) {
  impl_->path = path;
  impl_->job = job;
  impl_->open();
}
ImageWriter::~ImageWriter() = default;

void ImageWriter::write_block(std::span<const std::byte> bytes) {
  NOISELOOM_CHECK_EQ(bytes.size(), impl_->job.block.num_bytes());
  NOISELOOM_CHECK_LT(impl_->written.size(), static_cast<std::size_t>(impl_->job.num_blocks));
  impl_->write(static_cast<int>(impl_->written.size()), bytes);
  impl_->written.push_back(digest_of(bytes));
}

void ImageWriter::close() {
  NOISELOOM_CHECK_EQ(impl_->written.size(), static_cast<std::size_t>(impl_->job.num_blocks));
  impl_->require(impl_->output->close());
  try {
    impl_->compare_with_file();
  } catch (const UserError& error) {  // to the reader it is a file of the user's
    throw EnvironmentError(error.what());
  }
}

void write_image(const std::string& path, const ImageJob& job, const BlockBytes& blocks) {
  ImageWriter writer(path, job);
  for (int b = 0; b < job.num_blocks; ++b) writer.write_block(blocks(b));
  writer.close();
}

}  // namespace noiseloom
