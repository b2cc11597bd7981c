#include "support/oracle.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "noiseloom/core/random.h"
#include "noiseloom/files/npy.h"

namespace noiseloom::oracle {

Coord coord_of(const Extents& extents, std::int64_t flat) {
  Coord coord{};
  for (int axis = 0; axis < extents.num_axes(); ++axis) {
    coord[static_cast<std::size_t>(axis)] = flat % extents.size(axis);
    flat /= extents.size(axis);
  }
  return coord;
}

std::size_t flat_of(const Extents& extents, const Coord& coord) {
  std::int64_t flat = 0;
  for (int axis = extents.num_axes() - 1; axis >= 0; --axis) {
    const std::int64_t size = extents.size(axis);
    flat = flat * size + (coord[static_cast<std::size_t>(axis)] % size + size) % size;
  }
  return static_cast<std::size_t>(flat);
}

Coord difference(const Coord& a, const Coord& b) {
  Coord result{};
  for (std::size_t k = 0; k < result.size(); ++k) result[k] = a[k] - b[k];
  return result;
}

namespace {

using Lattice = std::map<Coord, double>;  // what is not listed is zero

// Taps of one axis, lattice position 0, 1, ...
std::vector<double> taps(const KernelSpec& kernel) {
  std::vector<double> result;
  if (kernel.kind == KernelKind::box) result.assign(static_cast<std::size_t>(kernel.size), 1.0);
  if (kernel.kind == KernelKind::binomial)
    for (int k = 0; k <= kernel.n; ++k)
      result.push_back(std::exp(std::lgamma(kernel.n + 1) - std::lgamma(k + 1) - std::lgamma(kernel.n - k + 1)));
  if (kernel.kind == KernelKind::gauss) {
    const auto cumulative = [&](double x) { return std::erfc(-x / kernel.sigma / std::sqrt(2.0)) / 2; };
    int reach = 0;
    while (cumulative(reach + 0.5) - cumulative(-reach - 0.5) < 0.995) ++reach;
    for (int i = -reach; i <= reach; ++i) result.push_back(cumulative(i + 0.5) - cumulative(i - 0.5));
  }
  double sum = 0;
  for (const double tap : result) sum += tap;
  for (double& tap : result) tap /= sum;
  return result;
}

Lattice on_axes(const std::vector<int>& axes, const std::vector<double>& along_each) {
  Lattice result = {{Coord{}, 1.0}};
  for (const int axis : axes) {
    Lattice next;
    for (const auto& [coord, weight] : result) {
      for (std::size_t i = 0; i < along_each.size(); ++i) {
        Coord moved = coord;
        moved[static_cast<std::size_t>(axis)] = static_cast<std::int64_t>(i);
        next[moved] = weight * along_each[i];
      }
    }
    result = next;
  }
  return result;
}

// A table with as many dimensions as the group has axes: the last dimension is the lowest axis.
Lattice full_table(std::vector<int> axes, const NpyArray& table) {
  std::sort(axes.begin(), axes.end());
  Lattice result;
  for (std::size_t i = 0; i < table.values.size(); ++i) {
    Coord coord{};
    auto rest = static_cast<std::int64_t>(i);
    for (std::size_t k = 0; k < axes.size(); ++k) {
      const std::int64_t size = table.shape[axes.size() - 1 - k];
      coord[static_cast<std::size_t>(axes[k])] = rest % size;
      rest /= size;
    }
    result[coord] = table.values[i];
  }
  return result;
}

Lattice autocorrelation(const Lattice& filter) {
  Lattice result;
  for (const auto& [i, a] : filter) {
    for (const auto& [j, b] : filter) result[difference(j, i)] += a * b;
  }
  return result;
}

// Eq. 17 of the FAST paper term by term, from f^(1) on, until what is left of the weights cannot matter; already
// wrapped around the axis.
std::vector<double> ema_filter(double alpha, int m) {
  std::vector<double> f;
  for (int i = 0; i < m - 1; ++i) f.push_back(alpha * std::pow(1 - alpha, i));
  f.push_back(std::pow(1 - alpha, m - 1));
  return f;
}
Lattice ema_overlap(const Extents& extents, int axis, double alpha, double beta) {
  std::vector<double> overlap;
  for (int m = 1; m == 1 || std::pow(1 - beta, m - 1) > 1e-17; ++m) {
    const std::vector<double> f = ema_filter(alpha, m);
    const double weight = beta * std::pow(1 - beta, m - 1);
    overlap.resize(f.size());
    for (std::size_t d = 0; d < f.size(); ++d) {
      double sum = 0;
      for (std::size_t k = 0; k + d < f.size(); ++k) sum += f[k] * f[k + d];
      overlap[d] += weight * sum;
    }
  }
  Lattice result;
  for (std::size_t d = 0; d < overlap.size(); ++d) {
    Coord coord{};
    for (const int sign : {1, -1}) {
      coord[static_cast<std::size_t>(axis)] = sign * static_cast<std::int64_t>(d) % extents.size(axis);
      if (d > 0 || sign > 0) result[coord] += overlap[d];
    }
  }
  return result;
}

Lattice product(const Lattice& a, const Lattice& b) {  // of lattices over different axes
  Lattice result;
  for (const auto& [c, x] : a) {
    for (const auto& [d, y] : b) {
      Coord both = c;
      for (std::size_t k = 0; k < both.size(); ++k) both[k] += d[k];
      result[both] = x * y;
    }
  }
  return result;
}

Lattice gauss_energy(const Extents& extents, const GroupSpec& group) {
  const double sigma = group.kernel.sigma;
  const auto reach = static_cast<int>(std::ceil(9 * sigma));
  std::vector<double> along;
  for (int d = -reach; d <= reach; ++d) along.push_back(std::exp(-d * d / (2 * sigma * sigma)));
  std::vector<int> round;
  for (const int axis : group.axes) {
    if (!group.is_box_along(axis)) round.push_back(axis);
  }
  Lattice result;
  for (const auto& [coord, weight] : on_axes(round, along)) {
    Coord centred = coord;
    for (const int axis : round) centred[static_cast<std::size_t>(axis)] -= reach;
    result[centred] = weight;
  }
  for (const int axis : group.kernel.box_axes) {
    const auto taps = static_cast<std::size_t>(std::min<std::int64_t>(group.kernel.box_size, extents.size(axis)));
    const std::vector<double> root(taps, 1 / std::sqrt(static_cast<double>(taps)));
    result = product(result, autocorrelation(on_axes({axis}, root)));
  }
  return result;
}

Lattice group_overlap(const Extents& extents, const GroupSpec& group) {
  const KernelSpec& kernel = group.kernel;
  if (kernel.kind == KernelKind::gauss_energy) return gauss_energy(extents, group);
  if (kernel.kind == KernelKind::ema) {
    Lattice result = {{Coord{}, 1.0}};
    for (const int axis : group.axes) {
      result = product(result, ema_overlap(extents, axis, kernel.alpha, kernel.rejection));
    }
    return result;
  }
  if (kernel.kind == KernelKind::table) {
    const NpyArray table = read_npy(kernel.file);
    return autocorrelation(table.shape.size() == 1 ? on_axes(group.axes, table.values) : full_table(group.axes, table));
  }
  return autocorrelation(on_axes(group.axes, taps(kernel)));
}

}  // namespace

Overlaps overlaps(const Extents& extents, const FilterSpec& filter) {
  const auto num_cells = static_cast<std::size_t>(extents.num_cells());
  Overlaps result(num_cells, filter.combine == Combine::product ? 1.0 : 0.0);
  for (const GroupSpec& group : filter.groups) {
    Overlaps folded(num_cells, 0.0);  // zero off the group's axes
    for (const auto& [d, weight] : group_overlap(extents, group)) folded[flat_of(extents, d)] += weight;
    for (std::size_t flat = 0; flat < num_cells; ++flat) {
      if (group.kernel.kind == KernelKind::gauss_energy && folded[flat] < 1e-6) folded[flat] = 0;
      if (filter.combine == Combine::sum) result[flat] += group.weight * folded[flat];
    }
    if (filter.combine == Combine::sum) continue;
    for (std::size_t flat = 0; flat < num_cells; ++flat) {
      Coord on_group{};
      const Coord d = coord_of(extents, static_cast<std::int64_t>(flat));
      for (const int axis : group.axes) on_group[static_cast<std::size_t>(axis)] = d[static_cast<std::size_t>(axis)];
      result[flat] *= folded[flat_of(extents, on_group)];
    }
  }
  if (filter.combine == Combine::sum) return result;
  for (std::size_t flat = 0; flat < num_cells; ++flat) {  // axes that no group names
    const Coord d = coord_of(extents, static_cast<std::int64_t>(flat));
    for (int axis = 0; axis < extents.num_axes(); ++axis) {
      bool named = false;
      for (const GroupSpec& group : filter.groups) {
        for (const int of_group : group.axes) named = named || of_group == axis;
      }
      if (!named && d[static_cast<std::size_t>(axis)] != 0) result[flat] = 0;
    }
  }
  return result;
}

Overlaps overlaps(const Footprint& footprint) {
  const Extents& extents = footprint.extents();
  Overlaps result(static_cast<std::size_t>(extents.num_cells()), 0.0);
  result[0] = footprint.weight_zero();
  for (const SliceTaps& slice : footprint.slices()) {
    for (const PlaneTap& tap : slice.taps) {
      Coord d{tap.dx, tap.dy};
      for (std::size_t k = 0; k < slice.offset.size(); ++k) d[k + 2] = slice.offset[k];
      result[flat_of(extents, d)] += tap.weight;
    }
  }
  return result;
}

std::vector<double> Texture::sample(std::size_t cell) const {
  const auto per_slice = static_cast<std::size_t>(extents.cells_per_slice());
  std::vector<double> result;
  for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c) {
    result.push_back(values[cell / per_slice * slice_size() + c * per_slice + cell % per_slice]);
  }
  return result;
}

std::vector<float> Texture::list(SliceIndex s) const {
  const auto per_slice = static_cast<std::size_t>(extents.cells_per_slice());
  std::vector<float> result;
  for (std::size_t cell = 0; cell < per_slice; ++cell) {
    for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c) {
      result.push_back(slice(s)[c * per_slice + cell]);
    }
  }
  return result;
}

void Texture::swap(std::size_t a, std::size_t b) {
  const auto per_slice = static_cast<std::size_t>(extents.cells_per_slice());
  for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c) {
    std::swap(values[a / per_slice * slice_size() + c * per_slice + a % per_slice],
              values[b / per_slice * slice_size() + c * per_slice + b % per_slice]);
  }
}

Texture random_texture(const Extents& extents, DistanceKind distance, int channels, std::uint64_t seed) {
  Texture texture{extents, channels, distance, {}};
  const auto num_cells = static_cast<std::size_t>(extents.num_cells());
  texture.values.resize(num_cells * static_cast<std::size_t>(channels));
  const auto per_slice = static_cast<std::size_t>(extents.cells_per_slice());
  std::vector<double> sample;
  for (std::size_t cell = 0; cell < num_cells; ++cell) {
    sample.clear();
    double norm = 0;
    for (std::uint32_t attempt = 0; sample.empty() || (is_between_unit_vectors(distance) && (norm > 1 || norm < 0.01));
         ++attempt) {
      sample.clear();
      norm = 0;
      for (int c = 0; c < channels; ++c) {
        const RandomBlock bits = random_block(seed, Purpose::jitter, static_cast<std::uint32_t>(c), attempt, cell);
        const double u = to_unit_double(bits[0], bits[1]);
        sample.push_back(is_between_unit_vectors(distance) ? 2 * u - 1 : u);
        norm += sample.back() * sample.back();
      }
    }
    for (std::size_t c = 0; c < sample.size(); ++c) {
      const double value = is_between_unit_vectors(distance) ? sample[c] / std::sqrt(norm) : sample[c];
      texture.values[cell / per_slice * texture.slice_size() + c * per_slice + cell % per_slice] =
          static_cast<float>(value);
    }
  }
  return texture;
}

namespace {

double distance(DistanceKind kind, const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t c = 0; c < a.size(); ++c) {
    sum += is_between_unit_vectors(kind) ? a[c] * b[c] : (a[c] - b[c]) * (a[c] - b[c]);
  }
  if (kind == DistanceKind::axis) {  // |a a^T - b b^T| / sqrt(2)
    double squares = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      for (std::size_t j = 0; j < a.size(); ++j) squares += std::pow(a[i] * a[j] - b[i] * b[j], 2);
    }
    return std::sqrt(squares / 2);
  }
  if (kind == DistanceKind::cosine) return 1 - sum;
  if (kind == DistanceKind::manhattan || kind == DistanceKind::chebyshev) {
    double total = 0;
    double largest = 0;
    for (std::size_t c = 0; c < a.size(); ++c) {
      total += std::fabs(a[c] - b[c]);
      largest = std::fmax(largest, std::fabs(a[c] - b[c]));
    }
    return kind == DistanceKind::manhattan ? total : largest;
  }
  if (kind == DistanceKind::angle) return std::acos(std::fmin(1, std::fmax(-1, sum)));
  if (kind == DistanceKind::circle) return std::fmin(std::fabs(a[0] - b[0]), 1 - std::fabs(a[0] - b[0]));
  return kind == DistanceKind::absolute ? std::fabs(a[0] - b[0]) : std::sqrt(sum);
}

// K of FAST and of STBN for samples of a texture.
double value_kernel(const ValueKernelSpec& spec, const Texture& texture, std::size_t a, std::size_t b) {
  const double d = distance(texture.distance, texture.sample(a), texture.sample(b));
  if (spec.kind == ValueKernelKind::distance) return -d;
  const double exponent = static_cast<double>(texture.channels) / texture.extents.num_axes();
  return std::exp(-std::pow(d, exponent) / (spec.sigma_s * spec.sigma_s));
}

std::size_t offset_between(const Extents& extents, std::size_t a, std::size_t b) {
  return flat_of(extents, difference(coord_of(extents, static_cast<std::int64_t>(b)),
                                     coord_of(extents, static_cast<std::int64_t>(a))));
}

std::vector<std::vector<double>> all_samples(const Texture& texture) {
  std::vector<std::vector<double>> samples;
  const auto num_cells = static_cast<std::size_t>(texture.extents.num_cells());
  for (std::size_t cell = 0; cell < num_cells; ++cell) samples.push_back(texture.sample(cell));
  return samples;
}

}  // namespace

double energy(const Overlaps& f, const Texture& texture, const ValueKernelSpec& spec) {
  long double sum = 0;
  for (std::size_t j = 0; j < f.size(); ++j) {
    for (std::size_t k = 0; k < f.size(); ++k) {
      if (j != k) sum += f[offset_between(texture.extents, j, k)] * value_kernel(spec, texture, j, k);
    }
  }
  return static_cast<double>(sum);
}

double swap_delta(const Overlaps& f, const Texture& texture, const ValueKernelSpec& spec, std::size_t a,
                  std::size_t b) {
  Texture after = texture;
  after.swap(a, b);
  long double sum = 0;
  for (std::size_t k = 0; k < f.size(); ++k) {
    for (const std::size_t end : {a, b}) {
      if (k == a || k == b) continue;
      const double change = value_kernel(spec, after, end, k) - value_kernel(spec, texture, end, k);
      sum += f[offset_between(texture.extents, end, k)] * change + f[offset_between(texture.extents, k, end)] * change;
    }
  }
  return static_cast<double>(sum);
}

double mean_over_all_pairs(const Texture& texture) {
  const std::vector<std::vector<double>> samples = all_samples(texture);
  long double sum = 0;
  for (const auto& a : samples) {
    for (const auto& b : samples) sum += distance(texture.distance, a, b);
  }
  const auto n = static_cast<long double>(samples.size());
  return static_cast<double>(sum / (n * n));
}

double mean_distance_on_a_line(std::vector<double> points) {
  std::sort(points.begin(), points.end());
  const auto n = static_cast<double>(points.size());
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) sum += 2 * (2 * static_cast<double>(i) + 1 - n) * points[i];
  return sum / (n * n);
}

std::vector<double> distance_sums(const Overlaps& f, const Texture& texture) {
  const std::vector<std::vector<double>> samples = all_samples(texture);
  const auto per_slice = static_cast<std::size_t>(texture.extents.cells_per_slice());
  std::vector<double> sums(samples.size() / per_slice);
  for (std::size_t j = 0; j < samples.size(); ++j) {
    for (std::size_t k = 0; k < samples.size(); ++k) {
      if (j == k) continue;
      sums[j / per_slice] +=
          f[offset_between(texture.extents, j, k)] * distance(texture.distance, samples[j], samples[k]);
    }
  }
  return sums;
}

double relative_error(const Overlaps& f, const Texture& texture) {
  const std::vector<std::vector<double>> samples = all_samples(texture);
  const std::size_t n = f.size();
  std::vector<long double> m_d(n, 0);
  long double m = 0;
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t k = 0; k < n; ++k) {
      const double d = distance(texture.distance, samples[j], samples[k]);
      m += d;
      m_d[offset_between(texture.extents, j, k)] += d;
    }
  m /= static_cast<long double>(n) * static_cast<long double>(n);
  long double weights = f[0];
  long double coupled = 0;
  for (std::size_t d = 1; d < n; ++d) {
    weights += f[d];
    coupled += f[d] * m_d[d] / static_cast<long double>(n);
  }
  return static_cast<double>((m * weights - coupled) / (m * f[0]));
}

}  // namespace noiseloom::oracle
