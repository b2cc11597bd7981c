#include "noiseloom/measure/autocorrelation.h"

#include <gtest/gtest.h>

#include <random>

namespace noiseloom {
namespace {

// Noise of a seed, blurred over `blur` pixels along x if that is more than 1.
Texture noise(std::int64_t width, std::int64_t height, std::int64_t slices, int blur) {
  Texture texture = make_texture(Extents({width, height, slices}, {"x", "y", "t"}), 1);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<float> unit(0, 1);
  std::vector<float> row(static_cast<std::size_t>(width));
  for (std::size_t first = 0; first < texture.values.size(); first += row.size()) {
    for (float& value : row) value = unit(random);
    for (std::size_t x = 0; x < row.size(); ++x) {
      float sum = 0;
      for (int d = 0; d < blur; ++d) sum += row[(x + static_cast<std::size_t>(d)) % row.size()];
      texture.values[first + x] = sum;
    }
  }
  return texture;
}

double direct(const Texture& texture, std::int64_t dx, std::int64_t dy) {
  const std::int64_t width = texture.extents.width();
  const std::int64_t height = texture.extents.height();
  double products = 0;
  double squares = 0;
  for (const SliceIndex s : texture.extents.slices()) {
    double mean = 0;  // of the slice: its spectrum has no frequency zero
    for (std::int64_t i = 0; i < width * height; ++i) mean += static_cast<double>(texture.slice(s)[i]);
    mean /= static_cast<double>(width * height);
    const auto value = [&](std::int64_t x, std::int64_t y) {
      return static_cast<double>(texture.slice(s)[(y + height) % height * width + (x + width) % width]) - mean;
    };
    for (std::int64_t y = 0; y < height; ++y) {
      for (std::int64_t x = 0; x < width; ++x) {
        products += value(x, y) * value(x + dx, y + dy);
        squares += value(x, y) * value(x, y);
      }
    }
  }
  return products / squares;
}

TEST(Autocorrelation, EqualsTheSumOverPixels) {
  const Texture texture = noise(12, 9, 5, 3);
  const Autocorrelation found = autocorrelation_of(plane_spectrum(texture, DistanceKind::absolute, 0, 1), 5);
  for (int dy = 0; dy < 9; ++dy) {
    for (int dx = 0; dx < 12; ++dx) EXPECT_NEAR(found.at(dx, dy), direct(texture, dx, dy), 1e-9) << dx << " " << dy;
  }
}

TEST(Autocorrelation, SaysFromWhereReadsAreUncorrelated) {
  const auto from = [](const Texture& texture) {
    const Autocorrelation found = autocorrelation_of(plane_spectrum(texture, DistanceKind::absolute, 0, 1),
                                                     static_cast<double>(texture.extents.num_slices()));
    return uncorrelated_from(correlation_rings(found), found.chance);
  };
  EXPECT_EQ(from(noise(64, 64, 32, 1)), 1);
  EXPECT_EQ(from(noise(64, 64, 32, 4)), 4);  // a blur over four pixels reaches three to each side
  const Texture flat = make_texture(Extents({8, 8}, {"x", "y"}), 1);
  EXPECT_GE(from(flat), 1);
}

}  // namespace
}  // namespace noiseloom
