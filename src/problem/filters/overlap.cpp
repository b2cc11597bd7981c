#include "problem/filters/overlap.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "noiseloom/core/math.h"
#include "problem/filters/eye_filter.h"

namespace noiseloom {
namespace {

// A Gaussian is cut where the sum of its taps reaches this [FAST24, reference tool].
constexpr double gauss_coverage = 0.995;
// gauss_energy: offsets of smaller weight are left out.
constexpr double gauss_energy_cut = 1e-6;

std::vector<double> normalised(std::vector<double> taps) {
  double sum = 0;
  for (const double tap : taps) sum += tap;
  for (double& tap : taps) tap /= sum;
  return taps;
}

// How often each cell of a ring is hit by `count` consecutive taps of weight 1.
std::vector<double> box_taps(std::int64_t count, std::int64_t size) {
  NOISELOOM_CHECK_LE(1, count);
  if (count <= size) return std::vector<double>(static_cast<std::size_t>(count), 1.0);
  std::vector<double> taps(static_cast<std::size_t>(size), static_cast<double>(count / size));
  for (std::int64_t i = 0; i < count % size; ++i) taps[static_cast<std::size_t>(i)] += 1;
  return taps;
}

// The integral of the Gaussian over each pixel, outward from the centre.
std::vector<double> gauss_taps(double sigma) {
  NOISELOOM_CHECK(sigma > 0);
  const double scale = 1 / (sigma * std::sqrt(2.0));
  const auto integral = [&](double from, double to) { return (math::erf(to * scale) - math::erf(from * scale)) / 2; };
  std::vector<double> half = {integral(-0.5, 0.5)};
  double sum = half[0];
  while (sum < gauss_coverage) {
    const auto i = static_cast<double>(half.size());
    half.push_back(integral(i - 0.5, i + 0.5));
    sum += 2 * half.back();
  }
  std::vector<double> taps(half.rbegin(), half.rend());
  taps.insert(taps.end(), half.begin() + 1, half.end());
  return taps;
}

std::vector<double> binomial_taps(int n) {
  NOISELOOM_CHECK_LE(0, n);
  std::vector<double> taps = {1};
  for (int row = 1; row <= n; ++row) {
    taps.push_back(0);
    for (std::size_t k = taps.size() - 1; k > 0; --k) taps[k] = (taps[k] + taps[k - 1]) / 2;
    taps[0] /= 2;
  }
  return taps;
}

// exp(-d^2 / 2 sigma^2) of all images of d on a ring, for d from 0 to half of it.
std::vector<double> gauss_energy_ring(double sigma, std::int64_t size) {
  NOISELOOM_CHECK(sigma > 0);
  constexpr double widest = 9;  // exp(-81/2) is below the rounding of any weight that is kept
  const auto reach = static_cast<std::int64_t>(widest * sigma) + 1;
  std::vector<double> ring;
  for (std::int64_t d = 0; d <= std::min(size / 2, reach); ++d) {
    double sum = 0;
    for (std::int64_t image = d - (reach + d) / size * size; image <= reach; image += size) {
      const double scaled = static_cast<double>(image) / sigma;
      sum += math::exp(-scaled * scaled / 2);
    }
    ring.push_back(sum);
  }
  return ring;
}

// The overlap of a box of that many taps around a ring over its value at 0, d from 0 to half of the ring: 1 everywhere
// where the box covers it.
std::vector<double> box_energy_ring(int box, std::int64_t size) {
  const std::int64_t taps = std::min<std::int64_t>(box, size);
  const auto shared = [&](std::int64_t d) { return static_cast<double>(std::max<std::int64_t>(0, taps - d)); };
  std::vector<double> ring;
  for (std::int64_t d = 0; d <= size / 2 && (d < taps || size - d < taps); ++d) {
    ring.push_back((shared(d) + (d > 0 ? shared(size - d) : 0)) / static_cast<double>(taps));
  }
  return ring;
}

// The cut is on the product, so it is round; partial products that cannot reach it any more are dropped on the way.
Overlap gauss_energy_overlap(const Extents& extents, const GroupSpec& group) {
  Overlap result;
  std::vector<Overlap> factors;
  std::vector<double> largest;
  for (const int axis : group.axes) {
    const auto ring = group.is_box_along(axis)    ? box_energy_ring(group.kernel.box_size, extents.size(axis))
                      : group.is_tile_along(axis) ? std::vector<double>{1}
                                                  : gauss_energy_ring(group.kernel.sigma, extents.size(axis));
    factors.push_back(axis_overlap(extents, axis, ring));
    largest.push_back(*std::max_element(ring.begin(), ring.end()));
  }
  for (std::size_t k = 0; k < factors.size(); ++k) {
    double most_to_come = 1;
    for (std::size_t later = k + 1; later < factors.size(); ++later) most_to_come *= largest[later];
    result = k == 0 ? factors[0] : multiply(result, factors[k]);
    std::erase_if(result.taps, [&](const OverlapTap& tap) { return tap.weight * most_to_come < gauss_energy_cut; });
  }
  return result;
}

std::vector<double> kernel_ring(const KernelSpec& kernel, std::int64_t size) {
  if (kernel.kind == KernelKind::ema) return ema_ring_overlap(kernel.alpha, kernel.rejection, size);
  return ring_overlap(filter_taps(kernel, size), size);
}

}  // namespace

std::int32_t canonical_offset(std::int64_t offset, std::int64_t size) {
  std::int64_t wrapped = offset % size;
  if (wrapped < 0) wrapped += size;
  return narrow<std::int32_t>(wrapped > size / 2 ? wrapped - size : wrapped);
}

std::vector<double> filter_taps(const KernelSpec& kernel, std::int64_t size) {
  switch (kernel.kind) {
    case KernelKind::box:
      return normalised(box_taps(kernel.size, size));
    case KernelKind::gauss:
      return normalised(gauss_taps(kernel.sigma));
    case KernelKind::binomial:
      return normalised(binomial_taps(kernel.n));
    case KernelKind::eye:
      return eye_taps(kernel.frames_per_second, kernel.pixels_per_degree);
    default:
      NOISELOOM_CHECK(false);
      return {};
  }
}

std::vector<double> autocorrelation(std::span<const double> taps) {
  const std::size_t n = taps.size();
  std::vector<double> sums(n, 0.0);
  if (std::all_of(taps.begin(), taps.end(), [&](double tap) { return tap == taps.front(); })) {
    // Equal terms: each sum is the one before it and one term more.
    double sum = 0;
    for (std::size_t terms = 1; terms <= n; ++terms) {
      sum += taps.front() * taps.front();
      sums[n - terms] = sum;
    }
    return sums;
  }
  // Several distances at a time keep a vector unit busy; the terms of each stay in their order.
  constexpr std::size_t lanes = 8;
  for (std::size_t first = 0; first < n; first += lanes) {
    double sum[lanes] = {};
    std::size_t i = 0;
    for (; i + first + lanes <= n; ++i) {
      for (std::size_t lane = 0; lane < lanes; ++lane) sum[lane] += taps[i] * taps[i + first + lane];
    }
    for (; i + first < n; ++i) {
      for (std::size_t lane = 0; i + first + lane < n; ++lane) sum[lane] += taps[i] * taps[i + first + lane];
    }
    std::copy_n(sum, std::min(lanes, n - first), sums.begin() + static_cast<std::ptrdiff_t>(first));
  }
  return sums;
}

std::vector<double> ring_overlap(std::span<const double> taps, std::int64_t size) {
  std::vector<double> folded(std::min(taps.size(), static_cast<std::size_t>(size)), 0.0);
  for (std::size_t i = 0; i < taps.size(); ++i) folded[i % folded.size()] += taps[i];
  const std::vector<double> sums = autocorrelation(folded);
  const auto sum_at = [&](std::size_t d) { return d < sums.size() ? sums[d] : 0.0; };
  const auto ring_size = static_cast<std::size_t>(size);
  std::vector<double> ring(2 * sums.size() > ring_size ? ring_size / 2 + 1 : sums.size());
  // An offset of the ring is both d and d - size.
  ring[0] = sums[0];
  for (std::size_t d = 1; d < ring.size(); ++d) ring[d] = sum_at(d) + sum_at(ring_size - d);
  return ring;
}

std::vector<double> ema_ring_overlap(double alpha, double beta, std::int64_t size) {
  NOISELOOM_CHECK(alpha > 0 && alpha <= 1 && beta >= 0 && beta <= 1);
  const double q = 1 - alpha;
  const double p = 1 - beta;
  // With c_m(d) the overlap of f^(m) of eq. 16 and m = d + 1 + j, j >= 0:
  //   c_m(0) = g + (1 - g) q^2j      c_m(d) = q^d (g + g q q^2j)      g = alpha / (2 - alpha)
  // and the sum over j with weights beta p^(m - 1) is a geometric series. 1 - p q^2 is written without cancellation.
  const double g = alpha / (2 - alpha);
  const double tail = beta == 0 ? 0 : beta / (beta + p * alpha * (2 - alpha));
  const double zero = g + 2 * q / (2 - alpha) * tail;
  const double amplitude = g * (1 + q * tail);
  const double r = p * q;

  // Powers of r up to r^n, or to the last one that is a normal number: what lies below weighs nothing, and would never
  // become zero (the least number of all, times r > 1/2, is rounded to itself).
  const auto n = static_cast<std::size_t>(size);
  std::vector<double> powers;
  double geometric = 0;  // 1 + r + ... + r^(n-1) = (1 - r^n) / (1 - r)
  double next = 1;
  for (std::size_t d = 0; d <= n && next >= std::numeric_limits<double>::min(); ++d) {
    powers.push_back(next);
    if (d < n) geometric += next;
    next *= r;
  }
  const auto power = [&](std::size_t d) { return d < powers.size() ? powers[d] : 0.0; };
  const double one_minus_rn = (beta + p * alpha) * geometric;
  std::vector<double> ring(std::min(powers.size(), n / 2 + 1));
  ring[0] = zero + 2 * amplitude * power(n) / one_minus_rn;
  for (std::size_t d = 1; d < ring.size(); ++d) ring[d] = amplitude * (power(d) + power(n - d)) / one_minus_rn;
  return ring;
}

Overlap axis_overlap(const Extents& extents, int axis, std::span<const double> ring) {
  Overlap result{{axis}, {}};
  const std::int64_t size = extents.size(axis);
  const auto reach = std::ssize(ring) - 1;
  NOISELOOM_CHECK(reach >= 0 && reach <= size / 2);
  for (std::int64_t d = -std::min((size - 1) / 2, reach); d <= reach; ++d) {
    const double weight = ring[static_cast<std::size_t>(std::abs(d))];
    if (weight == 0) continue;
    OverlapTap tap{{}, weight};
    tap.offset[static_cast<std::size_t>(axis)] = narrow<std::int32_t>(d);
    result.taps.push_back(tap);
  }
  return result;
}

std::vector<OverlapTap> ordered(std::vector<OverlapTap> taps) {
  const auto other_slice = [](const OverlapTap& tap) {
    return std::any_of(tap.offset.begin() + 2, tap.offset.end(), [](std::int32_t d) { return d != 0; });
  };
  const auto before = [](const OverlapTap& a, const OverlapTap& b) {
    return std::lexicographical_compare(a.offset.rbegin(), a.offset.rend(), b.offset.rbegin(), b.offset.rend());
  };
  // Products mostly come in order, and may be millions.
  if (!std::is_sorted(taps.begin(), taps.end(), before)) std::stable_sort(taps.begin(), taps.end(), before);
  std::stable_partition(taps.begin(), taps.end(), [&](const OverlapTap& tap) { return !other_slice(tap); });
  std::size_t kept = 0;
  for (const OverlapTap& tap : taps) {
    if (kept > 0 && taps[kept - 1].offset == tap.offset) {
      taps[kept - 1].weight += tap.weight;
    } else {
      taps[kept++] = tap;
    }
  }
  taps.resize(kept);
  std::erase_if(taps, [](const OverlapTap& tap) { return tap.weight == 0; });
  return taps;
}

Overlap multiply(const Overlap& a, const Overlap& b) {
  Overlap result{a.axes, {}};
  std::vector<int> shared;
  for (const int axis : b.axes) {
    const bool both = std::find(a.axes.begin(), a.axes.end(), axis) != a.axes.end();
    (both ? shared : result.axes).push_back(axis);
  }
  const auto add = [&](const OverlapTap& s, const OverlapTap& t) {
    OverlapTap tap{s.offset, s.weight * t.weight};
    for (const int axis : b.axes) tap.offset[static_cast<std::size_t>(axis)] = t.offset[static_cast<std::size_t>(axis)];
    const bool agree = std::all_of(shared.begin(), shared.end(), [&](int axis) {
      return s.offset[static_cast<std::size_t>(axis)] == t.offset[static_cast<std::size_t>(axis)];
    });
    if (agree && tap.weight != 0) result.taps.push_back(tap);
  };
  // The later axis outermost: what `ordered` wants, where the axes of a and b do not interlock.
  const auto last_axis = [](const Overlap& overlap) {
    return overlap.axes.empty() ? -1 : *std::max_element(overlap.axes.begin(), overlap.axes.end());
  };
  if (shared.empty()) result.taps.reserve(a.taps.size() * b.taps.size());
  if (last_axis(a) > last_axis(b)) {
    for (const OverlapTap& s : a.taps) {
      for (const OverlapTap& t : b.taps) add(s, t);
    }
  } else {
    for (const OverlapTap& t : b.taps) {
      for (const OverlapTap& s : a.taps) add(s, t);
    }
  }
  return result;
}

std::vector<Overlap> group_overlaps(const Extents& extents, const GroupSpec& group) {
  NOISELOOM_CHECK(!group.axes.empty());
  for (const int axis : group.axes) NOISELOOM_CHECK(axis >= 0 && axis < extents.num_axes());
  if (group.kernel.kind == KernelKind::table) return table_overlaps(extents, group);
  if (group.kernel.kind == KernelKind::gauss_energy) return {gauss_energy_overlap(extents, group)};
  std::vector<Overlap> overlaps;
  for (const int axis : group.axes) {
    overlaps.push_back(axis_overlap(extents, axis, kernel_ring(group.kernel, extents.size(axis))));
  }
  return overlaps;
}

}  // namespace noiseloom
