#include "noiseloom/anneal/swap_delta.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "anneal/deltas/swap_delta_float.h"
#include "anneal/fields/metrics.h"
#include "anneal/fields/pair_weights.h"

namespace noiseloom {
namespace {

constexpr int lanes = 8;

// A run of taps along x, relative to the centre, with weights padded by zeros to a multiple of the lanes.
struct TapRow {
  std::int64_t offset;
  std::size_t first_weight;
  std::size_t num_weights;
};

struct SlicePlan {
  Extents::SliceCoord offset;
  std::vector<TapRow> rows;
};

template <DistanceKind kind, ValueKernelKind value_kind, int C>
class DoubleDelta final : public SwapDelta {
 public:
  DoubleDelta(const Footprint& footprint, const ValueKernel& kernel, WindowSize window)
      : footprint_(footprint),
        layout_(footprint, C, window),
        slice_layout_(footprint, C),
        metric_(kernel),
        own_(layout_) {
    for (const SliceTaps& slice : footprint.slices()) add_slice(slice);
    pair_weights_ = pair_weight_table<double>(footprint, layout_);
  }

  const FieldLayout& layout() const override { return layout_; }

  void bind(SliceIndex slice, Corner corner, const SliceField& own, const FieldOf& others) override {
    own_.copy_window(own, corner);
    corner_ = corner;
    fields_.clear();
    for (const SlicePlan& plan : plans_) {
      const SliceIndex other = footprint_.extents().slice_at(slice, plan.offset);
      fields_.push_back(plan.offset == Extents::SliceCoord{} ? &own_ : &others(other));
    }
  }

  double delta(CellPair pair) const override { return change(pair.i, pair.j); }
  void swap(CellPair pair) override { own_.swap(pair.i, pair.j); }

 private:
  double change(Cell i, Cell j) const {
    std::array<double, C> a;
    std::array<double, C> b;
    for (int c = 0; c < C; ++c) {
      a[static_cast<std::size_t>(c)] = own_.value(i, c);
      b[static_cast<std::size_t>(c)] = own_.value(j, c);
    }
    double sum = centred_sum(i, b.data(), a.data()) + centred_sum(j, a.data(), b.data());
    if (const double weight = pair_weight(i, j); weight != 0) {
      sum -= weight * (metric_(a.data(), a.data()) + metric_(b.data(), b.data()) - 2 * metric_(a.data(), b.data()));
    }
    return 2 * sum;
  }

  void add_slice(const SliceTaps& slice) {
    SlicePlan plan{slice.offset, {}};
    const std::int64_t stride = slice.offset == Extents::SliceCoord{} ? layout_.stride : slice_layout_.stride;
    for (std::size_t first = 0; first < slice.taps.size();) {
      std::size_t last = first;
      while (last < slice.taps.size() && slice.taps[last].dy == slice.taps[first].dy) ++last;
      const std::int32_t begin = slice.taps[first].dx;
      const auto length = static_cast<std::size_t>(slice.taps[last - 1].dx - begin + 1);
      const TapRow row{slice.taps[first].dy * stride + begin, weights_.size(), (length + lanes - 1) / lanes * lanes};
      weights_.resize(weights_.size() + row.num_weights);
      for (std::size_t k = first; k < last; ++k) {
        weights_[row.first_weight + static_cast<std::size_t>(slice.taps[k].dx - begin)] = slice.taps[k].weight;
      }
      plan.rows.push_back(row);
      first = last;
    }
    if (!plan.rows.empty()) plans_.push_back(std::move(plan));
  }

  double pair_weight(Cell i, Cell j) const {
    const std::int64_t dx = nearest_offset(j % layout_.width - i % layout_.width, layout_.width, layout_.wraps_x);
    const std::int64_t dy = nearest_offset(j / layout_.width - i / layout_.width, layout_.height, layout_.wraps_y);
    if (std::abs(dx) > layout_.reach_x || std::abs(dy) > layout_.reach_y) return 0;
    return pair_weights_[static_cast<std::size_t>((dy + layout_.reach_y) * (2 * layout_.reach_x + 1) + dx +
                                                  layout_.reach_x)];
  }
  // sum over taps of F (K(gained, s) - K(lost, s)) around a cell.
  double centred_sum(Cell cell, const double* gained, const double* lost) const {
    const std::int64_t at = layout_.at(cell);
    const std::int64_t at_slice = slice_layout_.at(slice_cell(slice_layout_, corner_, layout_, cell));
    std::array<double, lanes> sums{};
    for (std::size_t p = 0; p < plans_.size(); ++p) {
      const std::int64_t centre = fields_[p] == &own_ ? at : at_slice;
      for (const TapRow& row : plans_[p].rows) add_row(row, *fields_[p], centre, gained, lost, sums);
    }
    double total = 0;
    for (const double lane : sums) total += lane;
    return total;
  }

  void add_row(const TapRow& row, const SliceField& field, std::int64_t at, const double* gained, const double* lost,
               std::array<double, lanes>& sums) const {
    const double* weights = weights_.data() + row.first_weight;
    for (std::size_t k = 0; k < row.num_weights; k += lanes) {
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        double sample[C];
        for (int c = 0; c < C; ++c) {
          sample[c] = static_cast<double>(field.plane(c)[at + row.offset + static_cast<std::int64_t>(k + lane)]);
        }
        sums[lane] += weights[k + lane] * (metric_(gained, sample) - metric_(lost, sample));
      }
    }
  }

  const Footprint& footprint_;
  FieldLayout layout_;        // of the window
  FieldLayout slice_layout_;  // of the other slices
  metrics::Metric<kind, value_kind, C> metric_;
  std::vector<SlicePlan> plans_;
  std::vector<double> weights_;
  std::vector<double> pair_weights_;
  SliceField own_;
  Corner corner_;
  std::vector<const SliceField*> fields_;
};

template <DistanceKind kind, int C>
std::unique_ptr<SwapDelta> with_value_kind(const Footprint& footprint, const ValueKernel& kernel, WindowSize window) {
  if (kernel.kind == ValueKernelKind::distance) {
    return std::make_unique<DoubleDelta<kind, ValueKernelKind::distance, C>>(footprint, kernel, window);
  }
  return std::make_unique<DoubleDelta<kind, ValueKernelKind::stbn, C>>(footprint, kernel, window);
}

template <DistanceKind kind, int C, int last>
std::unique_ptr<SwapDelta> with_channels(const Footprint& footprint, const ValueKernel& kernel, WindowSize window) {
  if (kernel.channels == C) return with_value_kind<kind, C>(footprint, kernel, window);
  if constexpr (C < last) return with_channels<kind, C + 1, last>(footprint, kernel, window);
  NOISELOOM_CHECK_LE(kernel.channels, last);
  return nullptr;
}

std::unique_ptr<SwapDelta> make_double_delta(const Footprint& footprint, const ValueKernel& kernel, WindowSize window) {
  switch (kernel.distance) {
    case DistanceKind::absolute:
      return with_value_kind<DistanceKind::absolute, 1>(footprint, kernel, window);
    case DistanceKind::circle:
      return with_value_kind<DistanceKind::circle, 1>(footprint, kernel, window);
    case DistanceKind::angle:
      return with_channels<DistanceKind::angle, 2, 4>(footprint, kernel, window);
    case DistanceKind::axis:
      return with_channels<DistanceKind::axis, 3, 4>(footprint, kernel, window);
    case DistanceKind::manhattan:
      return with_channels<DistanceKind::manhattan, 2, 8>(footprint, kernel, window);
    case DistanceKind::chebyshev:
      return with_channels<DistanceKind::chebyshev, 2, 8>(footprint, kernel, window);
    case DistanceKind::cosine:
      return with_channels<DistanceKind::cosine, 2, 4>(footprint, kernel, window);
    case DistanceKind::euclidean:
      break;
  }
  return with_channels<DistanceKind::euclidean, 1, 8>(footprint, kernel, window);
}

}  // namespace

std::unique_ptr<SwapDelta> make_swap_delta(const Footprint& footprint, const ValueKernel& kernel, Precision precision,
                                           const FeatureMap* between_slices, std::optional<WindowSize> window,
                                           const FeatureMap* sieve) {
  const WindowSize size = window.value_or(WindowSize{footprint.extents().width(), footprint.extents().height()});
  if (precision == Precision::float32) return make_float_delta(footprint, kernel, size, between_slices, sieve);
  return make_double_delta(footprint, kernel, size);
}

}  // namespace noiseloom
