#include "problem/filters/eye_filter.h"

#include <algorithm>
#include <cmath>

#include "noiseloom/core/error.h"
#include "noiseloom/core/math.h"

namespace noiseloom {
namespace {

constexpr double drift_degrees_per_second = 0.15;
constexpr double cycles_per_pixel = 0.375;

constexpr int steps = 4096;  // of frequencies from 0 to half of the frame rate
constexpr std::size_t most_taps_of_a_side = 512;
constexpr double least_tap = 5e-3;

// G over its constant factors.
double sensitivity(double hertz, double cycles_per_degree) {
  const double v = std::max(hertz / cycles_per_degree, drift_degrees_per_second);
  const double octaves = std::fabs(math::log(v / 3) / math::log(10));
  const double a = math::two_pi * cycles_per_degree;
  return (6.1 + 7.3 * octaves * octaves * octaves) * v * math::exp(-2 * a * (v + 2) / 45.9);
}

// At the middles of the steps.
std::vector<double> responses(double frames_per_second, double pixels_per_degree) {
  NOISELOOM_CHECK(frames_per_second > 0 && pixels_per_degree > 0);
  std::vector<double> values;
  for (int i = 0; i < steps; ++i) {
    const double hertz = 0.5 * frames_per_second * (i + 0.5) / steps;
    values.push_back(sensitivity(hertz, cycles_per_pixel * pixels_per_degree));
  }
  const double largest = *std::max_element(values.begin(), values.end());
  for (double& value : values) value /= largest;
  return values;
}

}  // namespace

double eye_response(double hertz, double frames_per_second, double pixels_per_degree) {
  double largest = 0;
  for (int i = 0; i < steps; ++i) {
    const double other = 0.5 * frames_per_second * (i + 0.5) / steps;
    largest = std::max(largest, sensitivity(other, cycles_per_pixel * pixels_per_degree));
  }
  return sensitivity(hertz, cycles_per_pixel * pixels_per_degree) / largest;
}

std::vector<double> eye_taps(double frames_per_second, double pixels_per_degree) {
  const std::vector<double> response = responses(frames_per_second, pixels_per_degree);
  std::vector<double> half;
  for (std::size_t k = 0; k <= most_taps_of_a_side; ++k) {
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
      sum += response[static_cast<std::size_t>(i)] * math::cos_2pi(0.5 * static_cast<double>(k) * (i + 0.5) / steps);
    }
    half.push_back(sum / steps);
  }
  while (half.size() > 1 && std::fabs(half.back()) < least_tap * half.front()) half.pop_back();
  std::vector<double> taps(half.rbegin(), half.rend());
  taps.insert(taps.end(), half.begin() + 1, half.end());
  return taps;
}

}  // namespace noiseloom
