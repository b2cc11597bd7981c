#include "construct/stamp_kernel.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "noiseloom/core/math.h"
#include "noiseloom/problem/footprint.h"

namespace noiseloom {
namespace {

// Weights below this share of that of offset zero are left out. On 64x64x32, gauss 1.3435 x ema, R is 0.0462 with all
// weights and with this cut, and 0.0463 with one of 2^-10; footprints shrink to half.
constexpr double smallest_share = 0x1p-12;

using Plane = std::map<std::pair<std::int32_t, std::int32_t>, double>;  // by (dy, dx)
using Planes = std::map<Extents::SliceCoord, Plane>;

double sharpened(double value, double largest, double sharpness) {
  const double ratio = math::pow(std::abs(value) / largest, sharpness);
  return std::copysign(largest * ratio, value);
}

// Adds `weight` times the sharpened overlap. Returns what it adds at offset zero, which is not among the planes.
double add_overlap(const Footprint& overlap, double sharpness, double weight, Planes& planes) {
  double zero = 0;
  for (const SliceTaps& slice : overlap.slices()) {
    const bool own = slice.offset == Extents::SliceCoord{};
    double largest = own ? std::abs(overlap.weight_zero()) : 0;
    for (const PlaneTap& tap : slice.taps) largest = std::max(largest, std::abs(tap.weight));
    if (!(largest > 0)) continue;
    if (own) zero = weight * sharpened(overlap.weight_zero(), largest, sharpness);
    Plane& plane = planes[slice.offset];
    for (const PlaneTap& tap : slice.taps) {
      const double value = sharpened(tap.weight, largest, sharpness);
      if (std::abs(value) >= smallest_share * std::abs(overlap.weight_zero()))
        plane[{tap.dy, tap.dx}] += weight * value;
    }
  }
  return zero;
}

double weight_of(const FilterSpec& filter, const GroupSpec& group) {
  return group.weight > 0 ? group.weight : 1.0 / static_cast<double>(filter.groups.size());
}

// Every offset of the kernel but zero; returns the weight of offset zero.
double sharpened_planes(const Extents& extents, const FilterSpec& filter, double sharpness, Planes& planes) {
  planes[Extents::SliceCoord{}];
  if (filter.combine == Combine::product) return add_overlap(Footprint(extents, filter), sharpness, 1, planes);
  double zero = 0;
  for (const GroupSpec& group : filter.groups) {
    const Footprint overlap(extents, {Combine::product, {group}});
    zero += add_overlap(overlap, sharpness, weight_of(filter, group), planes);
  }
  return zero;
}

std::int64_t rounded(double weight, double scale) {
  return static_cast<std::int64_t>(std::floor(weight * scale + 0.5));
}

// The magnitudes of all rounded weights together.
double magnitude(const Planes& planes, double scale) {
  double sum = 0;
  for (const auto& [offset, plane] : planes) {
    for (const auto& [at, weight] : plane) sum += std::abs(static_cast<double>(rounded(weight, scale)));
  }
  return sum;
}

// The rows of a plane that are left when weights are rounded, by dy.
using Rows = std::map<std::int32_t, std::map<std::int32_t, std::int64_t>>;

Rows rounded_rows(const Plane& plane, double scale) {
  Rows rows;
  for (const auto& [at, weight] : plane) {
    if (const std::int64_t integer = rounded(weight, scale); integer != 0) rows[at.first][at.second] = integer;
  }
  return rows;
}

class RowWriter {
 public:
  explicit RowWriter(std::vector<std::uint32_t>& weights) : weights_(weights) {}

  SliceStamp stamp(const Extents::SliceCoord& offset, const Rows& rows) {
    SliceStamp stamp{.offset = offset};
    for (const auto& [dy, row] : rows) {
      stamp.left = std::max(stamp.left, -row.begin()->first);
      stamp.right = std::max(stamp.right, row.rbegin()->first);
      stamp.up = std::max(stamp.up, -dy);
      stamp.down = std::max(stamp.down, dy);
    }
    stamp.is_narrow = stamp.left + stamp.right < static_cast<std::int32_t>(StampKernel::vector_words);
    for (const auto& [dy, row] : rows) {
      const std::int32_t lo = stamp.is_narrow ? stamp.left : -row.begin()->first;
      const std::int32_t hi = stamp.is_narrow ? stamp.right : row.rbegin()->first;
      stamp.rows.push_back({dy, lo, hi, append(lo, hi, row)});
    }
    return stamp;
  }

 private:
  // Returns where the row begins. Equal rows stand there once: of symmetric overlaps a quarter is left.
  std::size_t append(std::int32_t lo, std::int32_t hi, const std::map<std::int32_t, std::int64_t>& row) {
    constexpr std::size_t vector = StampKernel::vector_words;
    std::vector<std::uint32_t> words((static_cast<std::size_t>(lo + hi) / vector + 1) * vector);
    for (const auto& [dx, weight] : row) words[static_cast<std::size_t>(lo + dx)] = static_cast<std::uint32_t>(weight);
    const auto [known, is_new] = known_.try_emplace(words, weights_.size());
    if (is_new) weights_.insert(weights_.end(), words.begin(), words.end());
    return known->second;
  }

  std::vector<std::uint32_t>& weights_;
  std::map<std::vector<std::uint32_t>, std::size_t> known_;
};

}  // namespace

StampKernel::StampKernel(const Extents& extents, const FilterSpec& filter, double sharpness, int energy_bits)
    : extents_(extents) {
  NOISELOOM_CHECK(sharpness > 0);
  Planes planes;
  double zero = std::abs(sharpened_planes(extents, filter, sharpness, planes));
  if (!(zero > 0)) zero = 1;
  const double limit = std::ldexp(1.0, energy_bits);
  scale_log2_ = 30;
  while (magnitude(planes, std::ldexp(1.0, scale_log2_) / zero) >= limit) --scale_log2_;
  const double scale = std::ldexp(1.0, scale_log2_) / zero;

  RowWriter writer(weights_);
  for (const auto& [offset, plane] : planes) {
    SliceStamp stamp = writer.stamp(offset, rounded_rows(plane, scale));
    for (const auto& [at, weight] : plane) {
      if (weight < 0) bias_ -= static_cast<std::uint32_t>(rounded(weight, scale));
    }
    const bool own = offset == Extents::SliceCoord{};
    if (own) {
      stamps_.insert(stamps_.begin(), std::move(stamp));
    } else if (!stamp.rows.empty()) {
      stamps_.push_back(std::move(stamp));
    }
  }
  weights_.resize(weights_.size() + vector_words);
}

}  // namespace noiseloom
