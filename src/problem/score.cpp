#include "noiseloom/problem/score.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "noiseloom/core/compensated_sum.h"
#include "problem/distances/score_distance.h"
#include "problem/filters/overlap.h"
#include "problem/score_row_simd.h"

namespace noiseloom {
namespace {

// How often an offset is counted when only one of d and -d is looked at: twice, never, or once where they are the same.
double multiplicity(bool is_own_negative, bool comes_first) {
  if (is_own_negative) return 1;
  return comes_first ? 2 : 0;
}

double slice_multiplicity(const Extents& extents, const Extents::SliceCoord& offset) {
  Extents::SliceCoord negative{};
  for (int axis = 2; axis < extents.num_axes(); ++axis) {
    const auto k = static_cast<std::size_t>(axis - 2);
    negative[k] = canonical_offset(-offset[k], extents.size(axis));
  }
  return multiplicity(negative == offset, negative < offset);
}

double plane_multiplicity(const Extents& extents, const PlaneTap& tap) {
  const auto own = std::pair(tap.dy, tap.dx);
  const auto negative =
      std::pair(canonical_offset(-tap.dy, extents.height()), canonical_offset(-tap.dx, extents.width()));
  return multiplicity(negative == own, negative < own);
}

// Rows of a slice as doubles, each channel with `pad` more samples of the torus at both ends.
class PaddedRow {
 public:
  PaddedRow(const Extents& extents, int channels, std::int32_t pad)
      : width_(static_cast<std::size_t>(extents.width())),
        cells_(static_cast<std::size_t>(extents.cells_per_slice())),
        channels_(static_cast<std::size_t>(channels)),
        pad_(static_cast<std::size_t>(pad)),
        stride_(width_ + 2 * pad_),
        values_(channels_ * stride_) {}

  void load(const float* slice, std::int64_t y) {
    for (std::size_t c = 0; c < channels_; ++c) {
      const float* from = slice + c * cells_ + static_cast<std::size_t>(y) * width_;
      double* to = values_.data() + c * stride_;
      std::copy_n(from + width_ - pad_, pad_, to);
      std::copy_n(from, width_, to + pad_);
      std::copy_n(from, pad_, to + pad_ + width_);
    }
  }
  SampleRun run() const { return {values_.data() + pad_, stride_}; }  // from the first cell on

 private:
  std::size_t width_, cells_, channels_, pad_, stride_;
  std::vector<double> values_;
};

struct TapRow {
  std::int32_t dy;
  std::vector<std::int32_t> offsets;
  std::vector<double> weights;
};

// The taps that are looked at, weighted with how often they count.
std::vector<TapRow> counted_rows(const Extents& extents, const SliceTaps& slice, PairEnds ends) {
  const bool same_slice = slice.offset == Extents::SliceCoord{};
  const double from_slice = ends == PairEnds::both ? 1 : slice_multiplicity(extents, slice.offset);
  std::vector<TapRow> rows;
  for (const PlaneTap& tap : slice.taps) {
    const double weight = tap.weight * (same_slice ? plane_multiplicity(extents, tap) : from_slice);
    if (weight == 0) continue;
    if (rows.empty() || rows.back().dy != tap.dy) rows.push_back({tap.dy, {}, {}});
    rows.back().offsets.push_back(tap.dx);
    rows.back().weights.push_back(weight);
  }
  return rows;
}

// sum over taps of weight * sum over a row of d(a, b at the tap).
double row_sum(DistanceKind kind, const RowTaps& taps, SampleRun a, SampleRun b, int channels, std::int64_t width) {
  const auto count = static_cast<std::size_t>(width);
  if (kind == DistanceKind::absolute) return scalar_row_sum(taps, a.values, b.values, count);
  if (kind == DistanceKind::circle) return circle_row_sum(taps, a.values, b.values, count);
  const RunSum sum = sum_of_pairs(kind);
  double total = 0;
  for (std::size_t k = 0; k < taps.weights.size(); ++k) {
    const SampleRun at_tap{b.values + taps.offsets[k], b.stride};
    total += taps.weights[k] * sum(a, at_tap, count, static_cast<std::size_t>(channels));
  }
  return total;
}

}  // namespace

double weighted_distance_sum(const Footprint& footprint, DistanceKind kind, int channels, SliceIndex slice,
                             const SliceValues& values, PairEnds ends) {
  const Extents& extents = footprint.extents();
  PaddedRow own(extents, channels, 0);
  PaddedRow other(extents, channels, footprint.reach(0));
  CompensatedSum total;
  for (const SliceTaps& coupled : footprint.slices()) {
    const std::vector<TapRow> rows = counted_rows(extents, coupled, ends);
    const float* own_values = values(slice);
    const float* other_values = values(extents.slice_at(slice, coupled.offset));
    for (std::int64_t y = 0; y < extents.height() && !rows.empty(); ++y) {
      own.load(own_values, y);
      for (const TapRow& row : rows) {
        other.load(other_values, (y + row.dy + extents.height()) % extents.height());
        total.add(row_sum(kind, {row.offsets, row.weights}, own.run(), other.run(), channels, extents.width()));
      }
    }
  }
  return total.value();
}

double relative_error(const Footprint& footprint, double mean_distance, std::span<const double> slice_sums) {
  if (mean_distance == 0) return 1;
  CompensatedSum coupled;
  for (const double sum : slice_sums) coupled.add(sum);
  const double per_cell = coupled.value() / static_cast<double>(footprint.extents().num_cells());
  return (mean_distance * footprint.weight_sum() - per_cell) / (mean_distance * footprint.weight_zero());
}

}  // namespace noiseloom
