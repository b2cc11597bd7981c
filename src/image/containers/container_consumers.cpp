// Files that one program alone reads (consumers.h): text around the numbers, or beside an image.
#include <fmt/format.h>

#include <cstring>
#include <filesystem>

#include "image/containers/container_writers.h"
#include "image/containers/source_text.h"
#include "noiseloom/core/extents.h"

namespace noiseloom {
namespace {

// Godot: an atlas of PNG, and the settings by which it is imported as an array: no mip levels, no compression.
class GodotWriter : public ContainerWriter {
 public:
  explicit GodotWriter(OutputFiles& files) : files_(files), image_(make_png_writer(files)) {}

  void begin(const std::string& target, const ContainerJob& job) override {
    const std::int32_t rows = (job.num_slices + job.columns - 1) / job.columns;
    files_.write(target + ".import", filled(R"([remap]

importer="2d_array_texture"
type="CompressedTexture2DArray"

[deps]

source_file="res://$FILE"

[params]

compress/mode=0
compress/channel_pack=$PACK
mipmaps/generate=false
slices/horizontal=$COLUMNS
slices/vertical=$ROWS
)",
                                            {{"$FILE", std::filesystem::path(target).filename().string()},
                                             {"$PACK", job.slice.channels == 3 ? "1" : "0"},  // red and green alone
                                             {"$COLUMNS", std::to_string(job.columns)},
                                             {"$ROWS", std::to_string(rows)}}));
    image_->begin(target, job);
  }
  void slice(SliceIndex slice, std::span<const std::byte> bytes) override { image_->slice(slice, bytes); }
  void end() override { image_->end(); }

 private:
  OutputFiles& files_;
  std::unique_ptr<ContainerWriter> image_;
};

// What the writers of text share: a target, and a piece of text for each slice.
class TextWriter : public ContainerWriter {
 public:
  explicit TextWriter(OutputFiles& files) : files_(files) {}

  void begin(const std::string& target, const ContainerJob& job) final {
    job_ = &job;
    name_ = identifier_of(target);
    stream_ = files_.open(target);
    stream_->append(head());
  }
  void slice(SliceIndex slice, std::span<const std::byte> bytes) final { stream_->append(body(slice, bytes)); }
  void end() final {
    stream_->append(tail());
    stream_->close();
  }

 protected:
  const ContainerJob& job() const { return *job_; }
  // The description of a file of levels, which are no codes of numbers: without how those are decoded.
  std::string what_it_is() const { return job_->description.substr(0, job_->description.find("; value = ")); }
  const std::string& name() const { return name_; }
  std::size_t width() const { return static_cast<std::size_t>(job_->slice.width); }
  std::size_t height() const { return static_cast<std::size_t>(job_->slice.height); }
  std::size_t cells() const { return width() * height(); }
  // Of numbers of 32 bits: 0 to `levels` - 1.
  static std::uint64_t level(std::span<const std::byte> bytes, std::size_t cell, std::uint64_t levels) {
    std::uint32_t code = 0;
    std::memcpy(&code, bytes.data() + cell * sizeof code, sizeof code);
    return code * levels >> 32;
  }

 private:
  virtual std::string head() const = 0;
  virtual std::string body(SliceIndex slice, std::span<const std::byte> bytes) const = 0;
  virtual std::string tail() const = 0;

  OutputFiles& files_;
  const ContainerJob* job_ = nullptr;
  std::string name_;
  std::unique_ptr<OutputStream> stream_;
};

// mpv and libplacebo: the head of a texture, then its bytes in hexadecimal digits on one line.
class MpvWriter : public TextWriter {
  using TextWriter::TextWriter;

  std::string head() const override {
    const ImageShape& slice = job().slice;
    const std::string channels = std::string("rgba").substr(0, static_cast<std::size_t>(slice.channels));
    const bool half = slice.type == PixelType::float16;
    const std::string number = half                     ? "16f"
                               : is_integer(slice.type) ? std::to_string(8 * bytes_per_number(slice.type))
                                                        : "32f";
    return fmt::format("{}//!TEXTURE {}\n//!SIZE {} {}{}\n//!FORMAT {}{}\n//!FILTER NEAREST\n//!BORDER REPEAT\n",
                       comment_lines(job().description), name(), slice.width, slice.height,
                       job().num_slices > 1 ? fmt::format(" {}", job().num_slices) : "", channels, number);
  }
  std::string body(SliceIndex, std::span<const std::byte> bytes) const override {
    constexpr const char* digits = "0123456789abcdef";
    std::string text;
    for (const std::byte byte : bytes) {
      text += digits[std::to_integer<unsigned>(byte) >> 4];
      text += digits[std::to_integer<unsigned>(byte) & 15];
    }
    return text;
  }
  std::string tail() const override { return "\n"; }
};

// dxvk-remix: an array of integers of 64 bits, each of 8 pixels in a row, the first in the lowest bits.
class RemixWriter : public TextWriter {
  using TextWriter::TextWriter;

  std::string head() const override {
    return fmt::format(
        "{}#pragma once\n\n#include <cstdint>\n\nstatic const uint64_t blueNoise_{}x{}x{}[{}][{} * {} / "
        "sizeof(uint64_t)] = {{\n",
        comment_lines(job().description), width(), height(), job().num_slices, job().num_slices, width(), height());
  }
  std::string body(SliceIndex, std::span<const std::byte> bytes) const override {
    std::string text = "{\n";
    for (std::size_t at = 0; at + 8 <= bytes.size(); at += 8) {
      std::uint64_t word = 0;
      for (std::size_t i = 8; i-- > 0;) word = word << 8 | std::to_integer<std::uint64_t>(bytes[at + i]);
      text += fmt::format("0x{:016x}ull,{}", word, at % 64 == 56 ? "\n" : "");
    }
    return text + "},\n";
  }
  std::string tail() const override { return "};\n"; }
};

// pbrt: the definition that its header declares. There x counts slower than y.
class PbrtWriter : public TextWriter {
  using TextWriter::TextWriter;

  std::string head() const override {
    return fmt::format(
        "{}#include <pbrt/util/bluenoise.h>\n\nnamespace pbrt {{\n\nPBRT_CONST uint16_t "
        "BlueNoiseTextures[{}][{}][{}] = {{  // [texture][x][y]\n",
        comment_lines(job().description), job().num_slices, width(), height());
  }
  std::string body(SliceIndex, std::span<const std::byte> bytes) const override {
    std::string text = "{\n";
    for (std::size_t x = 0; x < width(); ++x) {
      text += "{";
      for (std::size_t y = 0; y < height(); ++y)
        text += stored_number_text(bytes, PixelType::uint16, y * width() + x) + (y + 1 < height() ? "," : "},\n");
    }
    return text + "},\n";
  }
  std::string tail() const override { return "};\n\n}  // namespace pbrt\n"; }
};

// ImageMagick: levels from 1 up to as many as there are pixels, of which a grey of level / divisor reaches that many.
class ImageMagickWriter : public TextWriter {
  using TextWriter::TextWriter;

  static std::string escaped(const std::string& text) { return filled(text, {{"<", "&lt;"}}); }
  std::string head() const override { return "<?xml version=\"1.0\"?>\n<thresholds>\n"; }
  std::string body(SliceIndex slice, std::span<const std::byte> bytes) const override {
    constexpr std::size_t most_levels = 65535;
    const std::size_t levels = std::min(cells(), most_levels);
    std::string text = fmt::format(
        "  <threshold map=\"{}{}\">\n    <description>{}</description>\n    <levels width=\"{}\" height=\"{}\" "
        "divisor=\"{}\">\n",
        map_name(), job().num_slices > 1 ? fmt::format("-{}", slice.value()) : "", escaped(what_it_is()), width(),
        height(), levels + 1);
    for (std::size_t cell = 0; cell < cells(); ++cell)
      text += fmt::format("{}{}", 1 + level(bytes, cell, levels), cell % width() + 1 < width() ? " " : "\n");
    return text + "    </levels>\n  </threshold>\n";
  }
  std::string tail() const override { return "</thresholds>\n"; }
  // By what the texture is called, whatever the file must be.
  std::string map_name() const { return identifier_of(job().source); }
};

// PostScript: a halftone of thresholds of 16 bits, high byte first. Run it before the page.
class GhostscriptWriter : public TextWriter {
  using TextWriter::TextWriter;

  std::string head() const override {
    return fmt::format(
        "%!PS\n% {}\n<< /HalftoneType 16 /Width {} /Height {}\n/Thresholds currentfile /ASCIIHexDecode filter >> "
        "sethalftone\n",
        what_it_is(), width(), height());
  }
  std::string body(SliceIndex, std::span<const std::byte> bytes) const override {
    std::string text;
    for (std::size_t cell = 0; cell < cells(); ++cell)
      text += fmt::format("{:04x}{}", 1 + level(bytes, cell, 65535), cell % 32 == 31 ? "\n" : "");
    return text;
  }
  std::string tail() const override { return ">\n"; }
};

// GIMP: a call that sets the matrix which conversions to few colours dither with. Zero is no threshold there.
class GimpWriter : public TextWriter {
  using TextWriter::TextWriter;

  std::string head() const override {
    return fmt::format("; {}\n(gimp-image-convert-set-dither-matrix {} {} {} #(\n", what_it_is(), width(), height(),
                       cells());
  }
  std::string body(SliceIndex, std::span<const std::byte> bytes) const override {
    std::string text;
    for (std::size_t cell = 0; cell < cells(); ++cell)
      text += fmt::format("{}{}", 1 + level(bytes, cell, 255), cell % width() + 1 < width() ? " " : "\n");
    return text;
  }
  std::string tail() const override { return "))\n"; }
};

}  // namespace

std::unique_ptr<ContainerWriter> make_godot_writer(OutputFiles& files) { return std::make_unique<GodotWriter>(files); }
std::unique_ptr<ContainerWriter> make_mpv_writer(OutputFiles& files) { return std::make_unique<MpvWriter>(files); }
std::unique_ptr<ContainerWriter> make_remix_writer(OutputFiles& files) { return std::make_unique<RemixWriter>(files); }
std::unique_ptr<ContainerWriter> make_pbrt_writer(OutputFiles& files) { return std::make_unique<PbrtWriter>(files); }
std::unique_ptr<ContainerWriter> make_imagemagick_writer(OutputFiles& files) {
  return std::make_unique<ImageMagickWriter>(files);
}
std::unique_ptr<ContainerWriter> make_ghostscript_writer(OutputFiles& files) {
  return std::make_unique<GhostscriptWriter>(files);
}
std::unique_ptr<ContainerWriter> make_gimp_writer(OutputFiles& files) { return std::make_unique<GimpWriter>(files); }

}  // namespace noiseloom
