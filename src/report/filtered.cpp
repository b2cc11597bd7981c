#include "noiseloom/report/filtered.h"

#include <algorithm>
#include <cmath>

#include "noiseloom/measure/plane_transform.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {
namespace {

constexpr double shown_deviations = 2.5;  // of white noise's error, from mid grey to black or white

std::vector<double> step_estimates(const Texture& texture, SliceIndex slice) {
  const std::size_t cells = static_cast<std::size_t>(texture.extents.cells_per_slice());
  const float* const values = texture.slice(slice);
  std::vector<float> sorted(values, values + cells);
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(cells / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  std::vector<double> estimates(cells);
  for (std::size_t cell = 0; cell < cells; ++cell) estimates[cell] = values[cell] < *middle ? 1 : 0;
  return estimates;
}

// Filtered, less the mean.
std::vector<double> error_after(const std::vector<double>& estimates, const PlaneSpectrum& response) {
  const int width = response.width;
  const int height = response.height;
  PlaneTransform transform(width, height);
  transform.real() = estimates;
  transform.forward();
  transform.scale([&](int kx, int ky) {
    if (kx == 0 && ky == 0) return 0.0;
    return std::sqrt(response.at((kx + width / 2) % width, (ky + height / 2) % height));
  });
  transform.inverse();
  std::vector<double> error = transform.real();
  for (double& e : error) e /= static_cast<double>(error.size());
  return error;
}

double mean_square(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return sum / static_cast<double>(values.size());
}

Picture grey_picture(const std::vector<double>& values, const ValueRange& range, int width, int height) {
  Picture picture{width, height, std::vector<std::uint8_t>(values.size() * 3)};
  for (std::size_t i = 0; i < picture.rgb.size(); ++i)
    picture.rgb[i] = static_cast<std::uint8_t>(quantise(to_unit(range, values[i / 3]), 8));
  return picture;
}

}  // namespace

FilteredError filtered_error(const Texture& texture, SliceIndex slice, const Footprint& footprint) {
  const std::vector<double> estimates = step_estimates(texture, slice);
  const Permutation order = start_permutation(1, slice, texture.extents.cells_per_slice());
  std::vector<double> shuffled(estimates.size());
  for (std::size_t cell = 0; cell < shuffled.size(); ++cell) shuffled[cell] = estimates[order[cell].value()];
  const PlaneSpectrum response = filter_response(footprint);
  const std::vector<double> error = error_after(estimates, response);
  const std::vector<double> white_error = error_after(shuffled, response);
  const double white_square = mean_square(white_error);
  const double reach = white_square > 0 ? shown_deviations * std::sqrt(white_square) : 1;
  const int width = response.width;
  const int height = response.height;
  return {grey_picture(estimates, {0, 1}, width, height), grey_picture(error, {-reach, reach}, width, height),
          grey_picture(white_error, {-reach, reach}, width, height),
          white_square > 0 ? mean_square(error) / white_square : 1};
}

}  // namespace noiseloom
