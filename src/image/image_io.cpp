#include "noiseloom/image/image_io.h"

#include "image/image_library.h"
#include "noiseloom/core/error.h"

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

void use_one_image_thread() {
  OIIO::attribute("threads", 1);
  OIIO::attribute("exr_threads", -1);
}

}  // namespace noiseloom
