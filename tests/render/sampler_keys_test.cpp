#include "render/noises/sampler_keys.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <stdexcept>

#include "noiseloom/files/run_lock.h"
#include "render/scene_support.h"
#include "support/run_files.h"

namespace noiseloom::render {
namespace {

using Keyed = SamplerTables;

SamplerTables few_keys(int numbers) {
  return make_sampler_tables({.points = 4, .numbers = numbers, .seed = 3, .sweeps = 6});
}

// The mean square, over the tile, of the mean of neighbours in a square of three, of the error that the mean of so many
// points makes of an integrand whose mean over all values is `expected`.
template <class Integrand>
double smoothed_error(const SamplerTables& tables, std::size_t points, double expected, const Integrand& integrand) {
  std::vector<double> errors;
  for (std::size_t y = 0; y < Keyed::side; ++y)
    for (std::size_t x = 0; x < Keyed::side; ++x) {
      double sum = 0;
      for (std::size_t i = 0; i < points; ++i) sum += integrand(tables, x, y, i);
      errors.push_back(sum / static_cast<double>(points) - expected);
    }
  double squares = 0;
  for (std::size_t y = 0; y < Keyed::side; ++y)
    for (std::size_t x = 0; x < Keyed::side; ++x) {
      double sum = 0;
      for (std::size_t dy = 0; dy < 3; ++dy)
        for (std::size_t dx = 0; dx < 3; ++dx)
          sum += errors[(y + dy) % Keyed::side * Keyed::side + (x + dx) % Keyed::side] / 9;
      squares += sum * sum / static_cast<double>(errors.size());
    }
  return squares;
}

// The same keys, of pixels that are not those for which they were made.
SamplerTables scattered_keys(SamplerTables tables) {
  const std::size_t cells = Keyed::side * Keyed::side;
  const SamplerTables made = tables;
  for (std::size_t cell = 0; cell < cells; ++cell)
    for (std::size_t k = 0; k < Keyed::num_keys; ++k) {
      const std::size_t from = (cell * 7919 + 13) % cells * Keyed::num_keys + k;
      tables.scramble[cell * Keyed::num_keys + k] = made.scramble[from];
      tables.order[cell * Keyed::num_keys + k] = made.order[from];
    }
  return tables;
}

TEST(SamplerKeys, ErrorsHaveLittleOfLowFrequenciesAfterEveryPowerOfTwo) {
  for (const int numbers : {1, 2}) {
    const SamplerTables tables = few_keys(numbers);
    const SamplerTables scattered = scattered_keys(tables);
    // Of the first numbers and of those that have the keys of other places of the tile.
    for (const std::size_t first : {0UL, 2UL, 6UL})
      for (const std::size_t points : {1UL, 2UL, 4UL}) {
        const auto error = [&](const SamplerTables& of) {
          if (numbers == 1)
            return smoothed_error(of, points, 0.5, [&](const SamplerTables& t, auto x, auto y, auto i) {
              return static_cast<double>(t.value(x, y, i, first));
            });
          // Where the sum of both is less than one.
          return smoothed_error(of, points, 0.5 - 0.5 / 256, [&](const SamplerTables& t, auto x, auto y, auto i) {
            return t.value(x, y, i, first) + t.value(x, y, i, first + 1) < 0.999F ? 1.0 : 0.0;
          });
        };
        EXPECT_LT(error(tables), 0.9 * error(scattered)) << numbers << " " << first << " " << points;
      }
  }
}

// Keys are chosen for so many points and every power of two below: beyond, errors are as white as before.
TEST(SamplerKeys, BeyondTheirPointsErrorsAreWhite) {
  const SamplerTables tables = few_keys(1);
  const SamplerTables scattered = scattered_keys(tables);
  const auto ratio = [&](std::size_t points) {
    const auto error = [&](const SamplerTables& of) {
      return smoothed_error(of, points, 0.5, [](const SamplerTables& t, auto x, auto y, auto i) {
        return static_cast<double>(t.value(x, y, i, 0));
      });
    };
    return error(tables) / error(scattered);
  };
  EXPECT_LT(ratio(1), 0.4);
  EXPECT_LT(ratio(2), 0.4);
  for (const std::size_t points : {8UL, 64UL}) EXPECT_NEAR(ratio(points), 1, 0.1) << points;
}

TEST(SamplerKeys, EveryPixelHasANetAndTheTileAllValues) {
  const SamplerTables tables = few_keys(2);
  for (const std::size_t cell : {0UL, 1000UL, 16383UL})
    for (const std::size_t points : {4UL, 16UL, 256UL})
      for (std::size_t d = 0; d < 20; d += 2) {
        std::set<unsigned> of_x;
        std::set<unsigned> of_both;  // in squares
        const auto root = static_cast<float>(std::sqrt(static_cast<double>(points)));
        for (std::size_t i = 0; i < points; ++i) {
          const float u = tables.value(cell % 128, cell / 128, i, d);
          const float v = tables.value(cell % 128, cell / 128, i, d + 1);
          of_x.insert(static_cast<unsigned>(u * static_cast<float>(points)));
          of_both.insert(static_cast<unsigned>(u * root) * 256 + static_cast<unsigned>(v * root));
        }
        EXPECT_EQ(of_x.size(), points);
        EXPECT_EQ(of_both.size(), points);
      }
  for (std::size_t k = 0; k < Keyed::num_keys; ++k) {
    std::array<int, 256> counts{};
    for (std::size_t cell = 0; cell < Keyed::side * Keyed::side; ++cell)
      ++counts[tables.scramble[cell * Keyed::num_keys + k]];
    EXPECT_EQ(std::count(counts.begin(), counts.end(), 64), 256);
  }
}

// Two numbers of a point that have the same keys at other places are no function of each other.
TEST(SamplerKeys, FurtherNumbersAreIndependent) {
  const SamplerTables tables = few_keys(1);
  for (const std::size_t other : {1UL, 3UL, 8UL, 11UL}) {
    double together = 0;
    std::set<unsigned> of_both;
    for (std::size_t i = 0; i < 256; ++i) {
      const float u = tables.value(5, 9, i, 0);
      const float v = tables.value(5, 9, i, other);
      together += static_cast<double>((u - 0.5F) * (v - 0.5F)) * 12 / 256;
      of_both.insert(static_cast<unsigned>(u * 16) * 16 + static_cast<unsigned>(v * 16));
    }
    EXPECT_LT(std::abs(together), 0.25);
    EXPECT_GT(of_both.size(), 100U);  // 162 of independent ones, 16 of one that is a digit-wise function of the other
  }
}

TEST(SamplerKeys, AreKeptAsSourceTextThatShowsDamage) {
  const TemporaryFolder folder;
  const NoiseSpec spec{.kind = NoiseKind::sobol_blue, .name = "n", .points = 1};
  const std::string path = cached_tables(spec, folder / "noise");
  const KeysSpec keys{.points = 1, .numbers = 2, .seed = 1, .sweeps = 2};
  std::filesystem::create_directories(folder / "noise");
  const SamplerTables made = make_sampler_tables(keys);
  const std::string text = source_text(made, keys);
  std::ofstream(path) << text;
  // Somebody else may be at work on it, or own the folder: what is whole is read without a lock.
  const RunLock of_another(path + ".making");
  const auto never = [](const std::string&) { throw std::logic_error("waited for a file that is whole"); };
  const Noise kept = open_noise(spec, folder / "noise", nullptr, never);
  EXPECT_TRUE(kept.notes.empty());
  EXPECT_EQ(kept.tables->sequence, made.sequence);
  EXPECT_EQ(kept.tables->scramble, made.scramble);
  EXPECT_EQ(kept.tables->order, made.order);
  std::ofstream(folder / "plain") << "";
  EXPECT_THROW(open_noise(spec, folder / "plain", nullptr), UserError);
  std::string changed = text;
  ++changed[text.size() / 2];
  for (const std::string& damaged : {text.substr(0, text.size() / 2), changed, std::string()}) {
    std::ofstream(path) << damaged;
    EXPECT_FALSE(is_whole_source_text(path));
  }
}

TEST(SamplerKeys, AreMadeForPowersOfTwo) {
  EXPECT_ANY_THROW(scene_of("[[noise]]\nkind = \"sobol-blue\"\npoints = 12\n[effects.integrand]\n"));
  EXPECT_ANY_THROW(scene_of("[[noise]]\nkind = \"sobol-blue\"\npoints = 512\n[effects.integrand]\n"));
  EXPECT_ANY_THROW(scene_of("[[noise]]\nkind = \"white\"\npoints = 8\n[effects.integrand]\n"));
  EXPECT_EQ(scene_of("[[noise]]\nkind = \"sobol-blue\"\npoints = 8\n[effects.integrand]\n").noises[0].points, 8);
}

}  // namespace
}  // namespace noiseloom::render
