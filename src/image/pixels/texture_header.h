// What the header of a KTX2 or DDS file says, and reading what follows it.
//
// Both formats hold bare numbers, slice after slice, x fastest, as they are read here: one level, no supercompression,
// no blocks. To ImageReader (image_reader.h) such a file is an image with a part for each slice.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "image/pixels/image_claim.h"
#include "image/pixels/image_library.h"

namespace noiseloom {

struct TextureHeader {
  ImageShape shape;  // of one slice; the channels are named R, G, B, A
  std::int64_t num_slices = 1;
  std::int64_t data_offset = 0;  // of the first slice in the file
  // Where each channel of `shape` lies among the numbers of a texel, which may be more.
  std::vector<int> order;
  int numbers_per_texel = 1;
  bool is_srgb = false;
  std::vector<std::pair<std::string, std::string>> facts = {};  // as ImagePart has them
  std::string unreadable;                                       // why the file is not read, in words; "" where it is

  std::int64_t bytes_per_slice() const {
    return static_cast<std::int64_t>(shape.width) * shape.height * numbers_per_texel *
           static_cast<std::int64_t>(bytes_per_number(shape.type));
  }
};

// The most slices that a file may claim: graphics cards hold 2048, masks over four axes have some thousands.
inline constexpr std::int64_t most_slices_of_a_texture = 65536;

// Of files that begin with the mark of their format. Nothing is thrown: where it cannot be read, it says why.
TextureHeader read_ktx2_header(std::ifstream& file);
TextureHeader read_dds_header(std::ifstream& file);

// Channels, their order and the number type from a format of the table.
struct TexelFormat;
void set_format(TextureHeader& header, const TexelFormat& format);

// "ktx2" or "dds", with what it must hold.
ImageClaim claim_of(const TextureHeader& header, const std::string& format);

// Reads the slices as parts. nullptr where the format is neither.
std::unique_ptr<ImageInput> texture_input(const std::string& format);

}  // namespace noiseloom
