// Tables of a sampler that is optimised pixel by pixel for blue errors [Heitz19b]: a sequence, and for every pixel of a
// tile keys that scramble its values and its order.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace noiseloom::render {

struct SamplerTables {
  static constexpr std::size_t num_points = 256;      // after which the sequence begins again
  static constexpr std::size_t num_dimensions = 256;  // of a point
  static constexpr std::size_t side = 128;            // of the tile, pixels
  static constexpr std::size_t num_keys = 8;          // of a pixel: further dimensions take them again

  std::vector<std::uint8_t> sequence;  // [point][dimension]
  std::vector<std::uint8_t> scramble;  // [y][x][key]
  std::vector<std::uint8_t> order;     // the same

  // The middle of one of 256 parts of 0 to 1.
  float value(std::size_t x, std::size_t y, std::size_t point, std::size_t dimension) const {
    const std::size_t key = (y % side * side + x % side) * num_keys + dimension % num_keys;
    const std::size_t ranked = point % num_points ^ order[key];
    const unsigned code = sequence[ranked * num_dimensions + dimension % num_dimensions] ^ unsigned { scramble[key] };
    return (static_cast<float>(code) + 0.5F) / 256;
  }
};

// Reads the source text in C, C++ or a language like them in which such tables are passed on: arrays called
// sobol_256spp_256d, scramblingTile and rankingTile, the last of which may be absent (the order stays as it is). Throws
// UserError naming the array that is absent, of another size, or holds something else than integers of 0 to 255.
SamplerTables load_sampler_tables(const std::string& path);

}  // namespace noiseloom::render
