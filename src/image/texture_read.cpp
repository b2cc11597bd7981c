#include "noiseloom/image/texture_read.h"

#include <numeric>

#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

// 1/g and 1/g^2 of the plastic number g = 1.3247..., times 2^32: the steps of the R2 sequence.
constexpr std::uint32_t r2_x = 3242174889;
constexpr std::uint32_t r2_y = 2447445414;

// The 16 high bits of the sequence's element, scaled to 0 <= offset < size.
std::int64_t r2_offset(std::uint32_t step, int index, std::int64_t size) {
  const std::uint32_t fraction = step * static_cast<std::uint32_t>(index);
  return (std::int64_t{fraction >> 16} * size) >> 16;
}

}  // namespace

std::int64_t round_step(std::int64_t size) {
  std::int64_t step = ((size * (r2_x >> 16)) >> 16) | 1;
  while (std::gcd(step, size) != 1) ++step;
  return step;
}

TextureRead::Place TextureRead::place(std::int64_t frame, int value) const {
  NOISELOOM_CHECK(frame >= 0 && value >= 0 && value < values);
  const std::int64_t step = from == ValuesFrom::slices ? frame * values + value : frame;
  const std::int64_t round = step / num_slices;
  Place place;
  place.slice = SliceIndex(step % num_slices);
  place.dx = round % width * round_step(width) % width;
  place.dy = (round / width + round % width) % height * round_step(height) % height;
  if (from == ValuesFrom::offsets) {
    place.dx = (place.dx + r2_offset(r2_x, value, width)) % width;
    place.dy = (place.dy + r2_offset(r2_y, value, height)) % height;
  }
  return place;
}

}  // namespace noiseloom
