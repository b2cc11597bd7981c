#include "render/pictures/a_trous.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "render/world/volume.h"

namespace noiseloom::render {
namespace {

constexpr int reach_of_level = 2;
constexpr std::array<float, 5> taps_of_level = {0.0625F, 0.25F, 0.375F, 0.25F, 0.0625F};
constexpr int reach_of_variance = 3;

// Where nothing varies only what is alike is averaged.
constexpr float hair_of_brightness = 1e-6F;

class Level {
 public:
  Level(const Image& image, int channels, const std::vector<float>& variance, const Hits* hits,
        const SpaceFilterSpec& filter, int step, Border border)
      : image_(image),
        channels_(channels),
        variance_(variance),
        brightness_(brightness_of(image, channels)),
        hits_(hits),
        filter_(filter),
        step_(step),
        border_(border) {
    filter_.depth *= step;  // surfaces are told apart at the distance of the taps
    const auto has = [&](const char* edge) {
      return std::find(filter.edges.begin(), filter.edges.end(), edge) != filter.edges.end();
    };
    by_depth_ = has("depth");
    by_normal_ = has("normal");
  }

  void run(int first, int last, Image& result, std::vector<float>& variance) const {
    Row row(image_.width, reach_of_level * step_, channels_);
    for (int y = first; y < last; ++y) filter_row(y, row, result, variance);
  }

 private:
  // What a row of pixels adds up, and the row of taps that is added, with what lies beyond its ends.
  struct Row {
    Row(int width, int reach, int channels)
        : scale(static_cast<std::size_t>(width)),
          weights(scale.size()),
          variances(scale.size()),
          sums(static_cast<std::size_t>(channels), std::vector<float>(scale.size())),
          tap_brightness(scale.size() + 2 * static_cast<std::size_t>(reach)),
          tap_variance(tap_brightness.size()),
          tap_values(static_cast<std::size_t>(channels), std::vector<float>(tap_brightness.size())) {}

    std::vector<float> scale;  // of differences of brightness
    std::vector<float> weights;
    std::vector<float> variances;
    std::vector<std::vector<float>> sums;  // [channel]
    std::vector<float> tap_brightness;
    std::vector<float> tap_variance;
    std::vector<std::vector<float>> tap_values;
  };

  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(inside(y, image_.height, border_)) * static_cast<std::size_t>(image_.width) +
           static_cast<std::size_t>(inside(x, image_.width, border_));
  }

  // The variance itself is noisy: 3 x 3 pixels of it tell more.
  float variance_near(int x, int y) const {
    float sum = 0;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        sum += variance_[index(x + dx, y + dy)] / static_cast<float>((1 + std::abs(dx)) * (1 + std::abs(dy)) * 4);
    return sum;
  }

  void read_taps(int y, Row& row) const {
    const int reach = reach_of_level * step_;
    for (int x = -reach; x < image_.width + reach; ++x) {
      const std::size_t tap = index(x, y);
      const auto to = static_cast<std::size_t>(x + reach);
      row.tap_brightness[to] = brightness_[tap];
      row.tap_variance[to] = variance_[tap];
      for (std::size_t c = 0; c < row.tap_values.size(); ++c)
        row.tap_values[c][to] = image_.values[c * image_.pixels() + tap];
    }
  }

  float edge(int x, int y, int tap_x, int tap_y) const {
    if (hits_ == nullptr) return 1;
    return static_cast<float>(
        edge_weight(hits_->hits[index(x, y)], hits_->hits[index(tap_x, tap_y)], filter_, by_depth_, by_normal_));
  }

  void filter_row(int y, Row& row, Image& result, std::vector<float>& variance) const {
    const auto width = static_cast<std::size_t>(image_.width);
    const float* const middle = brightness_.data() + index(0, y);
    for (int x = 0; x < image_.width; ++x)
      row.scale[static_cast<std::size_t>(x)] =
          1 / (static_cast<float>(filter_.luminance) * std::sqrt(variance_near(x, y)) + hair_of_brightness);
    std::fill(row.weights.begin(), row.weights.end(), 0.0F);
    std::fill(row.variances.begin(), row.variances.end(), 0.0F);
    for (std::vector<float>& sums : row.sums) std::fill(sums.begin(), sums.end(), 0.0F);
    for (int dy = -reach_of_level; dy <= reach_of_level; ++dy) {
      read_taps(y + dy * step_, row);
      for (int dx = -reach_of_level; dx <= reach_of_level; ++dx) {
        const float kernel = taps_of_level[static_cast<std::size_t>(dx + reach_of_level)] *
                             taps_of_level[static_cast<std::size_t>(dy + reach_of_level)];
        const auto shift = static_cast<std::size_t>((dx + reach_of_level) * step_);
        for (std::size_t x = 0; x < width; ++x) {
          const std::size_t tap = x + shift;
          const float weight = kernel * exp_minus(std::fabs(row.tap_brightness[tap] - middle[x]) * row.scale[x]) *
                               edge(static_cast<int>(x), y, static_cast<int>(x) + dx * step_, y + dy * step_);
          row.weights[x] += weight;
          row.variances[x] += weight * weight * row.tap_variance[tap];
          for (std::size_t c = 0; c < row.sums.size(); ++c) row.sums[c][x] += weight * row.tap_values[c][tap];
        }
      }
    }
    const std::size_t here = index(0, y);
    for (std::size_t x = 0; x < width; ++x) {
      for (std::size_t c = 0; c < row.sums.size(); ++c)
        result.values[c * image_.pixels() + here + x] = row.sums[c][x] / row.weights[x];
      variance[here + x] = row.variances[x] / (row.weights[x] * row.weights[x]);
    }
  }

  const Image& image_;
  int channels_;
  const std::vector<float>& variance_;
  std::vector<float> brightness_;
  const Hits* hits_;
  SpaceFilterSpec filter_;
  int step_;
  Border border_;
  bool by_depth_ = false;
  bool by_normal_ = false;
};

}  // namespace

std::vector<float> brightness_of(const Image& image, int channels) {
  const std::size_t pixels = image.pixels();
  std::vector<float> brightness(image.values.begin(), image.values.begin() + static_cast<std::ptrdiff_t>(pixels));
  if (channels < 3) return brightness;
  for (std::size_t i = 0; i < pixels; ++i)
    brightness[i] =
        0.2126F * image.values[i] + 0.7152F * image.values[pixels + i] + 0.0722F * image.values[2 * pixels + i];
  return brightness;
}

std::vector<float> variance_around(const std::vector<float>& brightness, int width, int height, Border border,
                                   Rows rows) {
  std::vector<float> variance(brightness.size());
  constexpr float count = (2 * reach_of_variance + 1) * (2 * reach_of_variance + 1);
  rows(height, [&](int first, int last) {
    for (int y = first; y < last; ++y)
      for (int x = 0; x < width; ++x) {
        float sum = 0;
        float squares = 0;
        for (int dy = -reach_of_variance; dy <= reach_of_variance; ++dy)
          for (int dx = -reach_of_variance; dx <= reach_of_variance; ++dx) {
            const float value =
                brightness[static_cast<std::size_t>(inside(y + dy, height, border)) * static_cast<std::size_t>(width) +
                           static_cast<std::size_t>(inside(x + dx, width, border))];
            sum += value;
            squares += value * value;
          }
        const float mean = sum / count;
        variance[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] =
            std::max(0.0F, squares / count - mean * mean);
      }
  });
  return variance;
}

Image a_trous(const Image& image, int channels, std::vector<float> variance, const Hits* hits,
              const SpaceFilterSpec& filter, Border border, Rows rows) {
  Image now = image;
  for (int level = 0; level < filter.levels; ++level) {
    Image next = now;
    std::vector<float> variance_of_next(variance.size());
    const Level one(now, channels, variance, hits, filter, 1 << level, border);
    rows(image.height, [&](int first, int last) { one.run(first, last, next, variance_of_next); });
    now = std::move(next);
    variance = std::move(variance_of_next);
  }
  return now;
}

std::int64_t a_trous_taps(const SpaceFilterSpec& filter) { return std::int64_t{filter.levels} * (25 + 9); }

}  // namespace noiseloom::render
