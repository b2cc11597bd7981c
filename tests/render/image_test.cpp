#include "render/world/image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace noiseloom::render {
namespace {

const std::vector<SpaceFilterSpec> filters = {{.kernel = SpaceKernel::box, .size = 5},
                                              {.kernel = SpaceKernel::box, .size = 1},
                                              {.kernel = SpaceKernel::gauss, .sigma = 1.3435},
                                              {.kernel = SpaceKernel::gauss, .sigma = 0.1},
                                              {.kernel = SpaceKernel::binomial, .n = 2}};

TEST(SpaceFilter, TapsAddUpToOneAndAreSymmetric) {
  for (const SpaceFilterSpec& filter : filters) {
    const std::vector<float> taps = taps_of(filter);
    EXPECT_EQ(taps.size() % 2, 1U);
    EXPECT_NEAR(std::accumulate(taps.begin(), taps.end(), 0.0), 1, 1e-6);
    for (std::size_t i = 0; i < taps.size(); ++i) EXPECT_EQ(taps[i], taps[taps.size() - 1 - i]);
  }
  EXPECT_EQ(taps_of({.kernel = SpaceKernel::binomial, .n = 2}), (std::vector<float>{0.25, 0.5, 0.25}));
}

// Pictures smaller than the filter, and of one pixel, too.
TEST(SpaceFilter, IsTheDoubleSumOverItsTaps) {
  for (const auto& [width, height] : {std::pair(7, 5), std::pair(3, 2), std::pair(1, 1)})
    for (const Border border : {Border::clamp, Border::wrap})
      for (const SpaceFilterSpec& filter : filters) {
        Image image = make_image(width, height, 2);
        for (std::size_t i = 0; i < image.values.size(); ++i) image.values[i] = static_cast<float>(i * i % 11);
        const std::vector<float> taps = taps_of(filter);
        const int reach = static_cast<int>(taps.size() / 2);
        const Image result = filtered(image, taps, border);
        const auto inside = [&](int place, int size) {
          return border == Border::clamp ? std::min(std::max(place, 0), size - 1) : (place % size + size) % size;
        };
        for (int c = 0; c < 2; ++c)
          for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
              double sum = 0;
              for (int dy = -reach; dy <= reach; ++dy)
                for (int dx = -reach; dx <= reach; ++dx)
                  sum += static_cast<double>(taps[static_cast<std::size_t>(dx + reach)]) *
                         static_cast<double>(taps[static_cast<std::size_t>(dy + reach)]) *
                         static_cast<double>(image.row(c, inside(y + dy, height))[inside(x + dx, width)]);
              EXPECT_NEAR(static_cast<double>(result.row(c, y)[x]), sum, 1e-4);
            }
      }
}

TEST(SpaceFilter, OnATorusKeepsTheMean) {
  Image image = make_image(9, 6, 1);
  for (std::size_t i = 0; i < image.values.size(); ++i) image.values[i] = static_cast<float>(i % 7);
  const auto sum = [](const Image& one) { return std::accumulate(one.values.begin(), one.values.end(), 0.0); };
  for (const SpaceFilterSpec& filter : filters)
    EXPECT_NEAR(sum(filtered(image, taps_of(filter), Border::wrap)), sum(image), 1e-4);
}

}  // namespace
}  // namespace noiseloom::render
