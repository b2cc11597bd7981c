// A number as the bytes of a pixel.
#pragma once

#include <cstring>

#include "noiseloom/core/number_type.h"
#include "noiseloom/image/encoding.h"
#include "noiseloom/image/image_io.h"

namespace noiseloom {

// Integers stand for 0 to 1 (encoding.h). `below_one`: the number is one of [0, 1), and stays below 1 as a half, too:
// the nearest one may be 1.
inline void store_number(double number, PixelType type, bool below_one, std::byte* at) {
  const auto put = [at](auto stored) { std::memcpy(at, &stored, sizeof stored); };
  constexpr std::uint16_t half_one = 0x3C00;
  switch (type) {
    case PixelType::uint8:
      return put(static_cast<std::uint8_t>(quantise(number, 8)));
    case PixelType::uint16:
      return put(quantise(number, 16));
    case PixelType::uint32:
      return put(quantise_32(number));
    case PixelType::float16: {
      const std::uint16_t nearest = half_of(number);
      return put(nearest == half_one && number < 1 && below_one ? std::uint16_t{half_one - 1} : nearest);
    }
    case PixelType::float32:
      return put(static_cast<float>(number));
  }
}

}  // namespace noiseloom
