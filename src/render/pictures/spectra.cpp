#include "render/pictures/spectra.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace noiseloom::render {
namespace {

constexpr double ends_of_bands[] = {0.05, 0.15};

std::size_t band_of(double frequency) {
  return frequency < ends_of_bands[0] ? 0 : frequency < ends_of_bands[1] ? 1 : 2;
}

Texture later_half_of(const Texture& errors) {
  const std::int32_t slices = errors.extents.num_slices();
  const std::int32_t first = slices / 2;
  Texture half =
      make_texture(Extents({errors.extents.width(), errors.extents.height(), slices - first}), errors.channels);
  std::copy(errors.slice(SliceIndex(first)), errors.values.data() + errors.values.size(), half.values.data());
  return half;
}

// Summed over channels, each around its mean over all frames: what spectra are scaled by.
double variance_of_errors(const Texture& errors) {
  const auto cells = static_cast<std::size_t>(errors.extents.cells_per_slice());
  double variance = 0;
  for (int c = 0; c < errors.channels; ++c) {
    double sum = 0;
    double squares = 0;
    for (const SliceIndex s : errors.extents.slices()) {
      const float* const plane = errors.slice(s) + static_cast<std::size_t>(c) * cells;
      for (std::size_t i = 0; i < cells; ++i) {
        const double value = static_cast<double>(plane[i]);
        sum += value;
        squares += value * value;
      }
    }
    const double n = static_cast<double>(errors.extents.num_cells());
    variance += std::max(0.0, squares / n - sum / n * sum / n);
  }
  return variance;
}

void scale(PlaneSpectrum& spectrum, double factor) {
  for (double& power : spectrum.power) power *= factor;
}

}  // namespace

ErrorSpectrum error_spectrum(const Texture& errors, bool later_half) {
  if (later_half && errors.extents.num_slices() > 1) return error_spectrum(later_half_of(errors), false);
  ErrorSpectrum result;
  const double variance = variance_of_errors(errors) / errors.channels;
  if (!(variance > 0)) return result;
  const DistanceKind kind = errors.channels == 1 ? DistanceKind::absolute : DistanceKind::euclidean;
  result.across = plane_spectrum(errors, kind, 0, 1);
  result.over_time = plane_spectrum(errors, kind, 0, 2);
  scale(result.across, variance);
  scale(result.over_time, variance);
  const PlaneSpectrum& across = result.across;
  for (int v = 0; v < across.height; ++v)
    for (int u = 0; u < across.width; ++u) {
      const double fx = static_cast<double>(u - across.width / 2) / across.width;
      const double fy = static_cast<double>(v - across.height / 2) / across.height;
      result.bands[band_of(std::sqrt(fx * fx + fy * fy))] +=
          across.at(u, v) / (static_cast<double>(across.width) * across.height);
    }
  const PlaneSpectrum& over_time = result.over_time;
  for (int v = 0; v < over_time.height; ++v)
    for (int u = 0; u < over_time.width; ++u)
      result.in_time[band_of(std::fabs(static_cast<double>(v - over_time.height / 2)) / over_time.height)] +=
          over_time.at(u, v) / (static_cast<double>(over_time.width) * over_time.height);
  return result;
}

std::string spectra_csv(const Result& result) {
  std::string text = "effect,noise,time,over,frequency,power\n";
  const std::size_t spaces = result.stages.size() / std::max<std::size_t>(1, result.num_times());
  for (std::size_t effect = 0; effect < result.effects.size(); ++effect)
    for (std::size_t noise = 0; noise < result.noises.size(); ++noise)
      for (std::size_t time = 0; time < result.num_times(); ++time) {
        const ErrorSpectrum& one = result.spectrum(effect, noise, time);
        if (one.is_empty()) continue;
        const std::string begin = fmt::format("{},{},{}", name_of(result.effects[effect]), result.noises[noise],
                                              result.stages[time * spaces].time);
        for (const SpectrumBin& bin : radial_average(one.across))
          text += fmt::format("{},xy,{:.6g},{:.5g}\n", begin, bin.frequency, bin.power);
        for (const SpectrumBin& bin : row_average(one.over_time))
          text += fmt::format("{},t,{:.6g},{:.5g}\n", begin, bin.frequency, bin.power);
      }
  return text;
}

}  // namespace noiseloom::render
