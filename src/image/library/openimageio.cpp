// The module that gives the image library (image_library.h): OpenImageIO.
#include <OpenImageIO/imageio.h>

#include <utility>
#include <vector>

#include "image/library/openvdb.h"
#include "image/pixels/image_library.h"

namespace noiseloom {
namespace {

OIIO::TypeDesc oiio_type(PixelType type) {
  switch (type) {
    case PixelType::uint8:
      return OIIO::TypeDesc::UINT8;
    case PixelType::uint16:
      return OIIO::TypeDesc::UINT16;
    case PixelType::uint32:
      return OIIO::TypeDesc::UINT32;
    case PixelType::float16:
      return OIIO::TypeDesc::HALF;
    case PixelType::float32:
      return OIIO::TypeDesc::FLOAT;
  }
  return OIIO::TypeDesc::FLOAT;
}

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

// What spec_of() below writes: attributes "noiseloom:KEY" or, in TIFF, lines "KEY: TEXT" of the description, of which
// the config is the last, with lines of its own.
std::vector<std::pair<std::string, std::string>> facts_of_file(const OIIO::ImageSpec& spec) {
  std::vector<std::pair<std::string, std::string>> facts;
  const std::string prefix = "noiseloom:";
  for (const OIIO::ParamValue& attribute : spec.extra_attribs) {
    const std::string name = attribute.name().string();
    if (name.compare(0, prefix.size(), prefix) == 0)
      facts.emplace_back(name.substr(prefix.size()), attribute.get_string());
  }
  if (!facts.empty() || spec.get_string_attribute("Software") != "noiseloom") return facts;
  const std::string text = spec.get_string_attribute("ImageDescription");
  for (std::size_t at = text.find('\n'); at != std::string::npos;) {
    const std::size_t colon = text.find(": ", ++at);
    if (colon == std::string::npos) break;
    const std::string key = text.substr(at, colon - at);
    const std::size_t end = key == "config" ? std::string::npos : text.find('\n', colon);
    facts.emplace_back(key, text.substr(colon + 2, end == std::string::npos ? end : end - colon - 2));
    at = end;
  }
  return facts;
}

class Input final : public ImageInput {
 public:
  explicit Input(std::unique_ptr<OIIO::ImageInput> input) : input_(std::move(input)) {}

  bool open(const std::string& path) override {
    OIIO::ImageSpec hints;
    hints.attribute("oiio:UnassociatedAlpha", 1);  // else colours are multiplied by alpha
    hints.attribute("oiio:RawColor", 1);
    OIIO::ImageSpec spec;
    return input_->open(path, spec, hints);
  }

  bool seek(int part) override {
    part_ = part;
    return input_->seek_subimage(part, 0);
  }

  ImagePart part() const override {
    const OIIO::ImageSpec& spec = input_->spec();
    ImagePart part;
    part.shape = {spec.width, spec.height, spec.nchannels, PixelType::uint8, spec.channelnames, spec.alpha_channel};
    if (spec.format == OIIO::TypeDesc::UINT16)
      part.shape.type = PixelType::uint16;
    else if (spec.format == OIIO::TypeDesc::HALF)
      part.shape.type = PixelType::float16;
    else if (spec.format == OIIO::TypeDesc::FLOAT)
      part.shape.type = PixelType::float32;
    else if (spec.format != OIIO::TypeDesc::UINT8)
      part.other_type = spec.format.c_str();
    part.flat = spec.depth <= 1;
    part.deep = spec.deep;
    part.tile_width = spec.tile_width;
    part.tile_height = spec.tile_height;
    part.x = spec.x;
    part.y = spec.y;
    part.full_x = spec.full_x;
    part.full_y = spec.full_y;
    part.full_width = spec.full_width;
    part.full_height = spec.full_height;
    part.facts = facts_of_file(spec);
    return part;
  }

  bool read_all(PixelType type, std::byte* bytes) override {
    return input_->read_image(part_, 0, 0, input_->spec().nchannels, oiio_type(type), bytes);
  }

  bool read_rows(int first, int end, PixelType type, std::byte* bytes) override {
    const int top = input_->spec().y;  // rows are counted in the display window
    return input_->read_scanlines(part_, 0, top + first, top + end, 0, 0, input_->spec().nchannels, type_of_rows(type),
                                  bytes);
  }

  std::string error() override { return input_->geterror(); }

 private:
  // Asked for by name, even the type that the file has is read through a buffer of 64 MB, allocated at every call.
  OIIO::TypeDesc type_of_rows(PixelType type) const {
    const OIIO::ImageSpec& spec = input_->spec();
    const bool as_stored = spec.channelformats.empty() && spec.format == oiio_type(type);
    return as_stored ? OIIO::TypeDesc(OIIO::TypeDesc::UNKNOWN) : oiio_type(type);
  }

  std::unique_ptr<OIIO::ImageInput> input_;
  int part_ = 0;
};

class Output final : public ImageOutput {
 public:
  explicit Output(std::unique_ptr<OIIO::ImageOutput> output) : output_(std::move(output)) {}

  bool open(const std::string& path, const ImageJob& job) override {
    path_ = path;
    job_ = job;
    if (job.stacking == Stacking::down) return output_->open(path, spec_of(job.block.height * job.num_blocks, 0));
    for (int b = 0; b < job.num_blocks; ++b) parts_.push_back(spec_of(job.block.height, b));
    return output_->open(path, job.num_blocks, parts_.data());
  }

  bool write_block(int block, const std::byte* bytes) override {
    const OIIO::TypeDesc type = oiio_type(job_.block.type);
    const int rows = job_.block.height;
    if (job_.stacking == Stacking::down)
      return output_->write_scanlines(block * rows, (block + 1) * rows, 0, type, bytes);
    if (block > 0 && !output_->open(path_, parts_[static_cast<std::size_t>(block)], OIIO::ImageOutput::AppendSubimage))
      return false;
    return output_->write_image(type, bytes);
  }

  bool close() override { return output_->close(); }
  std::string error() override { return output_->geterror(); }

 private:
  OIIO::ImageSpec spec_of(int height, int block) const {
    const ImageShape& shape = job_.block;
    OIIO::ImageSpec spec(shape.width, height, shape.channels, oiio_type(shape.type));
    if (!shape.channel_names.empty()) spec.channelnames = shape.channel_names;
    spec.alpha_channel = shape.alpha;
    spec.attribute("oiio:UnassociatedAlpha", 1);  // else colours are divided by alpha
    std::string description = job_.description;
    for (const auto& [key, value] : job_.facts) {
      if (job_.format == ImageFormat::tiff)
        description += "\n" + key + ": " + value;
      else if (job_.format != ImageFormat::hdr)
        spec.attribute("noiseloom:" + key, value);
    }
    spec.attribute("ImageDescription", description);
    spec.attribute("Software", "noiseloom");
    spec.attribute("DateTime", "1970:01:01 00:00:00");  // else the time of writing: equal textures are equal files
    // Noise does not compress, and plain files are read by the smallest of readers.
    if (job_.format == ImageFormat::exr || job_.format == ImageFormat::tiff) spec.attribute("compression", "none");
    spec.attribute("png:compressionLevel", 1);  // a deflate always runs: of noise, the fastest leaves as much as any
    if (job_.stacking == Stacking::parts)
      spec.attribute("oiio:subimagename", job_.part_names.at(static_cast<std::size_t>(block)));
    return spec;
  }

  std::unique_ptr<OIIO::ImageOutput> output_;
  std::string path_;
  ImageJob job_;
  std::vector<OIIO::ImageSpec> parts_;  // Stacking::parts
};

// Keeps to the calling thread: textures are small, and every thread takes address space that may be short.
class Library final : public ImageLibrary {
 public:
  Library() {
    OIIO::attribute("threads", 1);
    OIIO::attribute("exr_threads", -1);
  }

  void limit_image_size(int megabytes) const override { OIIO::attribute("limits:imagesize_MB", megabytes); }

  std::unique_ptr<ImageInput> input(const std::string& format) const override {
    std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create(format);
    return input ? std::make_unique<Input>(std::move(input)) : nullptr;
  }

  std::unique_ptr<ImageOutput> output(ImageFormat format) const override {
    std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(library_name(format));
    return output ? std::make_unique<Output>(std::move(output)) : nullptr;
  }

  std::string error() const override { return OIIO::geterror(); }

  std::string read_volume(const std::string& path, const std::string& grid, VolumeBox& volume) const override {
    return read_openvdb(path, grid, volume);
  }
};

}  // namespace
}  // namespace noiseloom

extern "C" [[gnu::visibility("default")]] const noiseloom::ImageLibrary* noiseloom_image_library_5();
extern "C" const noiseloom::ImageLibrary* noiseloom_image_library_5() {
  static const noiseloom::Library library;
  return &library;
}
