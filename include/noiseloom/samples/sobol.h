// The Sobol sequence in up to four dimensions [JoeKuo08], with Owen's nested uniform scrambling [Owen95].
//
// Any 2^m consecutive points whose first index is a multiple of 2^m are a (t, m, s)-net in base 2: every elementary
// interval of volume 2^(t - m) holds 2^t of them, with t = 0 in one and two dimensions. Scrambling keeps that, and
// makes every point uniform.
#pragma once

#include <array>
#include <cstdint>

namespace noiseloom {

inline constexpr int max_sobol_dimensions = 4;
// Digits of a coordinate. Its value is (code + 0.5) / 2^23, which float holds exactly; a net has as many points at
// most.
inline constexpr int sobol_bits = 23;

// The codes of point `index` < 2^23, one for each dimension: below 2^23.
std::array<std::uint32_t, max_sobol_dimensions> sobol_point(std::uint32_t index);

// The code with its digits flipped: each by a bit that is drawn for (seed, dimension, all digits before it).
std::uint32_t owen_scrambled(std::uint32_t code, int dimension, std::uint64_t seed);

inline float sobol_value(std::uint32_t code) { return (static_cast<float>(code) + 0.5F) * 0x1p-23F; }

}  // namespace noiseloom
