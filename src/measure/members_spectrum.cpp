#include <fftw3.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "measure/members_parts.h"
#include "noiseloom/core/error.h"

namespace noiseloom::members {

struct Transforms::Plans {
  fftw_plan forward = nullptr;
  fftw_plan inverse = nullptr;
};

Transforms::Transforms(const Extents& extents)
    : extents_(extents),
      cells_(static_cast<std::size_t>(extents.num_cells())),
      half_(0),
      row_(static_cast<std::size_t>(extents.size(0) / 2 + 1)),
      plans_(std::make_unique<Plans>()) {
  std::vector<int> sizes;
  for (int axis = extents.num_axes(); axis-- > 0;) sizes.push_back(narrow<int>(extents.size(axis)));
  half_ = cells_ / static_cast<std::size_t>(extents.size(0)) * row_;
  std::vector<double> values(cells_);
  std::vector<std::complex<double>> spectrum(half_);
  auto* const coefficients = reinterpret_cast<fftw_complex*>(spectrum.data());
  const int axes = narrow<int>(sizes.size());
  plans_->forward = fftw_plan_dft_r2c(axes, sizes.data(), values.data(), coefficients, FFTW_ESTIMATE | FFTW_UNALIGNED);
  plans_->inverse = fftw_plan_dft_c2r(axes, sizes.data(), coefficients, values.data(), FFTW_ESTIMATE | FFTW_UNALIGNED);
  NOISELOOM_CHECK(plans_->forward != nullptr && plans_->inverse != nullptr);
  const auto height = static_cast<std::size_t>(extents.size(1));
  for (std::size_t k = 0; k < half_; ++k) {
    const std::size_t ky = k / row_ % height;
    const double fx = static_cast<double>(k % row_) / static_cast<double>(extents.size(0));
    const double fy = static_cast<double>(std::min(ky, height - ky)) / static_cast<double>(height);
    bands_.push_back(std::min(num_bands - 1, static_cast<int>(2 * num_bands * std::hypot(fx, fy))));
  }
}

Transforms::~Transforms() {
  fftw_destroy_plan(plans_->forward);
  fftw_destroy_plan(plans_->inverse);
}

double Transforms::weight(std::size_t k) const {
  const std::size_t kx = k % row_;
  return kx == 0 || 2 * kx == static_cast<std::size_t>(extents_.size(0)) ? 1 : 2;
}

double Transforms::frequencies_in_band(int band) const {
  double count = band == bands_[0] ? -1 : 0;  // frequency 0 is none
  for (std::size_t k = 0; k < half_; ++k) count += bands_[k] == band ? weight(k) : 0;
  return count;
}

std::string Transforms::shift_text(std::size_t cell) const {
  std::string text;
  for (int axis = 0; axis < extents_.num_axes(); ++axis) {
    const auto size = static_cast<std::size_t>(extents_.size(axis));
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", extents_.name(axis), cell % size);
    cell /= size;
  }
  return text;
}

void Transforms::forward(std::vector<double>& values, std::vector<std::complex<double>>& spectrum) const {
  fftw_execute_dft_r2c(plans_->forward, values.data(), reinterpret_cast<fftw_complex*>(spectrum.data()));
}

void Transforms::inverse(std::vector<std::complex<double>>& spectrum, std::vector<double>& values) const {
  fftw_execute_dft_c2r(plans_->inverse, reinterpret_cast<fftw_complex*>(spectrum.data()), values.data());
}

MemberSpectrum spectrum_of(const Texture& texture, DistanceKind kind, std::size_t number,
                           const Transforms& transforms) {
  const bool circle = kind == DistanceKind::circle;
  const int signals = circle ? 2 : texture.channels;
  const auto pixels = static_cast<std::size_t>(texture.extents.cells_per_slice());
  MemberSpectrum found;
  found.number = number;
  std::vector<double> values(transforms.cells());
  std::vector<std::complex<double>> spectrum(transforms.half());
  const auto cells = static_cast<double>(transforms.cells());
  double furthest = 0;  // squared, summed over signals
  for (int signal = 0; signal < signals; ++signal) {
    const std::size_t first = found.values.size();
    for (const SliceIndex s : texture.extents.slices()) {
      const float* const plane = texture.slice(s) + (circle ? 0 : static_cast<std::size_t>(signal) * pixels);
      for (std::size_t i = 0; i < pixels; ++i) {
        const double value = static_cast<double>(plane[i]);
        const double angle = 2 * std::numbers::pi * value;
        values[static_cast<std::size_t>(s) * pixels + i] = !circle       ? value
                                                           : signal == 0 ? std::cos(angle)
                                                                         : std::sin(angle);
      }
    }
    for (const double value : values) found.values.push_back(static_cast<float>(value));
    std::sort(found.values.begin() + static_cast<std::ptrdiff_t>(first), found.values.end());
    transforms.forward(values, spectrum);
    const double mean = spectrum[0].real() / cells;
    furthest += std::pow(
        std::max(mean - static_cast<double>(found.values[first]), static_cast<double>(found.values.back()) - mean), 2);
    spectrum[0] = 0;
    for (std::size_t k = 0; k < spectrum.size(); ++k) {
      const double power = transforms.weight(k) * std::norm(spectrum[k]);
      found.power += power;
      found.band_power[transforms.band(k)] += power;
      found.spectrum.emplace_back(spectrum[k]);
    }
  }
  if (found.power > 0) found.peak = cells * std::sqrt(furthest / found.power);
  return found;
}

}  // namespace noiseloom::members
