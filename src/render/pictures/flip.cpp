#include "render/pictures/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "noiseloom/core/math.h"

namespace noiseloom::render {
namespace {

using Triple = std::array<double, 3>;

double linear_of_code(double code) { return code <= 0.04045 ? code / 12.92 : math::pow((code + 0.055) / 1.055, 2.4); }

// sRGB's primaries and white, as FLIP's authors have them.
Triple xyz_of_linear(const Triple& c) {
  return {(10135552 * c[0] + 8788810 * c[1] + 4435075 * c[2]) / 24577794,
          (2613072 * c[0] + 8788810 * c[1] + 887015 * c[2]) / 12288897,
          (1425312 * c[0] + 8788810 * c[1] + 70074185 * c[2]) / 73733382};
}
Triple linear_of_xyz(const Triple& c) {
  return {3.241003275 * c[0] - 1.537398934 * c[1] - 0.498615861 * c[2],
          -0.969224334 * c[0] + 1.875930071 * c[1] + 0.041554224 * c[2],
          0.055639423 * c[0] - 0.204011202 * c[1] + 1.057148933 * c[2]};
}

// Of the white of the screen.
Triple white() { return xyz_of_linear({1, 1, 1}); }

// Luminance and two opponent colours, linear in light: what contrast sensitivity is known of.
Triple opponent_of_xyz(const Triple& c) {
  const Triple w = white();
  const double y = c[1] / w[1];
  return {116 * y - 16, 500 * (c[0] / w[0] - y), 200 * (y - c[2] / w[2])};
}
Triple xyz_of_opponent(const Triple& c) {
  const Triple w = white();
  const double y = (c[0] + 16) / 116;
  return {w[0] * (y + c[1] / 500), w[1] * y, w[2] * (y - c[2] / 200)};
}

// CIELAB, the colours as much weaker as they are darker (the Hunt effect).
Triple lab_of_linear(const Triple& linear) {
  const Triple xyz = xyz_of_linear(linear);
  const Triple w = white();
  const auto root = [](double t) {
    constexpr double edge = 6.0 / 29;
    return t > edge * edge * edge ? math::pow(t, 1.0 / 3) : t / (3 * edge * edge) + 4.0 / 29;
  };
  const double y = root(xyz[1] / w[1]);
  const double lightness = 116 * y - 16;
  return {lightness, 0.01 * lightness * 500 * (root(xyz[0] / w[0]) - y),
          0.01 * lightness * 200 * (y - root(xyz[2] / w[2]))};
}

double distance_of_colours(const Triple& a, const Triple& b) {
  return std::fabs(a[0] - b[0]) + std::sqrt((a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

constexpr double power_of_colours = 0.7;

// Large differences of colour are all alike large: the first 40 % of the range take 95 % of the result.
double compressed(double distance, double largest) {
  const double error = math::pow(distance, power_of_colours);
  const double knee = 0.4 * largest;
  return error < knee ? 0.95 * error / knee : 0.95 + 0.05 * (error - knee) / (largest - knee);
}

// Values at whole pixels -radius to radius.
template <class Function>
std::vector<float> sampled(int radius, Function function) {
  std::vector<float> taps;
  for (int i = -radius; i <= radius; ++i) taps.push_back(static_cast<float>(function(i)));
  return taps;
}

// The image, one plane of it, filtered by `across` along x and by `down` along y.
std::vector<float> separable(const std::vector<float>& plane, int width, int height, const std::vector<float>& across,
                             const std::vector<float>& down, Border border, Rows rows) {
  Image image{width, height, 1, plane};
  const int reach = static_cast<int>(across.size() / 2);
  Image between = make_image(width, height, 1);
  Image result = between;
  rows(height, [&](int first, int last) {
    for (int y = first; y < last; ++y)
      for (int x = 0; x < width; ++x) {
        float sum = 0;
        for (int k = -reach; k <= reach; ++k)
          sum += across[static_cast<std::size_t>(k + reach)] * image.row(0, y)[inside(x + k, width, border)];
        between.row(0, y)[x] = sum;
      }
  });
  rows(height, [&](int first, int last) {
    for (int y = first; y < last; ++y)
      for (int k = -reach; k <= reach; ++k) {
        const float* const from = between.row(0, inside(y + k, height, border));
        for (int x = 0; x < width; ++x) result.row(0, y)[x] += down[static_cast<std::size_t>(k + reach)] * from[x];
      }
  });
  return result.values;
}

// What the eye resolves of luminance and of the two opponent colours: sums of Gaussians in degrees, whose transforms
// are the sensitivities a1 exp(-b1 f^2) + a2 exp(-b2 f^2).
struct Sensitivity {
  double a1, b1, a2, b2;
};
constexpr Sensitivity sensitivities[] = {{1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}};

std::vector<float> seen(const std::vector<float>& plane, int width, int height, const Sensitivity& sensitivity,
                        double pixels_per_degree, Border border, Rows rows) {
  const int radius = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * math::pi * math::pi)) * pixels_per_degree));
  const auto gaussian = [&](double b) {
    return sampled(radius, [&](int i) {
      const double degrees = i / pixels_per_degree;
      return math::exp(-math::pi * math::pi * degrees * degrees / b);
    });
  };
  std::vector<float> result(plane.size());
  double whole = 0;
  for (const auto& [a, b] : {std::pair(sensitivity.a1, sensitivity.b1), std::pair(sensitivity.a2, sensitivity.b2)}) {
    if (!(a > 0)) continue;
    const std::vector<float> taps = gaussian(b);
    const double height_of_gaussian = a * std::sqrt(math::pi / b);  // as in one dimension [Andersson20]
    double sum = 0;
    for (const float tap : taps) sum += static_cast<double>(tap);
    whole += height_of_gaussian * sum * sum;
    const std::vector<float> part = separable(plane, width, height, taps, taps, border, rows);
    for (std::size_t i = 0; i < result.size(); ++i) result[i] += static_cast<float>(height_of_gaussian) * part[i];
  }
  for (float& value : result) value /= static_cast<float>(whole);
  return result;
}

// Strength of edges and of points in luminance.
struct Features {
  std::vector<float> edges;
  std::vector<float> points;
};

// Positive taps add up to 1 and negative ones to -1.
std::vector<float> balanced(std::vector<float> taps) {
  float positive = 0;
  float negative = 0;
  for (const float tap : taps) (tap > 0 ? positive : negative) += tap;
  for (float& tap : taps) tap /= tap > 0 ? positive : -negative;
  return taps;
}

Features features_of(const std::vector<float>& luminance, int width, int height, double pixels_per_degree,
                     Border border, Rows rows) {
  const double deviation = 0.5 * 0.082 * pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3 * deviation));
  const auto bell = [&](int i) { return math::exp(-i * i / (2 * deviation * deviation)); };
  std::vector<float> smooth = sampled(radius, bell);
  float sum = 0;
  for (const float tap : smooth) sum += tap;
  for (float& tap : smooth) tap /= sum;
  const auto slope = balanced(sampled(radius, [&](int i) { return -i * bell(i); }));
  const auto bend = balanced(sampled(radius, [&](int i) { return (i * i / (deviation * deviation) - 1) * bell(i); }));
  const auto strength = [&](const std::vector<float>& taps) {
    const auto x = separable(luminance, width, height, taps, smooth, border, rows);
    std::vector<float> length = separable(luminance, width, height, smooth, taps, border, rows);
    for (std::size_t i = 0; i < length.size(); ++i) length[i] = std::sqrt(x[i] * x[i] + length[i] * length[i]);
    return length;
  };
  return {strength(slope), strength(bend)};
}

// A picture as it is looked at: its colours after the eye has blurred them, and its features.
struct Looked {
  std::vector<Triple> colours;
  Features features;
};

Looked look(const Image& image, int channels, double pixels_per_degree, Border border, Rows rows) {
  const std::size_t pixels = image.pixels();
  std::array<std::vector<float>, 3> planes;
  std::vector<float> luminance(pixels);
  for (std::vector<float>& plane : planes) plane.resize(pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    Triple linear;
    for (std::size_t c = 0; c < 3; ++c)
      linear[c] =
          linear_of_code(std::clamp(static_cast<double>(image.values[(channels == 3 ? c : 0) * pixels + i]), 0.0, 1.0));
    const Triple opponent = opponent_of_xyz(xyz_of_linear(linear));
    for (std::size_t c = 0; c < 3; ++c) planes[c][i] = static_cast<float>(opponent[c]);
    luminance[i] = static_cast<float>((opponent[0] + 16) / 116);
  }
  for (std::size_t c = 0; c < 3; ++c)
    planes[c] = seen(planes[c], image.width, image.height, sensitivities[c], pixels_per_degree, border, rows);
  Looked looked{std::vector<Triple>(pixels),
                features_of(luminance, image.width, image.height, pixels_per_degree, border, rows)};
  for (std::size_t i = 0; i < pixels; ++i) {
    Triple linear = linear_of_xyz(xyz_of_opponent(
        {static_cast<double>(planes[0][i]), static_cast<double>(planes[1][i]), static_cast<double>(planes[2][i])}));
    for (double& value : linear) value = std::clamp(value, 0.0, 1.0);
    looked.colours[i] = lab_of_linear(linear);
  }
  return looked;
}

}  // namespace

double flip_error(const Image& a, const Image& b, int channels, Border border, Rows rows, double pixels_per_degree) {
  const Looked first = look(a, channels, pixels_per_degree, border, rows);
  const Looked second = look(b, channels, pixels_per_degree, border, rows);
  const double largest =
      math::pow(distance_of_colours(lab_of_linear({0, 1, 0}), lab_of_linear({0, 0, 1})), power_of_colours);
  double sum = 0;
  for (std::size_t i = 0; i < first.colours.size(); ++i) {
    const double distance = distance_of_colours(first.colours[i], second.colours[i]);
    const double colour = distance > 0 ? std::min(1.0, compressed(distance, largest)) : 0;
    const double feature =
        static_cast<double>(std::max(std::fabs(first.features.edges[i] - second.features.edges[i]),
                                     std::fabs(first.features.points[i] - second.features.points[i])));
    const double of_features = std::sqrt(std::min(1.0, feature / std::sqrt(2.0)));
    if (colour > 0) sum += math::pow(colour, 1 - of_features);
  }
  return sum / static_cast<double>(first.colours.size());
}

}  // namespace noiseloom::render
