#include "render/world/volume.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "noiseloom/core/math.h"
#include "noiseloom/image/volume.h"
#include "noiseloom/render/noise.h"

namespace noiseloom::render {
namespace {

constexpr int octaves = 5;
constexpr int coarsest = 4;  // cells of the first octave along an axis
constexpr double sky_light = 0.25;

// One octave of value noise: random numbers at the corners of a lattice, between them interpolated smoothly.
class Lattice {
 public:
  Lattice(std::uint64_t seed, int octave) : size_((coarsest << octave) + 1) {
    const auto n = static_cast<std::size_t>(size_);
    values_.resize(n * n * n);
    for (std::size_t i = 0; i < values_.size(); ++i)
      values_[i] = to_unit_float(random_block(seed, purpose_of_density, static_cast<std::uint32_t>(octave), 0, i)[0]);
  }

  double at(double x, double y, double z) const {
    std::array<std::size_t, 3> cell{};
    std::array<double, 3> part{};
    const double place[] = {x, y, z};
    for (std::size_t a = 0; a < 3; ++a) {
      const double scaled = place[a] * (size_ - 1);
      const double floor = std::min(std::floor(scaled), size_ - 2.0);
      cell[a] = static_cast<std::size_t>(floor);
      const double f = scaled - floor;
      part[a] = f * f * (3 - 2 * f);
    }
    double sum = 0;
    for (std::size_t corner = 0; corner < 8; ++corner) {
      double weight = 1;
      std::size_t index = 0;
      for (std::size_t a = 3; a-- > 0;) {
        const std::size_t side = corner >> a & 1;
        weight *= side == 1 ? part[a] : 1 - part[a];
        index = index * static_cast<std::size_t>(size_) + cell[a] + side;
      }
      sum += weight * static_cast<double>(values_[index]);
    }
    return sum;
  }

 private:
  int size_;
  std::vector<float> values_;
};

Grid grid_of(int size) {
  const auto n = static_cast<std::size_t>(size);
  return {size, std::vector<float>(n * n * n)};
}

// Calls set(x, y, z) at every corner, which are 0 to 1 along each axis.
template <class Set>
void fill(Grid& grid, Set set) {
  const double scale = 1.0 / (grid.size - 1);
  std::size_t i = 0;
  for (int z = 0; z < grid.size; ++z)
    for (int y = 0; y < grid.size; ++y)
      for (int x = 0; x < grid.size; ++x) grid.values[i++] = static_cast<float>(set(scale * x, scale * y, scale * z));
}

float bilinear(const Grid& grid, double x, double y, int z) {
  const double last = grid.size - 1.0;
  const double fx = std::min(x * last, std::nextafter(last, 0));
  const double fy = std::min(y * last, std::nextafter(last, 0));
  const int ix = static_cast<int>(fx);
  const int iy = static_cast<int>(fy);
  const double u = fx - ix;
  const double v = fy - iy;
  const auto at = [&](int dx, int dy) { return static_cast<double>(grid.at(ix + dx, iy + dy, z)); };
  return static_cast<float>((1 - v) * ((1 - u) * at(0, 0) + u * at(1, 0)) + v * ((1 - u) * at(0, 1) + u * at(1, 1)));
}

}  // namespace

namespace {

// The value between the middles of voxels, and 0 beyond the box.
double between_voxels(const VolumeBox& box, double x, double y, double z) {
  const std::array<double, 3> place = {x - 0.5, y - 0.5, z - 0.5};
  const std::array<int, 3> sizes = {box.width, box.height, box.depth};
  std::array<int, 3> first{};
  for (std::size_t a = 0; a < 3; ++a) {
    if (!(place[a] > -1 && place[a] < sizes[a])) return 0;
    first[a] = static_cast<int>(std::floor(place[a]));
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    std::array<int, 3> voxel{};
    double weight = 1;
    bool is_inside = true;
    for (std::size_t a = 0; a < 3; ++a) {
      const int side = corner >> a & 1;
      const double part = place[a] - first[a];
      weight *= side == 1 ? part : 1 - part;
      voxel[a] = first[a] + side;
      is_inside = is_inside && voxel[a] >= 0 && voxel[a] < sizes[a];
    }
    if (is_inside) sum += weight * static_cast<double>(box.at(voxel[0], voxel[1], voxel[2]));
  }
  return sum;
}

// The box stands in the middle of the cube, its y upward, where the cube's is downward.
Grid density_of_file(const VolumeSpec& spec) {
  const VolumeBox box = read_volume(spec.file, spec.grid);
  const double most = static_cast<double>(*std::max_element(box.values.begin(), box.values.end()));
  const double side = std::max({box.width, box.height, box.depth});
  Grid grid = grid_of(spec.resolution);
  fill(grid, [&](double x, double y, double z) {
    return spec.extinction / most *
           between_voxels(box, side * (x - 0.5) + 0.5 * box.width, side * (0.5 - y) + 0.5 * box.height,
                          side * (z - 0.5) + 0.5 * box.depth);
  });
  return grid;
}

}  // namespace

Grid make_density(const VolumeSpec& spec) {
  if (spec.density == Density::file) return density_of_file(spec);
  if (spec.density == Density::slab) {
    Grid grid = grid_of(2);
    fill(grid, [&](double, double, double) { return spec.extinction; });
    return grid;
  }
  std::vector<Lattice> noise;
  for (int octave = 0; octave < octaves; ++octave) noise.emplace_back(spec.seed, octave);
  Grid grid = grid_of(spec.resolution);
  fill(grid, [&](double x, double y, double z) {
    double sum = 0;
    double weight = 0.5;
    for (const Lattice& lattice : noise) {
      sum += weight * lattice.at(x, y, z);
      weight /= 2;
    }
    const double r2 = (x - 0.5) * (x - 0.5) + (y - 0.5) * (y - 0.5) + (z - 0.5) * (z - 0.5);
    const double inside = 1 - std::sqrt(r2) / 0.48;  // 1 in the middle, 0 at the surface of a ball
    return spec.extinction * std::clamp(4 * (sum - 0.62 + 0.55 * inside), 0.0, 1.0) * (inside > 0 ? 1 : 0);
  });
  return grid;
}

Grid make_light(const VolumeSpec& spec, const Grid& density) {
  Grid light = grid_of(density.size);
  const auto n = static_cast<std::size_t>(density.size);
  const double step = 1.0 / (density.size - 1);
  for (std::size_t z = 0; z < n; ++z)
    for (std::size_t x = 0; x < n; ++x) {
      double depth = 0;  // from above, which is y = 0
      for (std::size_t y = 0; y < n; ++y) {
        const std::size_t i = (z * n + y) * n + x;
        if (y > 0)
          depth += step * 0.5 * (static_cast<double>(density.values[i]) + static_cast<double>(density.values[i - n]));
        light.values[i] = static_cast<float>(spec.albedo * (sky_light + (1 - sky_light) * math::exp(-0.5 * depth)));
      }
    }
  return light;
}

Columns make_columns(const Grid& density, const Grid& light, int width, int height, ThreadPool& pool) {
  Columns columns{.nodes = density.size, .values = {}};
  const auto nodes = static_cast<std::size_t>(columns.nodes);
  columns.values.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * nodes);
  pool.for_each(height, [&](std::int64_t y, int) {
    std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) * nodes;
    for (int x = 0; x < width; ++x)
      for (int z = 0; z < columns.nodes; ++z, ++i) {
        const double u = (x + 0.5) / width;
        const double v = (static_cast<double>(y) + 0.5) / height;
        columns.values[i] = {bilinear(density, u, v, z), bilinear(light, u, v, z)};
      }
  });
  return columns;
}

double background(int y, int height) { return 0.35 + 0.4 * (y + 0.5) / height; }

}  // namespace noiseloom::render
