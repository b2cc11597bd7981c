#include "render/pictures/prediction.h"

#include <algorithm>
#include <cmath>

#include "noiseloom/measure/score_file.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom::render {
namespace {

KernelSpec kernel_of(const SpaceFilterSpec& filter) {
  KernelSpec kernel;
  kernel.size = filter.size;
  kernel.sigma = filter.sigma;
  kernel.n = filter.n;
  kernel.kind = filter.kernel == SpaceKernel::box     ? KernelKind::box
                : filter.kernel == SpaceKernel::gauss ? KernelKind::gauss
                                                      : KernelKind::binomial;
  return kernel;
}

KernelSpec kernel_of(const std::string& time, const Scene& scene, std::int32_t slices) {
  KernelSpec kernel;
  kernel.kind = time == "mc" ? KernelKind::box : KernelKind::ema;
  kernel.size = static_cast<int>(std::min<std::int64_t>(scene.frames, slices));
  kernel.alpha = scene.time.alpha;
  kernel.rejection = 0;
  return kernel;
}

}  // namespace

std::vector<std::optional<double>> predicted_ratios(const Noise& noise, const Scene& scene,
                                                    const std::vector<Stage>& stages, ThreadPool& pool) {
  std::vector<std::optional<double>> ratios(stages.size());
  if (noise.texture == nullptr || noise.spec.kind == NoiseKind::golden_ratio) return ratios;
  const Texture& texture = *noise.texture;
  const DistanceKind kind = distance_kind(noise.samples, texture.channels);
  const double mean_distance = mean_distance_of(texture, kind, pool);
  const Extents& extents = texture.extents;
  for (std::size_t i = 0; i < stages.size(); ++i) {
    FilterSpec filter{Combine::product, {}};
    if (stages[i].space != "none") {
      const auto spec = std::find_if(scene.space.begin(), scene.space.end(),
                                     [&](const auto& one) { return one.name == stages[i].space; });
      filter.groups.push_back({{0, 1}, kernel_of(*spec), 1});
    }
    if (stages[i].time != "frame") {
      if (extents.num_slice_axes() != 1) continue;
      filter.groups.push_back({{2}, kernel_of(stages[i].time, scene, extents.num_slices()), 1});
    }
    const double error = filter.groups.empty() ? 1 : relative_error_of(texture, kind, filter, mean_distance, pool);
    ratios[i] = std::sqrt(std::max(0.0, error));
  }
  return ratios;
}

}  // namespace noiseloom::render
