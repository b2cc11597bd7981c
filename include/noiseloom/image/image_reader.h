// Reading image files as bare numbers: no gamma, no premultiplication, no rescaling; of mip levels, the largest. The
// slices of a KTX2 or DDS file (layers of an array, or of a volume) are parts of it.
//
// Pixels are interleaved, [y][x][channel], native byte order. What is read is the data window, wherever its origin
// lies: a texture has no place in a larger picture.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "noiseloom/image/image_io.h"

namespace noiseloom {

// An image file open for reading.
class ImageReader {
 public:
  // Throws UserError when the file is missing, not an image that is read here, claims to hold far more than a file of
  // its size can, or has numbers of a type that is not accepted (accepted: 8 and 16 bit unsigned integers, half and
  // float; KTX2 and DDS of one level, without supercompression and blocks).
  explicit ImageReader(const std::string& path);
  ~ImageReader();
  ImageReader(ImageReader&&) noexcept;

  int num_parts() const;
  const ImageShape& shape(int part) const;
  // "data window 64 x 64 at 3, -2 in a display window of 100 x 100 at 0, 0" where the two differ, else empty.
  const std::string& window(int part) const;
  // The file is marked as holding colours, which samplers decode: KTX2 and DDS. The numbers are read as they are.
  bool is_srgb() const;
  // What a file that was exported here says of itself: pairs of key and text (src/image/facts/provenance.h).
  const std::vector<std::pair<std::string, std::string>>& facts() const;
  // Rows [first_row, first_row + num_rows) of a part, counted from the top of its data window, into `bytes`. Throws
  // UserError when the file is cut or damaged.
  void read_rows(int part, int first_row, int num_rows, std::span<std::byte> bytes);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// ".png", in lower case; empty without one.
std::string lower_case_extension(const std::string& path);
// Where a file name ends in an extension of a format that is read here (lower or upper case).
bool has_image_extension(const std::string& path);
// ".png, .exr, ..."
std::string image_extensions();
// Why images with this extension (".jpg", in lower case) are not read; empty where it is none of a known image format.
std::string why_not_read(const std::string& extension);

}  // namespace noiseloom
