// Writing image files (PNG, TIFF, OpenEXR, Radiance HDR) as bare numbers: no gamma, no premultiplication, no rescaling,
// no mip levels. OpenImageIO does the formats; it is handed finished integers or floats. (image_reader.h reads them.)
//
// Pixels are interleaved, [y][x][channel], native byte order. An image may be written in blocks of equal size, stacked
// downward (a strip) or as the parts of one OpenEXR file.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "noiseloom/image/encoding.h"

namespace noiseloom {

// float16: IEEE 754 binary16. Image files hold no uint32; headers do.
enum class PixelType { uint8, uint16, uint32, float16, float32 };
std::size_t bytes_per_number(PixelType type);
bool is_integer(PixelType type);
std::string to_string(PixelType type);  // "8 bit", "16 bit", "32 bit", "half", "float"

struct ImageShape {
  int width = 0;
  int height = 0;
  int channels = 0;
  PixelType type = PixelType::uint8;
  std::vector<std::string> channel_names;  // may be empty when writing
  int alpha = -1;                          // index of the alpha channel, -1: none
  std::size_t num_bytes() const;
};

// The formats that are written through the image library.
enum class ImageFormat { png, tiff, exr, hdr };

// How the blocks of an image lie in its file: one under the other, or as parts of an OpenEXR file.
enum class Stacking { down, parts };

struct ImageJob {
  ImageFormat format = ImageFormat::png;
  ImageShape block;  // of one block
  int num_blocks = 1;
  Stacking stacking = Stacking::down;
  std::string description;  // stored in the file's description field
  // Stored as texts of their own, "noiseloom:KEY", in PNG and OpenEXR, and behind the description in TIFF.
  std::vector<std::pair<std::string, std::string>> facts = {};
  std::vector<std::string> part_names;  // Stacking::parts: one per block
};

// Writes an image file block by block and, when the last one is there, reads it back and compares, as a full disk is
// not always reported by image libraries. (hdr keeps 8 bits of each number: there only the size is compared.)
class ImageWriter {
 public:
  // The file must not exist. Throws EnvironmentError with the library's own words, as the functions below do; the file
  // may then exist, incomplete.
  ImageWriter(const std::string& path, const ImageJob& job);
  ~ImageWriter();
  // The next block, from the first to the last.
  void write_block(std::span<const std::byte> bytes);
  // Requires that all blocks were written.
  void close();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// The bytes of one block; valid until the next call.
using BlockBytes = std::function<std::span<const std::byte>(int block)>;

// All of the above in one call.
void write_image(const std::string& path, const ImageJob& job, const BlockBytes& blocks);

}  // namespace noiseloom
