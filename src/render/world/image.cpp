#include "render/world/image.h"

#include <algorithm>
#include <cmath>

#include "noiseloom/core/math.h"

namespace noiseloom::render {
namespace {

std::vector<float> normalised(const std::vector<double>& taps) {
  double sum = 0;
  for (const double tap : taps) sum += tap;
  std::vector<float> result;
  for (const double tap : taps) result.push_back(static_cast<float>(tap / sum));
  return result;
}

}  // namespace

int inside(int place, int size, Border border) {
  if (border == Border::clamp) return std::clamp(place, 0, size - 1);
  const int rest = place % size;
  return rest < 0 ? rest + size : rest;
}

Image make_image(int width, int height, int channels) {
  Image image{width, height, channels, {}};
  image.values.resize(image.pixels() * static_cast<std::size_t>(channels));
  return image;
}

std::vector<float> taps_of(const SpaceFilterSpec& filter) {
  std::vector<double> taps;
  switch (filter.kernel) {
    case SpaceKernel::box:
      taps.assign(static_cast<std::size_t>(filter.size), 1);
      break;
    case SpaceKernel::gauss: {
      const int radius = static_cast<int>(4 * filter.sigma + 0.5);
      for (int d = -radius; d <= radius; ++d) taps.push_back(math::exp(-d * d / (2 * filter.sigma * filter.sigma)));
      break;
    }
    case SpaceKernel::binomial:
      taps = {1};
      for (int i = 0; i < filter.n; ++i) {
        taps.push_back(0);
        for (std::size_t k = taps.size() - 1; k > 0; --k) taps[k] += taps[k - 1];
      }
      break;
    case SpaceKernel::a_trous:
      taps = {1, 4, 6, 4, 1};
      break;
  }
  return normalised(taps);
}

Image filtered(const Image& image, const std::vector<float>& taps, Border border, Rows rows) {
  const int reach = static_cast<int>(taps.size() / 2);
  const auto width = static_cast<std::size_t>(image.width);
  Image across = make_image(image.width, image.height, image.channels);
  Image result = across;
  rows(image.height, [&](int first, int last) {
    std::vector<float> wide(width + taps.size() - 1);
    for (int c = 0; c < image.channels; ++c)
      for (int y = first; y < last; ++y) {
        const float* const from = image.row(c, y);
        for (int x = -reach; x < image.width + reach; ++x)
          wide[static_cast<std::size_t>(x + reach)] = from[inside(x, image.width, border)];
        float* const to = across.row(c, y);
        for (std::size_t k = 0; k < taps.size(); ++k)
          for (std::size_t x = 0; x < width; ++x) to[x] += taps[k] * wide[x + k];
      }
  });
  rows(image.height, [&](int first, int last) {
    for (int c = 0; c < image.channels; ++c)
      for (int y = first; y < last; ++y) {
        float* const to = result.row(c, y);
        for (int k = -reach; k <= reach; ++k) {
          const float* const from = across.row(c, inside(y + k, image.height, border));
          const float tap = taps[static_cast<std::size_t>(k + reach)];
          for (std::size_t x = 0; x < width; ++x) to[x] += tap * from[x];
        }
      }
  });
  return result;
}

}  // namespace noiseloom::render
