// PNG, OpenEXR, TIFF and Radiance HDR, written by the image library (image_io.h).
#include <fmt/format.h>

#include "image/container_writers.h"
#include "noiseloom/core/error.h"
#include "noiseloom/image/image_io.h"

namespace noiseloom {
namespace {

class ImageContainerWriter : public ContainerWriter {
 public:
  ImageContainerWriter(OutputFiles& files, ImageFormat format) : files_(files), format_(format) {}

  void begin(const std::string& target, const ContainerJob& job) override {
    ImageJob image;
    image.format = format_;
    image.block = job.slice;
    image.num_blocks = job.num_slices;
    image.stacking = job.layout == ExportLayout::parts ? Stacking::parts : Stacking::down;
    image.description = job.description;
    for (SliceIndex s = 0; s < job.num_slices; ++s)
      image.part_names.push_back(fmt::format("slice{}", job.first_slice + s));
    writer_ = std::make_unique<ImageWriter>(files_.add(target), image);
  }
  void slice(SliceIndex, std::span<const std::byte> bytes) override { writer_->write_block(bytes); }
  void end() override {
    writer_->close();
    writer_.reset();
  }

 private:
  OutputFiles& files_;
  ImageFormat format_;
  std::unique_ptr<ImageWriter> writer_;
};

}  // namespace

std::unique_ptr<ContainerWriter> make_png_writer(OutputFiles& files) {
  return std::make_unique<ImageContainerWriter>(files, ImageFormat::png);
}
std::unique_ptr<ContainerWriter> make_exr_writer(OutputFiles& files) {
  return std::make_unique<ImageContainerWriter>(files, ImageFormat::exr);
}
std::unique_ptr<ContainerWriter> make_tiff_writer(OutputFiles& files) {
  return std::make_unique<ImageContainerWriter>(files, ImageFormat::tiff);
}
std::unique_ptr<ContainerWriter> make_hdr_writer(OutputFiles& files) {
  return std::make_unique<ImageContainerWriter>(files, ImageFormat::hdr);
}

}  // namespace noiseloom
