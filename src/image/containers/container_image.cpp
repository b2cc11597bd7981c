// PNG, OpenEXR, TIFF and Radiance HDR, written by the image library (image_io.h).
#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "image/containers/container_writers.h"
#include "image/facts/provenance.h"
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
    image.block.width *= job.columns;
    image.num_blocks = (job.num_slices + job.columns - 1) / job.columns;
    image.stacking = job.layout == ExportLayout::parts ? Stacking::parts : Stacking::down;
    image.description = job.description;
    if (job.holds_samples) image.facts = reading_facts(job);
    image.facts.insert(image.facts.end(), job.facts.begin(), job.facts.end());
    for (const SliceIndex s : job.slices()) image.part_names.push_back(fmt::format("slice{}", s.value()));
    row_bytes_ = job.slice.num_bytes() / static_cast<std::size_t>(job.slice.height);
    columns_ = static_cast<std::size_t>(job.columns);
    column_ = 0;
    writer_ = std::make_unique<ImageWriter>(files_.add(target), image);
  }
  void slice(SliceIndex, std::span<const std::byte> bytes) override {
    if (columns_ == 1) return writer_->write_block(bytes);
    band_.resize(bytes.size() * columns_);
    for (std::size_t y = 0; y * row_bytes_ < bytes.size(); ++y)
      std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(y * row_bytes_), row_bytes_,
                  band_.begin() + static_cast<std::ptrdiff_t>((y * columns_ + column_) * row_bytes_));
    if (++column_ == columns_) write_band();
  }
  void end() override {
    if (column_ > 0) write_band();
    writer_->close();
    writer_.reset();
  }

 private:
  // What no slice was put into is zero.
  void write_band() {
    writer_->write_block(band_);
    std::fill(band_.begin(), band_.end(), std::byte{});
    column_ = 0;
  }

  OutputFiles& files_;
  ImageFormat format_;
  std::unique_ptr<ImageWriter> writer_;
  std::size_t row_bytes_ = 0;  // of a slice
  std::size_t columns_ = 1;
  std::size_t column_ = 0;       // of the next slice
  std::vector<std::byte> band_;  // slices beside each other
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
