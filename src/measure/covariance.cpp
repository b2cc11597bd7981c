#include "noiseloom/measure/covariance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "noiseloom/core/error.h"
#include "noiseloom/image/texture_file.h"
#include "noiseloom/measure/plane_transform.h"

namespace noiseloom {
namespace {

struct PlaneSums {
  int width = 0;
  int height = 0;
  std::int64_t planes = 0;
  std::vector<double> values;  // summed over planes
  std::vector<double> power;
};

void check_planes(const Texture& texture, const std::string& path, const PlaneSums& sums) {
  if (texture.channels != 1) {
    throw UserError(path, fmt::format("has {} channels; a covariance is made of textures of one", texture.channels));
  }
  if (texture.extents.cells_per_slice() > most_covariance_pixels) {
    throw UserError(path, fmt::format("has {} x {} pixels, whose covariance has too many numbers; at most {} pixels, "
                                      "such as 64 x 64",
                                      texture.extents.size(0), texture.extents.size(1), most_covariance_pixels));
  }
  if (sums.planes > 0 && (texture.extents.size(0) != sums.width || texture.extents.size(1) != sums.height)) {
    throw UserError(path, fmt::format("has {} x {} pixels, and the first member {} x {}", texture.extents.size(0),
                                      texture.extents.size(1), sums.width, sums.height));
  }
}

void add_planes(const Texture& texture, PlaneTransform& transform, PlaneSums& sums) {
  const auto pixels = static_cast<std::size_t>(texture.extents.cells_per_slice());
  for (const SliceIndex s : texture.extents.slices()) {
    const float* const plane = texture.slice(s);
    for (std::size_t i = 0; i < pixels; ++i) {
      transform.real()[i] = static_cast<double>(plane[i]);
      sums.values[i] += static_cast<double>(plane[i]);
    }
    transform.forward();
    std::size_t at = 0;
    for (int ky = 0; ky < sums.height; ++ky) {
      for (int kx = 0; kx < sums.width; ++kx) sums.power[at++] += std::norm(transform.at(kx, ky));
    }
    ++sums.planes;
  }
}

// C(0, q) for every q, from the spectrum: its transform.
std::vector<double> covariance_with_first(const std::vector<double>& spectrum, int width, int height) {
  PlaneTransform transform(width, height);
  transform.real() = spectrum;
  transform.forward();
  std::vector<double> row;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) row.push_back(transform.at(x, y).real() / static_cast<double>(spectrum.size()));
  }
  return row;
}

std::vector<double> covariance_matrix(const std::vector<double>& first, int width, int height) {
  const std::size_t size = first.size();
  std::vector<double> matrix(size * size);
  const auto at = [&](int x, int y) {
    return first[static_cast<std::size_t>((y + height) % height) * static_cast<std::size_t>(width) +
                 static_cast<std::size_t>((x + width) % width)];
  };
  for (std::size_t p = 0; p < size; ++p) {
    for (std::size_t q = 0; q <= p; ++q) {
      const int px = static_cast<int>(p) % width;
      const int py = static_cast<int>(p) / width;
      matrix[p * size + q] = at(px - static_cast<int>(q) % width, py - static_cast<int>(q) / width);
    }
  }
  return matrix;
}

}  // namespace

// Row by row of blocks: each block is lessened by what the columns before it account for, then solved against the
// diagonal block of its column (the left-looking form).
void cholesky(std::vector<double>& matrix, std::size_t size, ThreadPool& pool) {
  constexpr std::size_t block = 64;
  const auto dot = [&](std::size_t i, std::size_t j, std::size_t begin, std::size_t end) {
    const double* const a = matrix.data() + i * size;
    const double* const b = matrix.data() + j * size;
    double sums[8] = {};  // independent, so that they are added in vectors
    std::size_t k = begin;
    for (; k + 8 <= end; k += 8) {
      for (std::size_t lane = 0; lane < 8; ++lane) sums[lane] += a[k + lane] * b[k + lane];
    }
    for (; k < end; ++k) sums[0] += a[k] * b[k];
    return ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]));
  };
  const auto finish_row = [&](std::size_t i, std::size_t column, std::size_t end) {
    for (std::size_t j = column; j < std::min(end, i); ++j) {
      matrix[i * size + j] = (matrix[i * size + j] - dot(i, j, 0, j)) / matrix[j * size + j];
    }
  };
  for (std::size_t column = 0; column < size; column += block) {
    const std::size_t end = std::min(size, column + block);
    for (std::size_t i = column; i < end; ++i) {
      finish_row(i, column, end);
      const double left = matrix[i * size + i] - dot(i, i, 0, i);
      NOISELOOM_CHECK(left > 0);
      matrix[i * size + i] = std::sqrt(left);
    }
    pool.for_each(static_cast<std::int64_t>(size - end),
                  [&](std::int64_t below, int) { finish_row(end + static_cast<std::size_t>(below), column, end); });
  }
  for (std::size_t i = 0; i < size; ++i)
    std::fill_n(matrix.begin() + static_cast<std::ptrdiff_t>(i * size + i + 1), size - i - 1, 0.0);
}

PlaneCovariance plane_covariance(const std::vector<std::string>& run_files, ThreadPool& pool) {
  PlaneSums sums;
  std::unique_ptr<PlaneTransform> transform;
  for (const std::string& path : run_files) {
    const StoredTexture stored = load_stored_texture(path, std::nullopt);
    check_planes(stored.texture, path, sums);
    if (sums.planes == 0) {
      sums.width = static_cast<int>(stored.texture.extents.size(0));
      sums.height = static_cast<int>(stored.texture.extents.size(1));
      sums.values.resize(static_cast<std::size_t>(stored.texture.extents.cells_per_slice()));
      sums.power.resize(sums.values.size());
      transform = std::make_unique<PlaneTransform>(sums.width, sums.height);
    }
    add_planes(stored.texture, *transform, sums);
  }
  NOISELOOM_CHECK(sums.planes > 0);
  const std::size_t size = sums.values.size();
  const double planes = static_cast<double>(sums.planes);
  double mean = 0;
  for (const double value : sums.values) mean += value / planes / static_cast<double>(size);
  // |FFT - that of the common mean|^2: at frequency 0 alone the mean has a part.
  sums.power[0] = std::max(0.0, sums.power[0] - planes * std::pow(mean * static_cast<double>(size), 2));
  double whole = 0;
  for (double& power : sums.power) whole += power /= planes * static_cast<double>(size);
  if (whole <= 0) throw UserError(run_files.front(), "all values are equal: there is no covariance");
  for (double& power : sums.power) power = std::max(power, covariance_floor * whole / static_cast<double>(size));
  std::vector<double> matrix =
      covariance_matrix(covariance_with_first(sums.power, sums.width, sums.height), sums.width, sums.height);
  cholesky(matrix, size, pool);
  PlaneCovariance found;
  found.width = sums.width;
  found.height = sums.height;
  found.planes = sums.planes;
  for (const double value : sums.values) found.mean.push_back(static_cast<float>(value / planes));
  for (const double power : sums.power) found.spectrum.push_back(static_cast<float>(power));
  found.factor.reserve(matrix.size());
  for (const double value : matrix) found.factor.push_back(static_cast<float>(value));
  return found;
}

}  // namespace noiseloom
