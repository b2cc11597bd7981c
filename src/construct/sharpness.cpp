#include "noiseloom/construct/sharpness.h"

#include <algorithm>
#include <utility>

#include "noiseloom/construct/slice_construction.h"
#include "noiseloom/problem/footprint.h"
#include "noiseloom/problem/score.h"

namespace noiseloom {
namespace {

constexpr std::int64_t most_pixels = 64;  // of the twin, along x and y
constexpr std::int64_t most_slices = 4;
constexpr double tried[] = {1, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.8, 2};
constexpr std::uint64_t seeds[] = {1, 2};  // R of one seed scatters by about 0.5 %

struct Twin {
  Extents extents;
  FilterSpec filter;
};

bool is_joint_table(const GroupSpec& group) {
  const auto is_slice_axis = [](int axis) { return axis >= 2; };
  return group.kernel.kind == KernelKind::table && group.axes.size() > 1 &&
         std::any_of(group.axes.begin(), group.axes.end(), is_slice_axis) &&
         !std::all_of(group.axes.begin(), group.axes.end(), is_slice_axis);
}

// Of a joint table the slice axes stay, at a size that folds it.
Twin twin_of(const Extents& extents, const FilterSpec& filter) {
  Twin twin{{}, {filter.combine, {}}};
  const bool joint = std::any_of(filter.groups.begin(), filter.groups.end(), is_joint_table);
  std::vector<std::int64_t> sizes;
  for (int axis = 0; axis < (joint ? extents.num_axes() : 2); ++axis) {
    sizes.push_back(std::min(extents.size(axis), axis < 2 ? most_pixels : most_slices));
  }
  twin.extents = Extents(sizes);
  for (GroupSpec group : filter.groups) {
    if (!joint) std::erase_if(group.axes, [](int axis) { return axis >= 2; });
    if (!group.axes.empty()) twin.filter.groups.push_back(std::move(group));
  }
  return twin;
}

double error_of(const Twin& twin, const Footprint& overlap, double sharpness, std::uint64_t seed) {
  const Communicator alone = Communicator::self();
  ThreadPool pool(1);
  ConstructSpec spec;
  spec.sharpness = sharpness;
  SliceConstruction run(overlap, twin.filter, spec, seed, alone, pool);
  run.start();
  while (!run.done()) run.advance();
  const auto n = static_cast<double>(twin.extents.cells_per_slice());
  std::vector<std::vector<float>> slices;
  for (SliceIndex slice = 0; slice < twin.extents.num_slices(); ++slice) {
    std::vector<float>& samples = slices.emplace_back();
    for (const std::uint32_t place : run.places(slice)) samples.push_back(static_cast<float>((place + 0.5) / n));
  }
  const auto values = [&](SliceIndex slice) { return slices[static_cast<std::size_t>(slice)].data(); };
  std::vector<double> sums;
  for (SliceIndex slice = 0; slice < twin.extents.num_slices(); ++slice) {
    sums.push_back(weighted_distance_sum(overlap, DistanceKind::absolute, 1, slice, values, PairEnds::one));
  }
  const MeanDistance mean(DistanceKind::absolute, 1, twin.extents.cells_per_slice(), twin.extents.num_slices());
  const double mean_distance =
      mean.compute([&](SliceIndex slice) { return slices[static_cast<std::size_t>(slice)]; }, pool);
  return relative_error(overlap, mean_distance, sums);
}

}  // namespace

bool asks_for_blue_noise(const FilterSpec& filter) {
  return !filter.groups.empty() && std::all_of(filter.groups.begin(), filter.groups.end(), [](const GroupSpec& group) {
    return group.kernel.kind == KernelKind::gauss_energy;
  });
}

std::vector<SharpnessTrial> try_sharpness(const Extents& extents, const FilterSpec& filter) {
  if (asks_for_blue_noise(filter)) return {};
  const Twin twin = twin_of(extents, filter);
  if (twin.filter.groups.empty()) return {};
  const Footprint overlap(twin.extents, twin.filter);
  if (overlap.num_taps() == 0) return {};
  std::vector<SharpnessTrial> trials;
  for (const double sharpness : tried) {
    double sum = 0;
    for (const std::uint64_t seed : seeds) sum += error_of(twin, overlap, sharpness, seed);
    trials.push_back({sharpness, sum / static_cast<double>(std::size(seeds))});
  }
  return trials;
}

double best_sharpness(const std::vector<SharpnessTrial>& trials) {
  const auto best = std::min_element(
      trials.begin(), trials.end(),
      [](const SharpnessTrial& a, const SharpnessTrial& b) { return a.relative_error < b.relative_error; });
  return best == trials.end() ? 1 : best->sharpness;
}

}  // namespace noiseloom
