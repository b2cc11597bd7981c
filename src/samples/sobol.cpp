#include "noiseloom/samples/sobol.h"

#include "noiseloom/core/random.h"

namespace noiseloom {
namespace {

constexpr int index_bits = sobol_bits;

// What a dimension is made of: a primitive polynomial of that degree, its inner coefficients as bits, and the first
// direction integers [JoeKuo08].
struct Dimension {
  int degree;
  std::uint32_t coefficients;
  std::array<std::uint32_t, 3> first;
};

using Directions = std::array<std::uint32_t, index_bits>;

constexpr Directions van_der_corput() {
  Directions directions{};
  for (int bit = 0; bit < index_bits; ++bit) directions[static_cast<std::size_t>(bit)] = 1U << (sobol_bits - 1 - bit);
  return directions;
}

constexpr Directions directions_of(const Dimension& dimension) {
  Directions directions{};
  const auto degree = static_cast<std::size_t>(dimension.degree);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    if (i < degree) {
      directions[i] = dimension.first[i] << (sobol_bits - 1 - static_cast<int>(i));
      continue;
    }
    directions[i] = directions[i - degree] ^ (directions[i - degree] >> degree);
    for (std::size_t k = 1; k < degree; ++k) {
      if ((dimension.coefficients >> (degree - 1 - k) & 1U) != 0) directions[i] ^= directions[i - k];
    }
  }
  return directions;
}

constexpr std::array<Directions, max_sobol_dimensions> all_directions = {
    van_der_corput(), directions_of({1, 0, {1, 0, 0}}), directions_of({2, 1, {1, 3, 0}}),
    directions_of({3, 1, {1, 3, 1}})};

}  // namespace

std::array<std::uint32_t, max_sobol_dimensions> sobol_point(std::uint32_t index) {
  std::array<std::uint32_t, max_sobol_dimensions> point{};
  for (std::size_t bit = 0; index >> bit != 0; ++bit) {
    if ((index >> bit & 1U) == 0) continue;
    for (std::size_t d = 0; d < point.size(); ++d) point[d] ^= all_directions[d][bit];
  }
  return point;
}

// One random block of 128 bits holds the flips of a tree of seven digits (127 nodes, numbered from 1 as a heap is), so
// that four blocks do for a coordinate.
std::uint32_t owen_scrambled(std::uint32_t code, int dimension, std::uint64_t seed) {
  constexpr int digits_of_tree = 7;
  std::uint32_t flips = 0;
  for (int done = 0; done < sobol_bits; done += digits_of_tree) {
    const std::uint64_t prefix = done == 0 ? 0 : code >> (sobol_bits - done);
    const RandomBlock tree = random_block(seed, Purpose::scramble, static_cast<std::uint32_t>(dimension),
                                          static_cast<std::uint32_t>(done), prefix);
    std::uint32_t node = 1;
    for (int digit = done; digit < sobol_bits && digit < done + digits_of_tree; ++digit) {
      const int place = sobol_bits - 1 - digit;
      flips |= (tree[node / 32] >> node % 32 & 1U) << place;
      node = 2 * node + (code >> place & 1U);
    }
  }
  return code ^ flips;
}

}  // namespace noiseloom
