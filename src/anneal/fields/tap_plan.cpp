#include "anneal/fields/tap_plan.h"

#include <algorithm>

#include "noiseloom/core/extents.h"

namespace noiseloom {
namespace {

constexpr std::int32_t half_lanes = block_lanes / 2;

struct Half {
  std::int32_t offset;
  float weights[half_lanes];
};

// Taps ordered by (dy, dx); each half begins at the first tap not yet covered.
std::vector<Half> cut_into_halves(std::span<const PlaneTap> taps, std::int64_t stride) {
  std::vector<Half> halves;
  std::int32_t row = 0;
  std::int32_t begin = 0;
  for (const PlaneTap& tap : taps) {
    if (halves.empty() || tap.dy != row || tap.dx - begin >= half_lanes) {
      row = tap.dy;
      begin = tap.dx;
      halves.push_back({narrow<std::int32_t>(tap.dy * stride + tap.dx), {}});
    }
    halves.back().weights[tap.dx - begin] = static_cast<float>(tap.weight);
  }
  return halves;
}

BlockWeights joined(const Half& low, const Half* high) {
  BlockWeights weights{};
  std::copy_n(low.weights, half_lanes, weights.lane);
  if (high != nullptr) std::copy_n(high->weights, half_lanes, weights.lane + half_lanes);
  return weights;
}

std::vector<PlaneTap> transposed(std::vector<PlaneTap> taps) {
  for (PlaneTap& tap : taps) std::swap(tap.dx, tap.dy);
  std::sort(taps.begin(), taps.end(),
            [](const PlaneTap& a, const PlaneTap& b) { return a.dy != b.dy ? a.dy < b.dy : a.dx < b.dx; });
  return taps;
}

}  // namespace

TapBlocks plan_rows(std::span<const PlaneTap> taps, std::int64_t stride) {
  const std::vector<Half> halves = cut_into_halves(taps, stride);
  TapBlocks blocks;
  const Half* single = nullptr;
  for (std::size_t k = 0; k < halves.size(); ++k) {
    if (k + 1 < halves.size() && halves[k + 1].offset == halves[k].offset + half_lanes) {
      blocks.full.push_back(halves[k].offset);
      blocks.full_weights.push_back(joined(halves[k], &halves[k + 1]));
      ++k;
    } else if (single == nullptr) {
      single = &halves[k];
    } else {
      blocks.split.push_back({single->offset, halves[k].offset});
      blocks.split_weights.push_back(joined(*single, &halves[k]));
      single = nullptr;
    }
  }
  if (single != nullptr) {
    blocks.split.push_back({single->offset, single->offset});
    blocks.split_weights.push_back(joined(*single, nullptr));
  }
  return blocks;
}

PlanePlan plan_plane(std::span<const PlaneTap> taps, std::int64_t stride, std::int64_t transposed_stride) {
  if (taps.empty()) return {};
  const auto [first, last] =
      std::minmax_element(taps.begin(), taps.end(), [](const PlaneTap& a, const PlaneTap& b) { return a.dx < b.dx; });
  const std::int32_t whole = (last->dx - first->dx + 1) / half_lanes * half_lanes;
  const std::int32_t end = first->dx + whole;
  std::vector<PlaneTap> whole_halves;
  std::vector<PlaneTap> left_over;
  for (const PlaneTap& tap : taps) (tap.dx < end ? whole_halves : left_over).push_back(tap);
  left_over = transposed(std::move(left_over));

  const std::size_t rows_alone = cut_into_halves(taps, stride).size();
  const std::size_t both =
      cut_into_halves(whole_halves, stride).size() + cut_into_halves(left_over, transposed_stride).size();
  // A transposed copy costs something to keep.
  if (10 * both > 8 * rows_alone) return {plan_rows(taps, stride), {}};
  return {plan_rows(whole_halves, stride), plan_rows(left_over, transposed_stride)};
}

}  // namespace noiseloom
