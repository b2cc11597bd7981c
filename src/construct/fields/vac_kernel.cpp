#include "construct/fields/vac_kernel.h"

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

// Every offset of an axis once: the kernel, and `fill` where it has none.
AxisKernel whole_axis(const AxisKernel& kernel, double fill, std::int64_t size, bool toroidal) {
  AxisKernel whole;
  whole.lo = narrow<std::int32_t>(toroidal ? (size - 1) / 2 : size - 1);
  whole.hi = narrow<std::int32_t>(toroidal ? size / 2 : size - 1);
  for (std::int32_t d = -whole.lo; d <= whole.hi; ++d) {
    whole.values.push_back(d >= -kernel.lo && d <= kernel.hi ? kernel.at(d) : fill);
  }
  return whole;
}

enum class AxisKind { gauss, box, tile };

struct GroupAxes {
  std::vector<int> axes;  // ascending
  std::vector<AxisKernel> kernels;
  std::vector<AxisKind> kinds;
  double weight = 1;
  double tail = 0;
  double tail_power = 1;
  VacEdges edges = VacEdges::pass;
};

// Of a group with tile axes there are two: within a tile, without those axes; and from a tile to all tiles.
GroupAxes group_axes(const VacSpec& spec, const VacGroup& group, VacEdges edges) {
  GroupAxes result;
  result.weight = group.weight;
  result.tail = group.tail;
  result.tail_power = group.tail_power;
  result.edges = edges;
  std::vector<int> axes = group.axes;
  std::sort(axes.begin(), axes.end());
  const auto among = [](const std::vector<int>& some, int axis) {
    return std::find(some.begin(), some.end(), axis) != some.end();
  };
  for (const int axis : axes) {
    const bool toroidal = spec.toroidal.empty() || spec.toroidal[static_cast<std::size_t>(axis)];
    const std::int64_t size = spec.extents.size(axis);
    const AxisKind kind = among(group.box_axes, axis)    ? AxisKind::box
                          : among(group.tile_axes, axis) ? AxisKind::tile
                                                         : AxisKind::gauss;
    if (kind == AxisKind::tile && edges == VacEdges::stay) continue;
    result.axes.push_back(axis);
    result.kinds.push_back(kind);
    if (kind == AxisKind::box) {
      result.kernels.push_back(box_kernel(size, toroidal, group.box_size));
    } else if (kind == AxisKind::tile) {
      const double share = 1 / static_cast<double>(size);
      result.kernels.push_back(whole_axis({0, 0, {share}}, share, size, true));
    } else {
      const AxisKernel gauss = axis_kernel(size, toroidal, group.sigma_px);
      result.kernels.push_back(group.tail > 0 ? whole_axis(gauss, 0, size, toroidal) : gauss);
    }
  }
  return result;
}

// The other offsets of a row, without axis0: how they weigh, and whether they are zero on the axes of either kind.
struct RowPlace {
  double factor = 1;   // of all axes
  double gauss = 1;    // of the axes with a Gaussian
  double flat = 1;     // of the others
  double squared = 0;  // length of the offset along the axes with a Gaussian
  bool box_is_zero = true;
  bool round_is_zero = true;

  void add(const GroupAxes& group, std::size_t axis, std::int32_t d) {
    const double value = group.kernels[axis].at(d);
    factor *= value;
    if (group.kinds[axis] != AxisKind::gauss) {
      box_is_zero = box_is_zero && (group.kinds[axis] == AxisKind::tile || d == 0);
      flat *= value;
    } else {
      round_is_zero = round_is_zero && d == 0;
      gauss *= value;
      squared += static_cast<double>(d) * d;
    }
  }
  double weight(const GroupAxes& group) const {
    if (group.tail == 0) return factor;
    const double tail = group.tail / (group.tail + math::pow(squared, group.tail_power));
    return std::max(gauss, tail) * flat;
  }
};

// Appends the row at `offset`, unless all of its weights round to zero.
void append_row(VacGroupKernel& result, const GroupAxes& group, const VacRow& at, const RowPlace& others,
                double scale) {
  const AxisKernel& along = group.kernels[0];
  std::vector<std::uint32_t> row;
  std::vector<std::int32_t> same_pixel;  // offsets to the same pixel of another slice of the box
  for (std::int32_t d = -along.lo; d <= along.hi; ++d) {
    RowPlace place = others;
    place.add(group, 0, d);
    if (place.round_is_zero && !place.box_is_zero) same_pixel.push_back(d);
    const bool zero = place.round_is_zero && place.box_is_zero;
    row.push_back(zero ? 0 : static_cast<std::uint32_t>(std::floor(place.weight(group) * scale + 0.5)));
  }
  const auto not_zero = [](std::uint32_t w) { return w != 0; };
  auto first = std::find_if(row.begin(), row.end(), not_zero);
  if (first == row.end()) return;
  auto last = std::find_if(row.rbegin(), row.rend(), not_zero).base();
  const auto middle = row.begin() + along.lo;  // a row reaches from before to behind its middle
  first = std::min(first, middle);
  last = std::max(last, middle + 1);
  VacRow cut = at;
  cut.lo = static_cast<std::int32_t>(middle - first);
  cut.hi = static_cast<std::int32_t>(last - middle) - 1;
  cut.first = result.weights.size();
  result.weights.insert(result.weights.end(), first, last);
  result.weights.insert(result.weights.end(), VacGroupKernel::padding, 0U);
  result.rows.push_back(cut);
  result.reach_x = std::max({result.reach_x, cut.lo, cut.hi});
  result.reach_y = std::max(result.reach_y, std::abs(at.offset[0]));
  for (const std::int32_t d : same_pixel) {
    result.same_pixel.push_back(cut.first + static_cast<std::size_t>(d + cut.lo));
  }
}

VacGroupKernel group_kernel(const GroupAxes& group, double scale) {
  VacGroupKernel result;
  result.axis0 = group.axes[0];
  result.others.assign(group.axes.begin() + 1, group.axes.end());
  result.edges = group.edges;
  const std::size_t num_others = result.others.size();
  VacRow row{};
  for (std::size_t i = 0; i < num_others; ++i) row.offset[i] = -group.kernels[i + 1].lo;
  while (true) {
    RowPlace place;
    for (std::size_t i = 0; i < num_others; ++i) place.add(group, i + 1, row.offset[i]);
    append_row(result, group, row, place, scale);
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
    const auto with = [&](VacEdges edges) {
      groups.push_back(group_axes(spec, group, edges));
      sum += groups.back().weight * kernel_sum(groups.back());
    };
    if (group.tile_axes.empty()) {
      with(VacEdges::pass);
    } else {
      with(VacEdges::stay);
      with(VacEdges::cross);
    }
  }
  constexpr double limit = 0x1p31;
  scale_log2_ = 30;
  while (scale_log2_ > 0 && std::ldexp(sum, scale_log2_) >= limit) --scale_log2_;
  // The real sum fits, but for tails; the rounded weights may add half a unit each, so they are counted too.
  for (;; --scale_log2_) {
    groups_.clear();
    weight_sum_ = 0;
    std::uint64_t num_same_pixel = 0;
    for (const GroupAxes& group : groups) {
      groups_.push_back(group_kernel(group, std::ldexp(group.weight, scale_log2_)));
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
