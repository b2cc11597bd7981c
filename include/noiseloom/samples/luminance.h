// The luminance of an image: what its pixels weigh as a density.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "noiseloom/files/input_array.h"
#include "noiseloom/samples/spec.h"

namespace noiseloom {

// Of an image that a spec names: a .npy of shape [height, width] or [height, width, channels], or what decode_image()
// reads; float [height, width]. Three channels are red, green and blue of ITU-R BT.709 (0.2126, 0.7152, 0.0722), a
// fourth and that behind a single one is alpha and left out; sRGB codes (IEC 61966-2-1) are decoded first. Throws
// UserError for another shape, and as reading does.
InputArrayPtr read_luminance(const SampleSpec& spec);

// The table that samples of an image are drawn with, which takes longer to make and twice as much memory as the
// luminance: how many numbers it has, and the numbers, of a spec that holds the luminance. Throws UserError for what is
// no density, as making the samples does.
std::size_t num_image_masses(const InputArray& luminance);
void make_image_masses(const SampleSpec& spec, std::span<std::uint64_t> masses);

// Rows and columns that an image may have.
inline constexpr std::int64_t max_image_side = 65536;

// Whether an image of this name is read by decode_image(), and not as a .npy.
bool is_decoded(const std::string& path);

// Whether an image with this name may hold sRGB codes: its format has integers.
bool may_hold_codes(const std::string& path);

}  // namespace noiseloom
