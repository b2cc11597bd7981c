#include "run/plans/plan_filter.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "noiseloom/files/npy.h"

namespace noiseloom {
namespace {

constexpr double most_counted_taps = 3e5;

bool is_plane(int axis) { return axis < 2; }

// A table of several dimensions is one list over all axes of its group.
bool is_array(const GroupSpec& group) {
  return group.kernel.kind == KernelKind::table && group.axes.size() > 1 &&
         read_npy(group.kernel.file).shape.size() > 1;
}

GroupSpec over(const GroupSpec& group, std::vector<int> axes) {
  GroupSpec part = group;
  part.axes = std::move(axes);
  return part;
}

GroupSpec no_filter(double weight = 0) {
  GroupSpec group;
  group.axes = {0};
  group.kernel.kind = KernelKind::box;
  group.kernel.size = 1;
  group.weight = weight;
  return group;
}

// Taps along one axis, offset zero among them, and how far they reach.
struct Line {
  double taps;
  std::int32_t reach;
};
Line along_axis(const Extents& extents, const GroupSpec& group, int axis) {
  const Footprint line(extents, {Combine::product, {over(group, {axis})}});
  return {static_cast<double>(line.num_taps()) + 1, line.reach(axis)};
}

// The share of a box that its ball has.
double ball_share(std::size_t axes) {
  constexpr double pi = 3.141592653589793;
  const auto n = static_cast<double>(axes);
  return std::pow(pi, n / 2) / std::tgamma(n / 2 + 1) / std::pow(2, n);
}

// The axes over which the kernel of a group is round.
std::size_t round_axes(const GroupSpec& group, const std::vector<int>& axes) {
  return static_cast<std::size_t>(
      std::count_if(axes.begin(), axes.end(), [&](int axis) { return !group.is_box_along(axis); }));
}

double taps_of_group(const Extents& extents, const GroupSpec& group) {
  double taps = 1;
  if (is_array(group)) {
    const NpyArray array = read_npy(group.kernel.file);
    for (const std::int64_t size : array.shape) taps *= static_cast<double>(2 * size - 1);
    return taps;
  }
  for (const int axis : group.axes) taps *= along_axis(extents, group, axis).taps;
  if (group.kernel.kind == KernelKind::gauss_energy) taps *= ball_share(round_axes(group, group.axes));
  return std::max(1.0, taps);
}

// The part of the filter that lies in the plane, or along the slice axes.
FilterSpec part_of(const FilterSpec& filter, bool plane) {
  FilterSpec part{filter.combine, {}};
  for (const GroupSpec& group : filter.groups) {
    std::vector<int> axes;
    std::copy_if(group.axes.begin(), group.axes.end(), std::back_inserter(axes),
                 [&](int axis) { return is_plane(axis) == plane; });
    if (!axes.empty()) {
      part.groups.push_back(over(group, axes));
    } else if (filter.combine == Combine::sum) {
      part.groups.push_back(no_filter(group.weight));
    }
  }
  if (part.groups.empty()) part.groups.push_back(no_filter());
  return part;
}

// As wide and as high as the plane part of the filter, with few taps.
Footprint cross(const Extents& extents, const FilterSpec& plane) {
  FilterSpec filter{Combine::sum, {}};
  for (const int axis : {0, 1}) {
    std::int32_t reach = 0;
    for (const GroupSpec& group : plane.groups) {
      if (std::count(group.axes.begin(), group.axes.end(), axis) == 0) continue;
      reach = std::max(reach, along_axis(extents, group, axis).reach);
    }
    GroupSpec line = no_filter();
    line.axes = {axis};
    line.kernel.size = reach + 1;
    filter.groups.push_back(line);
  }
  return {extents, filter};
}

std::vector<double> relative_weights(const Footprint& footprint) {
  std::vector<double> weights = {1.0};
  for (const SliceTaps& slice : footprint.slices()) {
    for (const PlaneTap& tap : slice.taps) weights.push_back(std::abs(tap.weight / footprint.weight_zero()));
  }
  return weights;
}

// Pairs of a tap in the plane and one along the slices whose product is at least `cutoff`.
std::int64_t pairs_above(std::vector<double> plane, const std::vector<double>& slices, double cutoff) {
  std::sort(plane.begin(), plane.end());
  std::int64_t count = 0;
  for (const double slice : slices) {
    count += plane.end() - std::lower_bound(plane.begin(), plane.end(), cutoff / slice);
  }
  return count;
}

FilterOutline counted(const Extents& extents, const FilterSpec& filter, double cutoff) {
  Footprint footprint(extents, filter, cutoff);
  const auto others = footprint.slices().subspan(1);
  const bool same_pixel = std::all_of(others.begin(), others.end(), [](const SliceTaps& slice) {
    return slice.taps.size() == 1 && slice.taps[0].dx == 0 && slice.taps[0].dy == 0;
  });
  FilterOutline outline{footprint,
                        footprint,
                        footprint.num_taps(),
                        std::ssize(footprint.slices()[0].taps),
                        footprint.factors().has_value(),
                        same_pixel,
                        true};
  return outline;
}

FilterOutline separated(const Extents& extents, const FilterSpec& filter, double cutoff) {
  const FilterSpec plane_spec = part_of(filter, true);
  const FilterSpec slice_spec = part_of(filter, false);
  const double plane_taps = estimated_taps(extents, plane_spec);
  const bool wide = plane_taps > most_counted_taps;
  Footprint plane = wide ? cross(extents, plane_spec) : Footprint(extents, plane_spec, cutoff);
  Footprint slices(extents, slice_spec, cutoff);
  const double own = wide ? plane_taps - 1 : static_cast<double>(plane.num_taps());
  double all = (own + 1) * (static_cast<double>(slices.num_taps()) + 1);
  if (filter.combine == Combine::sum) {
    all = estimated_taps(extents, filter);
  } else if (cutoff > 0 && !wide) {
    all = static_cast<double>(
        pairs_above(relative_weights(Footprint(extents, plane_spec)), relative_weights(slices), cutoff));
  }
  for (const GroupSpec& group : filter.groups) {
    std::vector<int> plane_axes;
    std::copy_if(group.axes.begin(), group.axes.end(), std::back_inserter(plane_axes), is_plane);
    const std::size_t in_plane = round_axes(group, plane_axes);
    const std::size_t along = round_axes(group, group.axes) - in_plane;
    if (group.kernel.kind != KernelKind::gauss_energy || filter.combine == Combine::sum || in_plane * along == 0) {
      continue;
    }
    all *= ball_share(in_plane + along) / ball_share(in_plane) / ball_share(along);
  }
  const bool product = filter.combine == Combine::product &&
                       std::none_of(filter.groups.begin(), filter.groups.end(), [](const GroupSpec& group) {
                         return group.kernel.kind == KernelKind::gauss_energy &&
                                std::any_of(group.axes.begin(), group.axes.end(), is_plane) &&
                                !std::all_of(group.axes.begin(), group.axes.end(), is_plane);
                       });
  const bool same_pixel = filter.combine == Combine::sum ||
                          std::all_of(filter.groups.begin(), filter.groups.end(), [](const GroupSpec& group) {
                            return std::none_of(group.axes.begin(), group.axes.end(), is_plane);
                          });
  return {std::move(plane),
          std::move(slices),
          static_cast<std::int64_t>(std::max(0.0, all - 1)),
          static_cast<std::int64_t>(own),
          product,
          same_pixel,
          false};
}

}  // namespace

// On an axis of several groups a product has the taps that all of them have.
double estimated_taps(const Extents& extents, const FilterSpec& filter) {
  double taps = filter.combine == Combine::product ? 1 : 0;
  if (filter.combine == Combine::sum) {
    for (const GroupSpec& group : filter.groups) taps += taps_of_group(extents, group);
    return taps;
  }
  std::vector<double> fewest(static_cast<std::size_t>(extents.num_axes()), 0);
  for (const GroupSpec& group : filter.groups) {
    if (is_array(group)) {
      taps *= taps_of_group(extents, group);
      continue;
    }
    if (group.kernel.kind == KernelKind::gauss_energy) taps *= ball_share(round_axes(group, group.axes));
    for (const int axis : group.axes) {
      double& least = fewest[static_cast<std::size_t>(axis)];
      const double along = along_axis(extents, group, axis).taps;
      least = least == 0 ? along : std::min(least, along);
    }
  }
  for (const double along : fewest) taps *= std::max(1.0, along);
  return std::max(1.0, taps);
}

FilterOutline outline_of(const Extents& extents, const FilterSpec& filter, double cutoff) {
  const bool has_array = std::any_of(filter.groups.begin(), filter.groups.end(), is_array);
  if (has_array || estimated_taps(extents, filter) <= most_counted_taps) return counted(extents, filter, cutoff);
  return separated(extents, filter, cutoff);
}

}  // namespace noiseloom
