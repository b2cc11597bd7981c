// What the first bytes of an image file say of its format and size.
//
// Looked at before an image library is given the file: libraries allocate what a header claims, and some divide by a
// width of zero.
#pragma once

#include <cstdint>
#include <fstream>
#include <string>

namespace noiseloom {

struct ImageClaim {
  std::string format;            // as OpenImageIO names it; empty: none that is read here
  std::int64_t width = 0;        // of the first part, as the header says; 0 or less is no size
  std::int64_t height = 0;       // BMP stores images that begin at the top with a negative height: here it is positive
  std::int64_t least_bytes = 0;  // what the file must hold besides for the claim to be true (tables of offsets)
  std::string unreadable{};      // why it is not read although the format is, and what to do; "" where it is
};

// `extension` is looked at where a format has no mark of its own (.tga).
ImageClaim read_image_claim(std::ifstream& file, const std::string& extension);

}  // namespace noiseloom
