#include "construct/vac_kernel.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "noiseloom/core/math.h"

namespace noiseloom {
namespace {

// k_a(d) for d in [-lo, hi], each offset of the axis once.
struct AxisKernel {
  std::int32_t lo = 0;
  std::int32_t hi = 0;
  std::vector<double> values;
  double at(std::int32_t d) const { return values[static_cast<std::size_t>(d + lo)]; }
};

double gaussian(double d, double sigma) { return math::exp(-(d * d) / (2 * sigma * sigma)); }

AxisKernel axis_kernel(std::int64_t size, bool toroidal, double sigma) {
  const double reach = 9 * sigma + 1;  // exp(-40) is far below half a unit of the largest scale
  const auto cut = static_cast<std::int64_t>(std::min(reach, 1e9));
  AxisKernel kernel;
  kernel.lo = narrow<std::int32_t>(std::min(cut, toroidal ? (size - 1) / 2 : size - 1));
  kernel.hi = narrow<std::int32_t>(std::min(cut, toroidal ? size / 2 : size - 1));
  const std::int64_t num_images = toroidal ? cut / size + 1 : 0;
  for (std::int32_t d = -kernel.lo; d <= kernel.hi; ++d) {
    double value = gaussian(d, sigma);
    for (std::int64_t k = 1; k <= num_images; ++k) {  // in pairs: the sum for -d has the same bits
      const auto shift = static_cast<double>(k * size);
      value += gaussian(d + shift, sigma) + gaussian(d - shift, sigma);
    }
    kernel.values.push_back(value);
  }
  return kernel;
}

// The overlap of a box of `box` slices over its value at 0, folded.
AxisKernel box_kernel(std::int64_t size, bool toroidal, int box) {
  AxisKernel kernel;
  kernel.lo = narrow<std::int32_t>(std::min<std::int64_t>(box - 1, toroidal ? (size - 1) / 2 : size - 1));
  kernel.hi = narrow<std::int32_t>(std::min<std::int64_t>(box - 1, toroidal ? size / 2 : size - 1));
  const auto taps = std::min<std::int64_t>(box, size);
  const auto shared = [taps](std::int64_t d) { return static_cast<double>(std::max<std::int64_t>(0, taps - d)); };
  for (std::int64_t d = -kernel.lo; d <= kernel.hi; ++d) {
    const std::int64_t away = std::abs(d);
    const double image = toroidal && away > 0 ? shared(size - away) : 0;
    kernel.values.push_back((shared(away) + image) / static_cast<double>(taps));
  }
  return kernel;
}

struct GroupAxes {
  std::vector<int> axes;  // ascending
  std::vector<AxisKernel> kernels;
  std::vector<bool> is_box;
};

GroupAxes group_axes(const VacSpec& spec, const VacGroup& group) {
  GroupAxes result{group.axes, {}, {}};
  std::sort(result.axes.begin(), result.axes.end());
  for (const int axis : result.axes) {
    const bool toroidal = spec.toroidal.empty() || spec.toroidal[static_cast<std::size_t>(axis)];
    const bool is_box = std::find(group.box_axes.begin(), group.box_axes.end(), axis) != group.box_axes.end();
    const std::int64_t size = spec.extents.size(axis);
    result.is_box.push_back(is_box);
    result.kernels.push_back(is_box ? box_kernel(size, toroidal, group.box_size)
                                    : axis_kernel(size, toroidal, group.sigma_px));
  }
  return result;
}

// The other offsets of a row, without axis0: how they weigh, and whether they are zero on the axes of either kind.
struct RowPlace {
  double factor = 1;
  bool box_is_zero = true;
  bool round_is_zero = true;
};

// Appends the row at `offset`, whose weights are factor * k_axis0, unless all of them round to zero.
void append_row(VacGroupKernel& group, const AxisKernel& along, bool along_is_box, const VacRow& at,
                const RowPlace& place, double scale) {
  std::vector<std::uint32_t> row;
  std::vector<std::int32_t> same_pixel;  // offsets to the same pixel of another slice of the box
  for (std::int32_t d = -along.lo; d <= along.hi; ++d) {
    const bool box_is_zero = place.box_is_zero && !(along_is_box && d != 0);
    const bool round_is_zero = place.round_is_zero && (along_is_box || d == 0);
    if (round_is_zero && !box_is_zero) same_pixel.push_back(d);
    const bool zero = round_is_zero && box_is_zero;
    row.push_back(zero ? 0 : static_cast<std::uint32_t>(std::floor(place.factor * along.at(d) * scale + 0.5)));
  }
  const auto not_zero = [](std::uint32_t w) { return w != 0; };
  auto first = std::find_if(row.begin(), row.end(), not_zero);
  if (first == row.end()) return;
  auto last = std::find_if(row.rbegin(), row.rend(), not_zero).base();
  const auto middle = row.begin() + along.lo;  // a row reaches from before to behind its middle
  first = std::min(first, middle);
  last = std::max(last, middle + 1);
  VacRow result = at;
  result.lo = static_cast<std::int32_t>(middle - first);
  result.hi = static_cast<std::int32_t>(last - middle) - 1;
  result.first = group.weights.size();
  group.weights.insert(group.weights.end(), first, last);
  group.weights.insert(group.weights.end(), VacGroupKernel::padding, 0U);
  group.rows.push_back(result);
  for (const std::int32_t d : same_pixel) {
    group.same_pixel.push_back(result.first + static_cast<std::size_t>(d + result.lo));
  }
}

VacGroupKernel group_kernel(const GroupAxes& group, double scale) {
  VacGroupKernel result{group.axes[0], {group.axes.begin() + 1, group.axes.end()}, {}, {}, {}};
  const std::size_t num_others = result.others.size();
  VacRow row{};
  for (std::size_t i = 0; i < num_others; ++i) row.offset[i] = -group.kernels[i + 1].lo;
  while (true) {
    RowPlace place;
    for (std::size_t i = 0; i < num_others; ++i) {
      place.factor *= group.kernels[i + 1].at(row.offset[i]);
      bool& is_zero = group.is_box[i + 1] ? place.box_is_zero : place.round_is_zero;
      is_zero = is_zero && row.offset[i] == 0;
    }
    append_row(result, group.kernels[0], group.is_box[0], row, place, scale);
    std::size_t i = 0;
    while (i < num_others && row.offset[i] == group.kernels[i + 1].hi) {
      row.offset[i] = -group.kernels[i + 1].lo;
      ++i;
    }
    if (i == num_others) return result;
    ++row.offset[i];
  }
}

double kernel_sum(const GroupAxes& group) {
  double all = 1;
  double zero = 1;
  for (const AxisKernel& kernel : group.kernels) {
    double sum = 0;
    for (const double value : kernel.values) sum += value;
    all *= sum;
    zero *= kernel.at(0);
  }
  return all - zero;
}

}  // namespace

VacKernel::VacKernel(const VacSpec& spec) {
  std::vector<GroupAxes> groups;
  double sum = 0;
  for (const VacGroup& group : spec.groups) {
    groups.push_back(group_axes(spec, group));
    sum += group.weight * kernel_sum(groups.back());
  }
  constexpr double limit = 0x1p31;
  scale_log2_ = 30;
  while (scale_log2_ > 0 && std::ldexp(sum, scale_log2_) >= limit) --scale_log2_;
  // The real sum fits; the rounded weights may add half a unit each, so they are counted too.
  for (;; --scale_log2_) {
    groups_.clear();
    weight_sum_ = 0;
    std::uint64_t num_same_pixel = 0;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      groups_.push_back(group_kernel(groups[g], std::ldexp(spec.groups[g].weight, scale_log2_)));
      for (const std::size_t i : groups_.back().same_pixel) groups_.back().weights[i] = 0;
      num_same_pixel += groups_.back().same_pixel.size();
      for (const std::uint32_t weight : groups_.back().weights) weight_sum_ += weight;
    }
    // The same pixel of another slice of a box outweighs everything else, so that it is turned on last.
    const std::uint64_t others = weight_sum_;
    weight_sum_ += num_same_pixel * others;
    if (weight_sum_ >= vac_flag) continue;
    for (VacGroupKernel& group : groups_) {
      for (const std::size_t i : group.same_pixel) group.weights[i] = static_cast<std::uint32_t>(others);
    }
    return;
  }
}

int vac_scale_log2(const VacSpec& spec) { return VacKernel(spec).scale_log2(); }

}  // namespace noiseloom
