#include "noiseloom/measure/autocorrelation.h"

#include <algorithm>
#include <cmath>

#include "noiseloom/measure/plane_transform.h"

namespace noiseloom {

Autocorrelation autocorrelation_of(const PlaneSpectrum& spectrum, double num_planes) {
  const int width = spectrum.width;
  const int height = spectrum.height;
  const double count = static_cast<double>(width) * height;
  Autocorrelation result;
  result.width = width;
  result.height = height;
  result.chance = 1 / std::sqrt(count * num_planes);
  // The inverse transform of the power: that of a single one at the origin, with its even spectrum scaled.
  PlaneTransform transform(width, height);
  std::fill(transform.real().begin(), transform.real().end(), 0.0);
  transform.real().front() = 1;
  transform.forward();
  transform.scale([&](int kx, int ky) { return spectrum.at((kx + width / 2) % width, (ky + height / 2) % height); });
  transform.inverse();
  result.values = transform.real();
  const double at_zero = result.values.front();
  for (double& value : result.values) value = at_zero > 0 ? value / at_zero : 0;
  return result;
}

std::vector<CorrelationRing> correlation_rings(const Autocorrelation& correlation) {
  const int last = std::min(correlation.width, correlation.height) / 2;
  std::vector<CorrelationRing> rings(static_cast<std::size_t>(std::max(0, last)));
  std::vector<int> counts(rings.size(), 0);
  for (int dy = 0; dy < correlation.height; ++dy) {
    for (int dx = 0; dx < correlation.width; ++dx) {
      const double x = std::min(dx, correlation.width - dx);
      const double y = std::min(dy, correlation.height - dy);
      const auto distance = static_cast<int>(std::lround(std::sqrt(x * x + y * y)));
      if (distance < 1 || distance > last) continue;
      const auto ring = static_cast<std::size_t>(distance) - 1;
      rings[ring].mean += correlation.at(dx, dy);
      rings[ring].largest = std::max(rings[ring].largest, std::fabs(correlation.at(dx, dy)));
      ++counts[ring];
    }
  }
  for (std::size_t ring = 0; ring < rings.size(); ++ring) {
    rings[ring].distance = static_cast<int>(ring) + 1;
    if (counts[ring] > 0) rings[ring].mean /= counts[ring];
  }
  return rings;
}

int uncorrelated_from(const std::vector<CorrelationRing>& rings, double chance) {
  const double limit = std::max(uncorrelated_limit, 5 * chance);
  int from = static_cast<int>(rings.size()) + 1;
  for (auto ring = rings.rbegin(); ring != rings.rend() && ring->largest <= limit; ++ring) from = ring->distance;
  return from;
}

}  // namespace noiseloom
