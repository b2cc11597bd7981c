// What `noiseloom-study pixels IMAGE` writes to its standard output for noiseloom: this header, then the numbers of the
// image (float, [height][width][channel]) or, where there are none, why. Both programs come from one build.
#pragma once

#include <array>
#include <cstdint>

namespace noiseloom {

inline constexpr std::uint64_t pixels_magic = 0x31736c6578697021;

struct PixelsHeader {
  enum class What : std::uint64_t { pixels, user_error, environment_error };
  std::uint64_t magic = pixels_magic;
  What what = What::pixels;
  std::array<std::uint64_t, 3> sizes{};  // pixels: height, width, channels; else the number of bytes of the words
};

}  // namespace noiseloom
