#include "anneal/float_score.h"

#include <span>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "anneal/float_score.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "anneal/fields/simd_kernels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace noiseloom::HWY_NAMESPACE {

// sums[lane] += sum over taps of F d(own, other at the tap), for sixteen cells in a row. Four sums at a time, so that
// none waits for the one before it. Not inlined, as it is called at two places and would be compiled twice for every
// kind of distance and set of instructions.
template <DistanceKind kind, int C>
HWY_NOINLINE void add_block(std::span<const FloatScore::Tap> taps, const float* own, const float* other,
                            std::int64_t plane_size, double* sums) {
  constexpr std::size_t chains = 4;
  for (std::size_t p = 0; p < num_parts; ++p) {
    V a[C];
    for (int c = 0; c < C; ++c) a[c] = load_full(own + c * plane_size, p);
    V partial[chains];
    for (V& sum : partial) sum = hn::Zero(Floats());
    const auto term = [&](const FloatScore::Tap& tap) HWY_ATTR {
      V b[C];
      for (int c = 0; c < C; ++c) b[c] = load_full(other + tap.offset + c * plane_size, p);
      return hn::Mul(set(tap.weight), distance<kind, C>(a, b));
    };
    std::size_t k = 0;
    for (; k + chains <= taps.size(); k += chains) {
      for (std::size_t chain = 0; chain < chains; ++chain) {
        partial[chain] = hn::Add(partial[chain], term(taps[k + chain]));
      }
    }
    for (; k < taps.size(); ++k) partial[0] = hn::Add(partial[0], term(taps[k]));
    float lanes[vector_lanes];
    hn::StoreU(hn::Add(hn::Add(partial[0], partial[1]), hn::Add(partial[2], partial[3])), Floats(), lanes);
    for (std::size_t lane = 0; lane < vector_lanes; ++lane) {
      sums[p * vector_lanes + lane] += static_cast<double>(lanes[lane]);
    }
  }
}

template <DistanceKind kind, int C>
double plan_sum(std::span<const FloatScore::Tap> taps, const FieldLayout& layout, const float* own,
                const float* other) {
  double total = 0;
  for (std::int64_t y = 0; y < layout.height; ++y) {
    const std::int64_t row = layout.at(y * layout.width);
    double sums[block_lanes] = {};
    std::int64_t x = 0;
    for (; x + static_cast<std::int64_t>(block_lanes) <= layout.width; x += static_cast<std::int64_t>(block_lanes)) {
      add_block<kind, C>(taps, own + row + x, other + row + x, layout.plane_size, sums);
    }
    if (x < layout.width) {
      // The lanes past the end of the row hold the border.
      double last[block_lanes] = {};
      add_block<kind, C>(taps, own + row + x, other + row + x, layout.plane_size, last);
      for (std::int64_t lane = 0; lane < layout.width - x; ++lane) sums[lane] += last[lane];
    }
    for (const double sum : sums) total += sum;
  }
  return total;
}

template <DistanceKind kind, int C, int last>
double with_channels(std::span<const FloatScore::Tap> taps, const FieldLayout& layout, const float* own,
                     const float* other) {
  if (layout.channels == C) return plan_sum<kind, C>(taps, layout, own, other);
  if constexpr (C < last) return with_channels<kind, C + 1, last>(taps, layout, own, other);
  NOISELOOM_CHECK_LE(layout.channels, last);
  return 0;
}

double distance_sum(DistanceKind kind, std::span<const FloatScore::Tap> taps, const FieldLayout& layout,
                    const float* own, const float* other) {
  switch (kind) {
    case DistanceKind::absolute:
      return plan_sum<DistanceKind::absolute, 1>(taps, layout, own, other);
    case DistanceKind::circle:
      return plan_sum<DistanceKind::circle, 1>(taps, layout, own, other);
    case DistanceKind::angle:
      return with_channels<DistanceKind::angle, 2, 4>(taps, layout, own, other);
    case DistanceKind::axis:
      return with_channels<DistanceKind::axis, 3, 4>(taps, layout, own, other);
    case DistanceKind::manhattan:
      return with_channels<DistanceKind::manhattan, 2, 8>(taps, layout, own, other);
    case DistanceKind::chebyshev:
      return with_channels<DistanceKind::chebyshev, 2, 8>(taps, layout, own, other);
    case DistanceKind::cosine:
      return with_channels<DistanceKind::cosine, 2, 4>(taps, layout, own, other);
    case DistanceKind::euclidean:
      break;
  }
  return with_channels<DistanceKind::euclidean, 1, 8>(taps, layout, own, other);
}

}  // namespace noiseloom::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace noiseloom {
namespace {

HWY_EXPORT(distance_sum);

// How often an offset counts where only one of d and -d is looked at: twice, never, or once where they are the same on
// the torus.
float times_counted(const Extents& extents, const Extents::SliceCoord& slice, const PlaneTap& tap) {
  const auto sign = [&](std::int64_t d, int axis) {
    return 2 * d == extents.size(axis) ? 0 : d > 0 ? 1 : d < 0 ? -1 : 0;
  };
  for (int axis = extents.num_axes() - 1; axis >= 0; --axis) {
    const std::int64_t d = axis == 0 ? tap.dx : axis == 1 ? tap.dy : slice[static_cast<std::size_t>(axis - 2)];
    if (const int which = sign(d, axis); which != 0) return which > 0 ? 2 : 0;
  }
  return 1;
}

}  // namespace

FloatScore::FloatScore(const Footprint& footprint, DistanceKind kind, const FieldLayout& layout)
    : footprint_(footprint), kind_(kind), layout_(layout) {
  for (const SliceTaps& slice : footprint.slices()) {
    SlicePlan plan{slice.offset, {}};
    for (const PlaneTap& tap : slice.taps) {
      const float times = times_counted(footprint.extents(), slice.offset, tap);
      if (times == 0) continue;
      plan.taps.push_back({tap.dy * layout.stride + tap.dx, times * static_cast<float>(tap.weight)});
    }
    if (!plan.taps.empty()) plans_.push_back(std::move(plan));
  }
}

bool FloatScore::fits(const Footprint& footprint, DistanceKind kind, const FieldLayout& layout) {
  const double amplification = footprint.weight_sum() / footprint.weight_zero();
  const double most = kind == DistanceKind::angle ? 100 : 1000;
  return layout.reach_x >= footprint.reach(0) && layout.reach_y >= footprint.reach(1) && amplification <= most;
}

double FloatScore::slice_sum(SliceIndex slice, const FieldOf& fields) const {
  double sum = 0;
  for (const SlicePlan& plan : plans_) {
    const SliceField& other = fields(footprint_.extents().slice_at(slice, plan.offset));
    sum += HWY_DYNAMIC_DISPATCH(distance_sum)(kind_, plan.taps, layout_, fields(slice).plane(0), other.plane(0));
  }
  return sum;
}

}  // namespace noiseloom
#endif
