#include "noiseloom/problem/score.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "compensated_sum.h"
#include "overlap.h"
#include "score_distance.h"

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
  SampleRun at(std::int32_t dx) const { return {values_.data() + static_cast<std::ptrdiff_t>(pad_) + dx, stride_}; }

 private:
  std::size_t width_, cells_, channels_, pad_, stride_;
  std::vector<double> values_;
};

// The taps that are looked at, weighted with how often they count.
std::vector<PlaneTap> counted_taps(const Extents& extents, const SliceTaps& slice, PairEnds ends) {
  const bool same_slice = slice.offset == Extents::SliceCoord{};
  const double from_slice = ends == PairEnds::both ? 1 : slice_multiplicity(extents, slice.offset);
  std::vector<PlaneTap> taps;
  for (PlaneTap tap : slice.taps) {
    tap.weight *= same_slice ? plane_multiplicity(extents, tap) : from_slice;
    if (tap.weight != 0) taps.push_back(tap);
  }
  return taps;
}

}  // namespace

double weighted_distance_sum(const Footprint& footprint, DistanceKind kind, int channels, SliceIndex slice,
                             const SliceValues& values, PairEnds ends) {
  const Extents& extents = footprint.extents();
  const RunSum sum = sum_of_pairs(kind);
  const auto width = static_cast<std::size_t>(extents.width());
  PaddedRow own(extents, channels, 0);
  PaddedRow other(extents, channels, footprint.reach(0));
  CompensatedSum total;
  for (const SliceTaps& coupled : footprint.slices()) {
    const std::vector<PlaneTap> taps = counted_taps(extents, coupled, ends);
    if (taps.empty()) continue;
    const float* own_values = values(slice);
    const float* other_values = values(extents.slice_at(slice, coupled.offset));
    for (std::int64_t y = 0; y < extents.height(); ++y) {
      own.load(own_values, y);
      for (std::size_t k = 0; k < taps.size(); ++k) {
        const std::int64_t row = (y + taps[k].dy + extents.height()) % extents.height();
        if (k == 0 || taps[k].dy != taps[k - 1].dy) other.load(other_values, row);
        total.add(taps[k].weight * sum(own.at(0), other.at(taps[k].dx), width, static_cast<std::size_t>(channels)));
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
