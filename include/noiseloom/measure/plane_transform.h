// Discrete Fourier transforms of real planes of one size, there and back (FFTW).
#pragma once

#include <fftw3.h>

#include <complex>
#include <cstddef>
#include <vector>

#include "noiseloom/core/error.h"

namespace noiseloom {

class PlaneTransform {
 public:
  PlaneTransform(int width, int height)
      : width_(width),
        height_(height),
        real_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
        spectrum_(static_cast<std::size_t>(height) * half_width()) {
    auto* const coefficients = reinterpret_cast<fftw_complex*>(spectrum_.data());
    forward_ = fftw_plan_dft_r2c_2d(height, width, real_.data(), coefficients, FFTW_ESTIMATE);
    inverse_ = fftw_plan_dft_c2r_2d(height, width, coefficients, real_.data(), FFTW_ESTIMATE);
    NOISELOOM_CHECK(forward_ != nullptr && inverse_ != nullptr);
  }
  ~PlaneTransform() {
    fftw_destroy_plan(forward_);
    fftw_destroy_plan(inverse_);
  }
  PlaneTransform(const PlaneTransform&) = delete;
  PlaneTransform& operator=(const PlaneTransform&) = delete;

  // Row-major values; forward() reads them, inverse() writes them (scaled by the number of values).
  std::vector<double>& real() { return real_; }
  void forward() { fftw_execute(forward_); }
  void inverse() { fftw_execute(inverse_); }

  // The coefficient at column kx in [0, width), row ky in [0, height), after forward().
  std::complex<double> at(int kx, int ky) const {
    const bool mirrored = kx > width_ / 2;
    const std::size_t x = static_cast<std::size_t>(mirrored ? width_ - kx : kx);
    const std::size_t y = static_cast<std::size_t>(mirrored ? (height_ - ky) % height_ : ky);
    const std::complex<double> value = spectrum_[y * half_width() + x];
    return mirrored ? std::conj(value) : value;
  }
  // Multiplies coefficients by gain(kx, ky) for kx in [0, width/2], ky in [0, height).
  template <class Gain>
  void scale(Gain gain) {
    std::size_t i = 0;
    for (int ky = 0; ky < height_; ++ky)
      for (int kx = 0; kx <= width_ / 2; ++kx) spectrum_[i++] *= gain(kx, ky);
  }

 private:
  std::size_t half_width() const { return static_cast<std::size_t>(width_ / 2 + 1); }

  int width_;
  int height_;
  std::vector<double> real_;
  std::vector<std::complex<double>> spectrum_;
  fftw_plan forward_;
  fftw_plan inverse_;
};

}  // namespace noiseloom
