#include <fmt/format.h>

#include "image/pixels/image_library.h"
#include "noiseloom/core/error.h"
#include "noiseloom/files/digest.h"
#include "noiseloom/image/image_io.h"
#include "noiseloom/image/image_reader.h"

namespace noiseloom {
namespace {

[[noreturn]] void write_failed(const std::string& path, const std::string& words) {
  throw EnvironmentError(fmt::format("{}: cannot write the image: {}", path, words));
}

}  // namespace

struct ImageWriter::Impl {
  std::string path;
  ImageJob job;
  std::unique_ptr<ImageOutput> output;
  std::vector<std::uint64_t> written;  // digest of each block

  void require(bool done) const {
    if (!done) write_failed(path, words_of(output->error()));
  }
  void open();
  void compare_with_file() const;
};

void ImageWriter::Impl::open() {
  const ImageLibrary& library = image_library();
  output = library.output(job.format);
  if (!output) write_failed(path, words_of(library.error()));
  require(output->open(path, job));
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
  impl_->require(impl_->output->write_block(static_cast<int>(impl_->written.size()), bytes.data()));
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
