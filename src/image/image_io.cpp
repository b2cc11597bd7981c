#include "noiseloom/image/image_io.h"

namespace noiseloom {

std::size_t bytes_per_number(PixelType type) {
  return type == PixelType::uint8 ? 1 : type == PixelType::uint16 ? 2 : 4;
}

std::string to_string(PixelType type) {
  return type == PixelType::uint8 ? "8 bit" : type == PixelType::uint16 ? "16 bit" : "float";
}

std::size_t ImageShape::num_bytes() const {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * static_cast<std::size_t>(channels) *
         bytes_per_number(type);
}

}  // namespace noiseloom
