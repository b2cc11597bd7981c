// The covariance of the planes of textures, for programs that draw Gaussian noise which is as blue as these: diffusion
// models.
//
// Textures repeat at their edges and no pixel differs from another, so the covariance of two pixels depends on their
// distance alone, around the edges, and the mean spectrum says all of it:
//
//   S(k) = mean |FFT of a plane - its mean|^2 / N        C(p, q) = (1 / N) sum_k S(k) exp(2 pi i k (p - q) / size)
//
// N pixels, the mean over slices and members: S is 1 everywhere for white noise of variance 1. Its factor L is lower
// triangular, L L^T = C: L z of N independent normal numbers z has this covariance. Slices count as planes of their
// own: what connects them is left out.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "noiseloom/core/parallel.h"

namespace noiseloom {

inline constexpr std::int64_t most_covariance_pixels = 4096;  // the factor of 64 x 64 takes 64 MiB

struct PlaneCovariance {
  int width = 0;
  int height = 0;
  std::int64_t planes = 0;
  std::vector<float> mean;      // [height][width], over planes
  std::vector<float> spectrum;  // [height][width], frequency 0 first, as FFTs have it
  std::vector<float> factor;    // [N][N], row-major, N = height * width; zeros above the diagonal
};

// Frequencies without power (stratified planes all have the same mean) are given this share of the mean power, as C has
// no factor otherwise.
inline constexpr double covariance_floor = 1e-6;

// Of run files with one channel and one size. Throws UserError for others, and where a plane has more than
// most_covariance_pixels.
PlaneCovariance plane_covariance(const std::vector<std::string>& run_files, ThreadPool& pool);

// L of a symmetric positive definite matrix, row-major, in place; what stood above the diagonal becomes 0.
void cholesky(std::vector<double>& matrix, std::size_t size, ThreadPool& pool);

}  // namespace noiseloom
