#include "support/void_and_cluster_oracle.h"

#include <algorithm>
#include <cmath>

#include "noiseloom/core/math.h"

namespace noiseloom::oracle {
namespace {

std::vector<std::int64_t> coordinates(const VacSpec& spec, std::size_t p) {
  std::vector<std::int64_t> c;
  auto rest = static_cast<std::int64_t>(p);
  for (int axis = 0; axis < spec.extents.num_axes(); ++axis) {
    c.push_back(rest % spec.extents.size(axis));
    rest /= spec.extents.size(axis);
  }
  return c;
}

// The Gaussian of a difference along one axis, over all images on a torus.
double along(const VacSpec& spec, int axis, std::int64_t d, double sigma) {
  const auto gauss = [&](std::int64_t r) {
    return math::exp(-static_cast<double>(r) * static_cast<double>(r) / (2 * sigma * sigma));
  };
  if (!spec.toroidal.empty() && !spec.toroidal[static_cast<std::size_t>(axis)]) return gauss(d);
  const std::int64_t n = spec.extents.size(axis);
  d = std::abs(d) % n;
  double sum = gauss(d);
  for (std::int64_t k = 1; static_cast<double>(k * n) < 20 * sigma + static_cast<double>(n); ++k) {
    sum += gauss(d + k * n) + gauss(d - k * n);
  }
  return sum;
}

// The share of all runs of `box` slices around the ring with one of two slices so far apart that has both.
double in_box(const VacSpec& spec, std::size_t axis, std::int64_t d, int box) {
  const std::int64_t n = spec.extents.size(static_cast<int>(axis));
  const std::int64_t length = std::min<std::int64_t>(box, n);
  int with_both = 0;
  int with_first = 0;
  for (std::int64_t first = 0; first < n; ++first) {
    const auto has = [&](std::int64_t slice) { return (slice - first + n) % n < length; };
    with_first += has(0) ? 1 : 0;
    with_both += has(0) && has(d) ? 1 : 0;
  }
  return static_cast<double>(with_both) / with_first;
}

bool has(const std::vector<int>& axes, std::size_t axis) {
  return std::find(axes.begin(), axes.end(), static_cast<int>(axis)) != axes.end();
}
bool is_toroidal(const VacSpec& spec, std::size_t axis) { return spec.toroidal.empty() || spec.toroidal[axis]; }

double tail_at(const VacSpec& spec, const std::vector<std::int64_t>& p, const std::vector<std::int64_t>& q,
               const VacGroup& group) {
  if (group.tail == 0) return 0;
  double squared = 0;
  for (std::size_t axis = 0; axis < p.size(); ++axis) {
    if (!has(group.axes, axis) || has(group.box_axes, axis) || has(group.tile_axes, axis)) continue;
    const std::int64_t d = std::abs(p[axis] - q[axis]);
    const std::int64_t around = spec.extents.size(static_cast<int>(axis)) - d;
    const auto shortest = static_cast<double>(is_toroidal(spec, axis) ? std::min(d, around) : d);
    squared += shortest * shortest;
  }
  return group.tail / (group.tail + math::pow(squared, group.tail_power));
}
bool is_another_tile(const std::vector<std::int64_t>& p, const std::vector<std::int64_t>& q, const VacGroup& group) {
  return std::any_of(group.tile_axes.begin(), group.tile_axes.end(),
                     [&](int axis) { return p[static_cast<std::size_t>(axis)] != q[static_cast<std::size_t>(axis)]; });
}
// Whether the shortest way from p to q, of two the one with the larger coordinate, passes an edge in x or y.
bool crosses_an_edge(const VacSpec& spec, const std::vector<std::int64_t>& p, const std::vector<std::int64_t>& q) {
  for (const std::size_t axis : {0U, 1U}) {
    const std::int64_t n = spec.extents.size(static_cast<int>(axis));
    const std::int64_t d = q[axis] - p[axis];
    if (is_toroidal(spec, axis) && (d > n / 2 || d < -((n - 1) / 2))) return true;
  }
  return false;
}

// Whether two pixels are apart along the box axes of a group alone.
bool is_same_pixel(const std::vector<std::int64_t>& p, const std::vector<std::int64_t>& q, const VacGroup& group) {
  if (group.box_axes.empty()) return false;
  for (std::size_t axis = 0; axis < p.size(); ++axis) {
    if (!has(group.box_axes, axis) && p[axis] != q[axis]) return false;
  }
  return true;
}

// The weight of every pair of pixels, in units of 2^-scale_log2.
std::vector<std::int64_t> weights_of(const VacSpec& spec, int scale_log2) {
  const auto n = static_cast<std::size_t>(spec.extents.num_cells());
  std::vector<std::int64_t> weights(n * n);
  std::vector<std::int64_t> same_pixel(n * n);  // in how many groups
  std::vector<std::vector<std::int64_t>> at;
  for (std::size_t p = 0; p < n; ++p) at.push_back(coordinates(spec, p));
  for (const VacGroup& group : spec.groups) {
    const auto in_group = [&](std::size_t axis) {
      return std::find(group.axes.begin(), group.axes.end(), static_cast<int>(axis)) != group.axes.end();
    };
    const std::size_t num_axes = at[0].size();
    std::vector<std::vector<double>> gauss(num_axes);  // by |difference|
    for (std::size_t axis = 0; axis < num_axes; ++axis) {
      const bool is_box = has(group.box_axes, axis);
      for (std::int64_t d = 0; d < spec.extents.size(static_cast<int>(axis)); ++d) {
        gauss[axis].push_back(is_box ? in_box(spec, axis, d, group.box_size)
                                     : along(spec, static_cast<int>(axis), d, group.sigma_px));
      }
    }
    for (std::size_t p = 0; p < n; ++p) {
      for (std::size_t q = 0; q < n; ++q) {
        double product = p == q ? 0 : group.weight;
        double round = 1;
        for (std::size_t axis = 0; axis < num_axes; ++axis) {
          const auto d = static_cast<std::size_t>(std::abs(at[p][axis] - at[q][axis]));
          if (has(group.tile_axes, axis)) continue;
          const double factor = in_group(axis) ? gauss[axis][d] : d == 0 ? 1 : 0;
          (in_group(axis) && !has(group.box_axes, axis) ? round : product) *= factor;
        }
        product *= std::max(round, tail_at(spec, at[p], at[q], group));
        if (!group.tile_axes.empty()) {
          const bool crosses = crosses_an_edge(spec, at[p], at[q]);
          if (!crosses && is_another_tile(at[p], at[q], group)) product = 0;
          for (const int axis : group.tile_axes) product /= crosses ? static_cast<double>(spec.extents.size(axis)) : 1;
        }
        if (product > 0 && is_same_pixel(at[p], at[q], group)) {
          ++same_pixel[p * n + q];
          continue;
        }
        weights[p * n + q] += static_cast<std::int64_t>(std::floor(std::ldexp(product, scale_log2) + 0.5));
      }
    }
  }
  // As much as all other weights together; on a torus every pixel has the same.
  std::int64_t others = 0;
  for (std::size_t q = 0; q < n; ++q) others += weights[q];
  for (std::size_t i = 0; i < weights.size(); ++i) weights[i] += same_pixel[i] * others;
  return weights;
}

}  // namespace

VoidAndClusterOracle::VoidAndClusterOracle(const VacSpec& spec, int scale_log2)
    : spec_(spec), n_(static_cast<std::size_t>(spec.extents.num_cells())), weights_(weights_of(spec, scale_log2)) {}

std::int64_t VoidAndClusterOracle::largest_energy() const {
  std::int64_t largest = 0;
  for (std::size_t p = 0; p < n_; ++p) {
    std::int64_t sum = 0;
    for (std::size_t q = 0; q < n_; ++q) sum += weight(p, q);
    largest = std::max(largest, sum);
  }
  return largest;
}

std::vector<std::uint64_t> VoidAndClusterOracle::order() {
  std::vector<std::uint64_t> places(n_);
  on_.assign(n_, false);
  energy_.assign(n_, 0);
  const auto start = vac_start_pattern(spec_);
  for (const std::uint64_t p : start) flip(p);
  num_swaps_ = 0;
  while (!start.empty()) {
    const std::size_t cluster = extreme(true);
    flip(cluster);
    const std::size_t gap = extreme(false);
    flip(gap);
    if (gap == cluster) break;
    ++num_swaps_;
  }
  const std::vector<bool> pattern = on_;
  for (std::uint64_t place = start.size(); place > 0; --place) {
    const std::size_t cluster = extreme(true);
    flip(cluster);
    places[cluster] = place - 1;
  }
  for (std::size_t p = 0; p < n_; ++p) {
    if (pattern[p]) flip(p);
  }
  for (std::uint64_t place = start.size(); place < n_; ++place) {
    const std::size_t gap = extreme(false);
    flip(gap);
    places[gap] = place;
  }
  return places;
}

void VoidAndClusterOracle::flip(std::size_t p) {
  on_[p] = !on_[p];
  for (std::size_t q = 0; q < n_; ++q) energy_[q] += on_[p] ? weight(p, q) : -weight(p, q);
}

std::size_t VoidAndClusterOracle::extreme(bool largest_on) const {
  const VacTieHash hash(spec_.seed);
  std::size_t best = n_;
  for (std::size_t p = 0; p < n_; ++p) {
    if (on_[p] != largest_on) continue;
    bool better = best == n_;
    if (!better && energy_[p] != energy_[best]) {
      better = (energy_[p] > energy_[best]) == largest_on;
    } else if (!better) {
      better = (hash(p) > hash(best)) == largest_on;  // no two hashes are equal below 2^32 pixels
    }
    if (better) best = p;
  }
  return best;
}

}  // namespace noiseloom::oracle
