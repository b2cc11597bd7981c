// What the reader and the writer of image files share: words and types of the image library.
#pragma once

#include <OpenImageIO/imageio.h>

#include <string>

#include "noiseloom/image/image_io.h"

namespace noiseloom {

inline OIIO::TypeDesc oiio_type(PixelType type) {
  switch (type) {
    case PixelType::uint8:
      return OIIO::TypeDesc::UINT8;
    case PixelType::uint16:
      return OIIO::TypeDesc::UINT16;
    case PixelType::float32:
      return OIIO::TypeDesc::FLOAT;
  }
  return OIIO::TypeDesc::FLOAT;
}

inline std::string words_of(const std::string& library_error) {
  return library_error.empty() ? "the image library gave no reason" : library_error;
}

}  // namespace noiseloom
