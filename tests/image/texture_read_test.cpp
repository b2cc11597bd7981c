#include "noiseloom/image/texture_read.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <set>
#include <utility>

namespace noiseloom {
namespace {

TEST(TextureRead, FirstRoundIsTheTextureItself) {
  const TextureRead read = {.width = 128, .height = 96, .num_slices = 32};
  for (std::int64_t frame = 0; frame < 32; ++frame) {
    const auto place = read.place(frame, 0);
    EXPECT_EQ(place.dx, 0);
    EXPECT_EQ(place.dy, 0);
    EXPECT_EQ(place.slice.value(), frame);
  }
}

TEST(TextureRead, RoundsVisitEveryPlaceOnceBeforeTheyRepeat) {
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(8, 8), std::pair(12, 5), std::pair(7, 30)}) {
    const TextureRead read = {.width = width, .height = height, .num_slices = 3};
    std::set<std::pair<std::int64_t, std::int64_t>> places;
    for (std::int64_t round = 0; round < width * height; ++round) {
      const auto place = read.place(3 * round + 1, 0);
      EXPECT_EQ(place.slice.value(), 1);
      places.emplace(place.dx, place.dy);
    }
    EXPECT_EQ(std::ssize(places), width * height);
    const auto again = read.place(std::int64_t{3} * width * height, 0);
    EXPECT_EQ(again.dx, 0);
    EXPECT_EQ(again.dy, 0);
  }
}

TEST(TextureRead, StepsHaveNoCommonDivisorWithTheSize) {
  for (std::int64_t size = 1; size < 2000; ++size) EXPECT_EQ(std::gcd(round_step(size), size), 1) << size;
}

TEST(TextureRead, ValuesAreFarApart) {
  const TextureRead read = {.width = 64, .height = 64, .num_slices = 4, .values = 16};
  for (int a = 0; a < 16; ++a) {
    // As the definition of R2 has it, to a pixel.
    const double exact_x = std::fmod(0.7548776662466927 * a, 1.0) * 64;
    EXPECT_NEAR(static_cast<double>(read.place(2, a).dx), std::floor(exact_x), 1);
    EXPECT_EQ(read.place(2, a).slice.value(), 2);
    for (int b = 0; b < a; ++b) {
      const auto around = [](std::int64_t d) { return std::min((d + 64) % 64, (64 - d) % 64); };
      const auto dx = around(read.place(2, a).dx - read.place(2, b).dx);
      const auto dy = around(read.place(2, a).dy - read.place(2, b).dy);
      EXPECT_GT(dx * dx + dy * dy, 64) << a << " and " << b;  // 64 / sqrt(16) = 16 would be a perfect lattice
    }
  }
}

TEST(TextureRead, SlicesThatFollowAreUsedOneAfterAnother) {
  const TextureRead read = {.width = 16, .height = 16, .num_slices = 10, .values = 4, .from = ValuesFrom::slices};
  for (std::int64_t frame = 0; frame < 5; ++frame) {
    for (int value = 0; value < 4; ++value) {
      const auto place = read.place(frame, value);
      EXPECT_EQ(place.slice.value(), (frame * 4 + value) % 10);
      EXPECT_EQ(place.dx == 0, frame * 4 + value < 10);
    }
  }
  EXPECT_GE(read.place(std::int64_t{1} << 40, 3).slice.value(), 0);  // no overflow
}

}  // namespace
}  // namespace noiseloom
