#include "render/noises/sampler_keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <fstream>
#include <iterator>
#include <span>
#include <sstream>
#include <vector>

#include "noiseloom/core/error.h"
#include "noiseloom/core/math.h"
#include "noiseloom/core/random.h"
#include "noiseloom/files/digest.h"
#include "noiseloom/render/noise.h"
#include "noiseloom/samples/sobol.h"

namespace noiseloom::render {
namespace {

constexpr int tile_side = static_cast<int>(SamplerTables::side);
constexpr std::size_t num_cells = SamplerTables::side * SamplerTables::side;
constexpr std::size_t num_steps = 64;  // integrands, one for each bit of a word
constexpr std::size_t lanes_of_errors = 8;
constexpr int codes = 256;

using Errors = std::array<float, num_steps>;  // of a pixel: for each integrand

// In eight parts, which the compiler keeps in vectors, added up in one order.
float dot_product(const Errors& a, const Errors& b) {
  std::array<float, lanes_of_errors> sums{};
  for (std::size_t i = 0; i < num_steps; i += lanes_of_errors)
    for (std::size_t lane = 0; lane < lanes_of_errors; ++lane) sums[lane] += a[i + lane] * b[i + lane];
  return ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]));
}

Errors difference_of_errors(const Errors& a, const Errors& b) {
  Errors difference;
  for (std::size_t i = 0; i < num_steps; ++i) difference[i] = a[i] - b[i];
  return difference;
}

// What purposes of random numbers are told apart by, beside their own.
enum class KeyDraw : std::uint32_t { steps = 0, keys = 1, swaps = 2, choices = 3, order = 4, digits = 5 };

RandomBlock drawn(std::uint64_t seed, KeyDraw what, std::uint32_t round, std::uint64_t index) {
  return random_block(seed, purpose_of_keys, static_cast<std::uint32_t>(what), round, index);
}

// For every pair of codes the integrands that are 1 there: of one number, where it is below a threshold; of two, on one
// side of a line.
struct Integrands {
  std::vector<std::uint64_t> inside;  // [code of y][code of x]
  Errors means{};

  Integrands(int numbers, std::uint64_t seed) : inside(codes * codes) {
    std::array<std::array<double, 3>, num_steps> lines{};  // a x + b y < c
    for (std::size_t i = 0; i < num_steps; ++i) {
      const RandomBlock block = drawn(seed, KeyDraw::steps, 0, i);
      const double share = (static_cast<double>(i) + 0.5) / num_steps;
      const double a = numbers == 1 ? 1 : math::cos_2pi(share);
      const double b = numbers == 1 ? 0 : math::sin_2pi(share);
      const double x = numbers == 1 ? share : to_unit_double(block[0], block[1]);
      lines[i] = {a, b, a * x + b * to_unit_double(block[2], block[3])};
    }
    std::array<int, num_steps> counts{};
    for (int y = 0; y < codes; ++y)
      for (int x = 0; x < codes; ++x)
        for (std::size_t i = 0; i < num_steps; ++i) {
          const auto& [a, b, c] = lines[i];
          if (!(a * (x + 0.5) / codes + b * (y + 0.5) / codes < c)) continue;
          inside[static_cast<std::size_t>(y * codes + x)] |= std::uint64_t{1} << i;
          ++counts[i];
        }
    for (std::size_t i = 0; i < num_steps; ++i) means[i] = static_cast<float>(counts[i]) / (codes * codes);
  }
};

struct Keys {
  std::uint8_t x = 0;
  std::uint8_t y = 0;
  std::uint8_t order = 0;
};

// Pixels that a Gaussian filter of deviation 1 sees together, but for the pixel itself.
struct Neighbour {
  int dx;
  int dy;
  float weight;
};

std::vector<Neighbour> neighbours() {
  constexpr int reach = 4;
  std::vector<Neighbour> all;
  for (int dy = -reach; dy <= reach; ++dy)
    for (int dx = -reach; dx <= reach; ++dx) {
      const int square = dx * dx + dy * dy;
      if (square > 0 && square <= reach * reach) all.push_back({dx, dy, static_cast<float>(math::exp(-0.25 * square))});
    }
  return all;
}

std::size_t cell_at(int x, int y) {
  return static_cast<std::size_t>((y & (tile_side - 1)) * tile_side + (x & (tile_side - 1)));
}

// The error that a filter lets through, of which each pixel knows its part: `fields` holds the sum of the weighted
// errors of its neighbours.
class Annealing {
 public:
  Annealing(const KeysSpec& spec, const std::vector<std::uint8_t>& sequence)
      : spec_(spec), sequence_(sequence), integrands_(spec.numbers, spec.seed), keys_(num_cells), errors_(num_cells) {
    // Every key of values as often as any other.
    for (std::size_t i = 0; i < num_cells; ++i) {
      const auto high_x = static_cast<unsigned>(i % SamplerTables::side);
      const auto high_y = static_cast<unsigned>(i / SamplerTables::side);
      keys_[i] = {static_cast<std::uint8_t>(2 * high_x + (high_y & 1)),
                  static_cast<std::uint8_t>(2 * high_y + (high_x & 1)), 0};
    }
    for (std::size_t i = num_cells - 1; i > 0; --i)
      std::swap(keys_[i], keys_[to_below(drawn(spec.seed, KeyDraw::keys, 0, i)[0], i + 1)]);
  }

  std::vector<Keys> run() {
    place_values();
    for (int points = spec_.points / 2; points > 0; points /= 2) choose_halves(points);
    return keys_;
  }

 private:
  // Of the first `points` of the order that the keys give.
  Errors error_of(const Keys& keys, int points) const {
    std::array<int, num_steps> counts{};
    for (int i = 0; i < points; ++i) {
      const std::size_t point = static_cast<std::size_t>(i ^ keys.order) * SamplerTables::num_dimensions;
      const std::size_t x = sequence_[point] ^ std::size_t{keys.x};
      const std::size_t y = sequence_[point + 1] ^ std::size_t{keys.y};
      const std::uint64_t bits = integrands_.inside[y * codes + x];
      for (std::size_t k = 0; k < num_steps; ++k) counts[k] += static_cast<int>(bits >> k & 1);
    }
    Errors error;
    for (std::size_t k = 0; k < num_steps; ++k)
      error[k] = static_cast<float>(counts[k]) / static_cast<float>(points) - integrands_.means[k];
    return error;
  }

  void sum_fields() {
    fields_.assign(num_cells, Errors{});
    for (std::size_t cell = 0; cell < num_cells; ++cell) spread(cell, errors_[cell]);
  }
  void spread(std::size_t cell, const Errors& change) {
    const int x = static_cast<int>(cell) % tile_side;
    const int y = static_cast<int>(cell) / tile_side;
    for (const Neighbour& one : neighbours_) {
      Errors& field = fields_[cell_at(x + one.dx, y + one.dy)];
      for (std::size_t k = 0; k < num_steps; ++k) field[k] += one.weight * change[k];
    }
  }
  float weight_between(std::size_t a, std::size_t b) const {
    const auto apart = [](std::size_t from, std::size_t to) {
      const int d = (static_cast<int>(to) - static_cast<int>(from)) & (tile_side - 1);
      return std::min(d, tile_side - d);
    };
    const int dx = apart(a % SamplerTables::side, b % SamplerTables::side);
    const int dy = apart(a / SamplerTables::side, b / SamplerTables::side);
    const auto found = std::find_if(neighbours_.begin(), neighbours_.end(),
                                    [&](const Neighbour& one) { return one.dx == dx && one.dy == dy; });
    return found == neighbours_.end() ? 0 : found->weight;
  }

  // Temperatures fall from what most changes are worth to where few are accepted, so many trials of every pixel at
  // each. `change` says what a trial changes, `accept` makes it.
  template <class Change, class Accept>
  void anneal(KeyDraw what, std::uint32_t round, const Change& change, const Accept& accept) {
    double spread_of_changes = 0;
    for (std::size_t i = 0; i < 1024; ++i)
      spread_of_changes += std::abs(change(i * 16, drawn(spec_.seed, what, round, i))) / 1024;
    double temperature = spread_of_changes;
    const double factor = math::exp(-6.0 / spec_.sweeps);
    for (int sweep = 1; sweep <= spec_.sweeps; ++sweep) {
      for (std::size_t cell = 0; cell < num_cells; ++cell) {
        const RandomBlock block = drawn(spec_.seed, what, round, static_cast<std::size_t>(sweep) * num_cells + cell);
        const double worse = change(cell, block);
        if (worse <= 0 || worse < -temperature * math::log(to_unit_double(block[2], block[3]))) accept(cell, block);
      }
      temperature = sweep + 1 < spec_.sweeps ? temperature * factor : 0;
    }
  }

  void place_values() {
    for (std::size_t cell = 0; cell < num_cells; ++cell) errors_[cell] = error_of(keys_[cell], spec_.points);
    sum_fields();
    const auto partner = [](const RandomBlock& block) { return std::size_t{to_below(block[0], num_cells)}; };
    anneal(
        KeyDraw::swaps, 0,
        [&](std::size_t cell, const RandomBlock& block) {
          const std::size_t other = partner(block);
          const Errors moved = difference_of_errors(errors_[other], errors_[cell]);
          return static_cast<double>(dot_product(moved, difference_of_errors(fields_[cell], fields_[other]))) +
                 static_cast<double>(weight_between(cell, other) * dot_product(moved, moved));
        },
        [&](std::size_t cell, const RandomBlock& block) {
          const std::size_t other = partner(block);
          if (other == cell) return;
          const Errors moved = difference_of_errors(errors_[other], errors_[cell]);
          spread(cell, moved);
          spread(other, difference_of_errors(errors_[cell], errors_[other]));
          std::swap(errors_[cell], errors_[other]);
          std::swap(keys_[cell], keys_[other]);
        });
  }

  // Which half of its points so far a pixel takes first.
  void choose_halves(int points) {
    std::vector<Errors> others(num_cells);
    for (std::size_t cell = 0; cell < num_cells; ++cell) {
      if (drawn(spec_.seed, KeyDraw::choices, static_cast<std::uint32_t>(points), cell)[0] & 1) flip(cell, points);
      errors_[cell] = error_of(keys_[cell], points);
      flip(cell, points);
      others[cell] = error_of(keys_[cell], points);
      flip(cell, points);
    }
    sum_fields();
    anneal(
        KeyDraw::choices, static_cast<std::uint32_t>(points),
        [&](std::size_t cell, const RandomBlock&) {
          const Errors moved = difference_of_errors(others[cell], errors_[cell]);
          const float squares = dot_product(others[cell], others[cell]) - dot_product(errors_[cell], errors_[cell]);
          return static_cast<double>(dot_product(moved, fields_[cell])) + 0.5 * static_cast<double>(squares);
        },
        [&](std::size_t cell, const RandomBlock&) {
          spread(cell, difference_of_errors(others[cell], errors_[cell]));
          std::swap(errors_[cell], others[cell]);
          flip(cell, points);
        });
  }
  void flip(std::size_t cell, int points) { keys_[cell].order = static_cast<std::uint8_t>(keys_[cell].order ^ points); }

  const KeysSpec& spec_;
  const std::vector<std::uint8_t>& sequence_;
  const Integrands integrands_;
  const std::vector<Neighbour> neighbours_ = neighbours();
  std::vector<Keys> keys_;
  std::vector<Errors> errors_;
  std::vector<Errors> fields_;
};

// An order of 256 points in which every aligned block of a power of two is one: each digit is flipped by a bit that is
// drawn for the digits before it. Of the first numbers the points stay as they are.
std::array<std::uint8_t, codes> nested_order(std::uint64_t seed, std::uint32_t group) {
  std::array<std::uint8_t, codes> order{};
  for (unsigned i = 0; i < codes; ++i) {
    unsigned place = 0;
    for (unsigned digit = 0; digit < 8; ++digit) {
      const unsigned before = (1U << digit) + (i >> (8 - digit));
      const unsigned flip = group == 0 ? 0 : drawn(seed, KeyDraw::order, group, before)[0] & 1;
      place = 2 * place + ((i >> (7 - digit) & 1) ^ flip);
    }
    order[i] = static_cast<std::uint8_t>(place);
  }
  return order;
}

// Eight digits of the first two dimensions, scrambled.
std::array<std::uint8_t, 2> point_of(unsigned index, std::uint64_t seed, std::uint32_t group) {
  const RandomBlock block = drawn(seed, KeyDraw::digits, 0, group);
  const std::uint64_t scramble = (std::uint64_t{block[0]} << 32) | block[1];
  const auto codes_of_point = sobol_point(index);
  std::array<std::uint8_t, 2> point{};
  for (int d = 0; d < 2; ++d)
    point[static_cast<std::size_t>(d)] = static_cast<std::uint8_t>(
        owen_scrambled(codes_of_point[static_cast<std::size_t>(d)], d, scramble) >> (sobol_bits - 8));
  return point;
}

void append_array(std::string& text, const char* head, const std::vector<std::uint8_t>& values) {
  text += fmt::format("static const unsigned char {} = {{", head);
  for (std::size_t i = 0; i < values.size(); ++i)
    fmt::format_to(std::back_inserter(text), "{}{}{}", i % 32 == 0 ? "\n" : "", values[i],
                   i + 1 < values.size() ? "," : "};\n");
}

constexpr const char* head_of_digest = "// digest ";

std::string line_of_digest(const std::string& text) {
  return fmt::format("{}{}\n", head_of_digest, to_hex(digest_of(std::as_bytes(std::span(text.data(), text.size())))));
}

}  // namespace

SamplerTables make_sampler_tables(const KeysSpec& spec) {
  NOISELOOM_CHECK(spec.points >= 1 && spec.points <= codes && std::has_single_bit(static_cast<unsigned>(spec.points)));
  NOISELOOM_CHECK(spec.numbers == 1 || spec.numbers == 2);
  const auto numbers = static_cast<std::size_t>(spec.numbers);
  const std::size_t groups_with_keys = SamplerTables::num_keys / numbers;
  SamplerTables tables{std::vector<std::uint8_t>(SamplerTables::num_points * SamplerTables::num_dimensions),
                       std::vector<std::uint8_t>(num_cells * SamplerTables::num_keys),
                       std::vector<std::uint8_t>(num_cells * SamplerTables::num_keys)};
  std::vector<std::array<std::uint8_t, codes>> orders;
  for (std::size_t group = 0; group < SamplerTables::num_dimensions / numbers; ++group) {
    orders.push_back(nested_order(spec.seed, static_cast<std::uint32_t>(group)));
    for (unsigned i = 0; i < codes; ++i) {
      const auto scramble = group < groups_with_keys ? 0U : static_cast<std::uint32_t>(group);
      const auto point = point_of(orders[group][i], spec.seed, scramble);
      for (std::size_t k = 0; k < numbers; ++k)
        tables.sequence[i * SamplerTables::num_dimensions + group * numbers + k] = point[k];
    }
  }
  const std::vector<Keys> keys = Annealing(spec, tables.sequence).run();
  const TextureRead read{
      .width = tile_side, .height = tile_side, .num_slices = 1, .values = static_cast<int>(groups_with_keys)};
  for (std::size_t group = 0; group < groups_with_keys; ++group) {
    const TextureRead::Place place = read.place(0, static_cast<int>(group));
    std::array<std::uint8_t, codes> inverse{};
    for (unsigned i = 0; i < codes; ++i) inverse[orders[group][i]] = static_cast<std::uint8_t>(i);
    for (int y = 0; y < tile_side; ++y)
      for (int x = 0; x < tile_side; ++x) {
        const Keys& own = keys[cell_at(x + static_cast<int>(place.dx), y + static_cast<int>(place.dy))];
        for (std::size_t k = 0; k < numbers; ++k) {
          const std::size_t at = cell_at(x, y) * SamplerTables::num_keys + group * numbers + k;
          tables.scramble[at] = k == 0 ? own.x : own.y;
          tables.order[at] = inverse[own.order];
        }
      }
  }
  return tables;
}

std::string source_text(const SamplerTables& tables, const KeysSpec& spec) {
  std::string text = fmt::format(
      "// Made by noiseloom: keys for up to {} points of a pixel, of {}, seed {}.\n"
      "// Number d of point i in pixel (x, y) is (code + 0.5) / 256, where\n"
      "//   key  = (y % 128 * 128 + x % 128) * 8 + d % 8\n"
      "//   code = sobol_256spp_256d[(i % 256 ^ rankingTile[key]) * 256 + d % 256] ^ scramblingTile[key]\n",
      spec.points, spec.numbers == 1 ? "one number each" : "two numbers together", spec.seed);
  append_array(text, "sobol_256spp_256d[256 * 256]", tables.sequence);
  append_array(text, "scramblingTile[128 * 128 * 8]", tables.scramble);
  append_array(text, "rankingTile[128 * 128 * 8]", tables.order);
  return text + line_of_digest(text);
}

bool is_whole_source_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream read;
  read << file.rdbuf();
  const std::string text = read.str();
  const std::size_t last = text.rfind(head_of_digest);
  return last != std::string::npos && text.substr(last) == line_of_digest(text.substr(0, last));
}

}  // namespace noiseloom::render
