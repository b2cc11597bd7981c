#include "noiseloom/measure/score_file.h"

#include <numeric>

#include "noiseloom/image/naming.h"
#include "noiseloom/problem/footprint.h"
#include "noiseloom/problem/score.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {
namespace {

std::vector<double> slice_sums(const Texture& texture, DistanceKind kind, const Footprint& footprint,
                               ThreadPool& pool) {
  std::vector<double> sums(static_cast<std::size_t>(texture.extents.num_slices()));
  const SliceValues values = [&](SliceIndex s) { return texture.slice(s); };
  pool.for_each(texture.extents.num_slices(), [&](std::int64_t s, int) {
    sums[static_cast<std::size_t>(s)] = weighted_distance_sum(footprint, kind, texture.channels, SliceIndex(s), values);
  });
  return sums;
}

FilterSpec one_group(std::vector<int> axes, const KernelSpec& kernel) {
  return {Combine::product, {GroupSpec{std::move(axes), kernel, 1}}};
}

MeanDistance mean_of(const Texture& texture, DistanceKind kind) {
  return {kind, texture.channels, texture.extents.cells_per_slice(), texture.extents.num_slices()};
}

}  // namespace

std::vector<FilterSpec> standard_filters(const Extents& extents) {
  KernelSpec kernel;
  std::vector<FilterSpec> filters;
  for (const int size : {3, 5}) {
    kernel.kind = KernelKind::box;
    kernel.size = size;
    filters.push_back(one_group({0, 1}, kernel));
  }
  kernel.kind = KernelKind::gauss;
  kernel.sigma = 1;
  filters.push_back(one_group({0, 1}, kernel));
  kernel.kind = KernelKind::binomial;
  kernel.n = 2;
  filters.push_back(one_group({0, 1}, kernel));
  if (extents.num_slice_axes() > 0 && extents.size(2) > 1) {
    kernel.kind = KernelKind::ema;
    filters.push_back(one_group({2}, kernel));
  }
  return filters;
}

std::optional<double> published_score(const SampleSpec& samples, const std::string& filter) {
  // Measured by tests/bench/independent_score.py, which shares no code with this library.
  static constexpr struct {
    const char* samples;
    const char* filter;
    double relative_error;
  } published[] = {{"uniform", "box 5 over xy", 0.1110},
                   {"uniform", "gauss 1 over xy", 0.1221},
                   {"uniform", "gauss 1.3435 over xy x ema 0.1 (rejection 0.1) over t", 0.0840},
                   {"vector2", "gauss 1 over xy", 0.2263},
                   {"hemisphere-cosine", "box 5 over xy", 0.3150}};
  if (samples.compared_by != ComparedBy::own) return std::nullopt;  // those are R of the space's own distance
  for (const auto& row : published)
    if (samples.space == row.samples && filter == row.filter) return row.relative_error;
  return std::nullopt;
}

double mean_distance_of(const Texture& texture, DistanceKind kind, ThreadPool& pool) {
  const double m = mean_of(texture, kind).compute([&](SliceIndex s) { return interleaved_slice(texture, s); }, pool);
  if (!(m > 0)) throw UserError("", "all values of the texture are equal: it has no relative error");
  return m;
}

double relative_error_of(const Texture& texture, DistanceKind kind, const FilterSpec& filter, double mean_distance,
                         ThreadPool& pool) {
  const Footprint footprint(texture.extents, filter);
  return relative_error(footprint, mean_distance, slice_sums(texture, kind, footprint, pool));
}

TextureScore score_texture(const Texture& texture, DistanceKind kind, const FilterSpec& filter,
                           const std::vector<FilterSpec>& others, ThreadPool& pool) {
  const Extents& extents = texture.extents;
  const double m = mean_distance_of(texture, kind, pool);
  TextureScore score;
  score.exact = mean_of(texture, kind).exact();
  const Footprint footprint(extents, filter);
  const std::vector<double> sums = slice_sums(texture, kind, footprint, pool);
  score.relative_error = relative_error(footprint, m, sums);
  for (const double sum : sums)
    score.per_slice.push_back(relative_error(footprint, m, std::vector<double>(sums.size(), sum)));
  for (const FilterSpec& other : others) {
    const Footprint other_footprint(extents, other);
    score.others.push_back({describe_filter(extents, other),
                            relative_error(other_footprint, m, slice_sums(texture, kind, other_footprint, pool))});
  }
  return score;
}

}  // namespace noiseloom
