// Counter-based random numbers: every draw is a pure function of (seed, purpose, slice, sweep, index), so results
// depend on no state, no order, no rank and no thread. The generator is Philox4x32-10 [Salmon11], as the library
// Random123 has it.
#pragma once

#include <array>
#include <cstdint>

namespace noiseloom {

// What a draw is for; draws for different purposes are independent. The numbers are part of the format: never reuse
// one.
enum class Purpose : std::uint32_t {
  jitter = 1,          // position inside a stratum
  shuffle = 2,         // start permutation of a slice
  proposal = 3,        // swap candidates and their acceptance
  pairing = 4,         // Feistel rounds and the XOR of the paper's involution
  fraction = 5,        // which pairs of the paper's method may swap
  subset = 6,          // random blocks of samples for the mean distance
  tie = 7,             // ties of void and cluster
  start_pattern = 8,   // initial binary pattern of void and cluster
  tile_shift = 9,      // where the tiles of a slice begin
  slice_pattern = 10,  // start pattern of a slice of construction
  scramble = 11,       // digits of a Sobol sequence
  lattice_shift = 12   // where a lattice begins
};

using RandomBlock = std::array<std::uint32_t, 4>;

// 128 random bits. `index` counts draws within (purpose, slice, sweep) and must be below 2^56.
RandomBlock random_block(std::uint64_t seed, Purpose purpose, std::uint32_t slice, std::uint32_t sweep,
                         std::uint64_t index);

// [0, 1) with 53 bits.
inline double to_unit_double(std::uint32_t hi, std::uint32_t lo) {
  const std::uint64_t bits = (std::uint64_t{hi} << 21) ^ (lo >> 11);
  return static_cast<double>(bits) * 0x1p-53;
}
// [0, 1) with 24 bits: exact in float.
inline float to_unit_float(std::uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24F; }
// [0, bound) without division; bias below bound / 2^32 (bound <= 2^32).
inline std::uint32_t to_below(std::uint32_t bits, std::uint64_t bound) {
  return static_cast<std::uint32_t>((std::uint64_t{bits} * bound) >> 32);
}

}  // namespace noiseloom
