#include "render/pictures/a_trous.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace noiseloom::render {
namespace {

Image picture_of_numbers(int width, int height, int channels) {
  Image image = make_image(width, height, channels);
  for (std::size_t i = 0; i < image.values.size(); ++i) image.values[i] = static_cast<float>(i * 37 % 101) / 101;
  return image;
}

std::vector<float> same_variance(const Image& image, float variance) {
  return std::vector<float>(image.pixels(), variance);
}

// Where brightness hardly counts it is a chain of linear filters, each with holes of its own size.
TEST(ATrous, WithoutGuidanceIsAChainOfLinearFilters) {
  const Image image = picture_of_numbers(23, 19, 2);
  const SpaceFilterSpec filter{.kernel = SpaceKernel::a_trous, .levels = 3, .luminance = 1000};
  const Image result = a_trous(image, 1, same_variance(image, 1e8F), nullptr, filter, Border::wrap, {});
  std::vector<double> now(image.values.begin(), image.values.begin() + 23 * 19);
  constexpr double taps[] = {1, 4, 6, 4, 1};
  for (const int step : {1, 2, 4}) {
    std::vector<double> next(now.size());
    for (int y = 0; y < 19; ++y)
      for (int x = 0; x < 23; ++x)
        for (int dy = -2; dy <= 2; ++dy)
          for (int dx = -2; dx <= 2; ++dx)
            next[static_cast<std::size_t>(y * 23 + x)] +=
                taps[dx + 2] * taps[dy + 2] / 256 *
                now[static_cast<std::size_t>((y + dy * step + 38) % 19 * 23 + (x + dx * step + 46) % 23)];
    now = next;
  }
  for (std::size_t i = 0; i < now.size(); ++i) EXPECT_NEAR(static_cast<double>(result.values[i]), now[i], 1e-4);
  // What is no estimate stays as it is.
  for (std::size_t i = now.size(); i < image.values.size(); ++i) EXPECT_EQ(result.values[i], image.values[i]);
}

TEST(ATrous, WithoutNoiseNothingIsBlurred) {
  const Image image = picture_of_numbers(16, 12, 3);
  const SpaceFilterSpec filter{.kernel = SpaceKernel::a_trous};
  const Image result = a_trous(image, 3, same_variance(image, 0), nullptr, filter, Border::clamp, {});
  for (std::size_t i = 0; i < image.values.size(); ++i) EXPECT_NEAR(result.values[i], image.values[i], 1e-5);
}

TEST(ATrous, IsTheSameOnAnyNumberOfThreads) {
  const Image image = picture_of_numbers(40, 37, 3);
  const SpaceFilterSpec filter{.kernel = SpaceKernel::a_trous, .levels = 4};
  const auto run = [&](Rows rows) {
    return a_trous(image, 3, variance_around(brightness_of(image, 3), 40, 37, Border::clamp, rows), nullptr, filter,
                   Border::clamp, rows);
  };
  const std::vector<float> alone = run({}).values;
  for (const int threads : {2, 5}) {
    ThreadPool pool(threads);
    EXPECT_EQ(run({&pool}).values, alone);
  }
}

TEST(ATrous, KeepsToItsSurface) {
  ThreadPool pool(1);
  const Hits hits = make_hits(48, 40, pool);
  Image image = make_image(48, 40, 1);
  for (std::size_t i = 0; i < image.values.size(); ++i) image.values[i] = hits.hits[i].shape == Shape::sphere ? 1 : 0;
  const auto across = [&](const std::vector<std::string>& edges) {
    const SpaceFilterSpec filter{.kernel = SpaceKernel::a_trous, .levels = 3, .edges = edges};
    const Image result =
        a_trous(image, 1, same_variance(image, 100), edges.empty() ? nullptr : &hits, filter, Border::clamp, {});
    double sum = 0;
    for (std::size_t i = 0; i < image.values.size(); ++i)
      sum += std::fabs(static_cast<double>(result.values[i]) - static_cast<double>(image.values[i]));
    return sum;
  };
  EXPECT_LT(across({"depth", "normal"}), 0.25 * across({}));
}

TEST(ATrous, VarianceAmongNeighboursIsThatOfTheirValues) {
  const Image image = picture_of_numbers(9, 8, 1);
  const std::vector<float> variance = variance_around(image.values, 9, 8, Border::wrap, {});
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 9; ++x) {
      double sum = 0;
      double squares = 0;
      for (int dy = -3; dy <= 3; ++dy)
        for (int dx = -3; dx <= 3; ++dx) {
          const double value =
              static_cast<double>(image.values[static_cast<std::size_t>((y + dy + 8) % 8 * 9 + (x + dx + 9) % 9)]);
          sum += value / 49;
          squares += value * value / 49;
        }
      EXPECT_NEAR(static_cast<double>(variance[static_cast<std::size_t>(y * 9 + x)]), squares - sum * sum, 1e-6);
    }
}

}  // namespace
}  // namespace noiseloom::render
