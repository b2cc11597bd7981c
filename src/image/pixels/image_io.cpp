#include "noiseloom/image/image_io.h"

namespace noiseloom {

std::size_t bytes_per_number(PixelType type) {
  switch (type) {
    case PixelType::uint8:
      return 1;
    case PixelType::uint16:
    case PixelType::float16:
      return 2;
    case PixelType::uint32:
    case PixelType::float32:
      return 4;
  }
  return 4;
}

bool is_integer(PixelType type) { return type != PixelType::float16 && type != PixelType::float32; }

std::string to_string(PixelType type) {
  switch (type) {
    case PixelType::uint8:
      return "8 bit";
    case PixelType::uint16:
      return "16 bit";
    case PixelType::uint32:
      return "32 bit";
    case PixelType::float16:
      return "half";
    case PixelType::float32:
      return "float";
  }
  return "";
}

std::size_t ImageShape::num_bytes() const {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * static_cast<std::size_t>(channels) *
         bytes_per_number(type);
}

}  // namespace noiseloom
