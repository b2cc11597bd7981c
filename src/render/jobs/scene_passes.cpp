#include "render/jobs/scene_passes.h"

#include <algorithm>

#include "render/jobs/job.h"
#include "render/jobs/scene_sizes.h"

namespace noiseloom::render {
namespace {

std::int64_t nodes_of(const Scene& scene) {
  return scene.volume.density == Density::slab ? 2 : scene.volume.resolution;
}

bool knows_edges(const Scene& scene) {
  return std::any_of(scene.space.begin(), scene.space.end(), [](const auto& filter) { return !filter.edges.empty(); });
}

}  // namespace

std::int64_t bytes_of_noises(const Scene&, std::span<const Noise> noises) {
  std::int64_t bytes = 0;
  for (const Noise& noise : noises) bytes += 4 * noise.num_values;
  return bytes;
}

std::string off_without_volume(const Scene& scene) {
  return scene.free_flight.on || scene.ray_march.on ? applies : "no effect in a volume (free-flight, ray-march)";
}

std::string off_without_surfaces(const Scene& scene) {
  if (scene.motion.on) return "what is seen moves";
  return scene.occlusion.on || scene.shadow.on || scene.sky.on || knows_edges(scene)
             ? applies
             : "no effect on surfaces (ambient-occlusion, soft-shadow, sky), and no filter with edges";
}

bool has_fixed_edges(const Scene& scene) {
  return std::any_of(scene.space.begin(), scene.space.end(),
                     [](const auto& filter) { return !filter.edges.empty() && is_linear(filter); });
}

std::int64_t bytes_of_grid(const Scene& scene, std::span<const Noise>) {
  const std::int64_t n = nodes_of(scene);
  return 4 * n * n * n;
}

void trace_columns(Shared& shared) {
  const Grid& density = shared.density.get(Data::density, shared.pass);
  const Grid& light = shared.light.get(Data::light, shared.pass);
  const Columns& columns =
      shared.columns.make(make_columns(density, light, shared.scene.width, shared.scene.height, shared.pool));
  count_of(*shared.counts, Work::density_reads) += std::ssize(columns.values);
}

Counts work_of_columns(const Scene& scene, std::span<const Noise>) {
  Counts counts{};
  count_of(counts, Work::density_reads) = pixels_of(scene) * nodes_of(scene);
  return counts;
}

std::int64_t bytes_of_columns(const Scene& scene, std::span<const Noise>) {
  return 8 * pixels_of(scene) * nodes_of(scene);
}

void trace_hits(Shared& shared) {
  const Hits& hits =
      shared.hits.make(make_hits(shared.scene.width, shared.scene.height, shared.pool, mesh_of(shared, shared.pass)));
  count_of(*shared.counts, Work::primary_rays) += std::ssize(hits.hits);
}

Counts work_of_hits(const Scene& scene, std::span<const Noise>) {
  Counts counts{};
  count_of(counts, Work::primary_rays) = pixels_of(scene);
  return counts;
}

void weigh_edges(Shared& shared) {
  const Hits& hits = shared.hits.get(Data::hits, shared.pass);
  std::vector<EdgeWeights>& all = shared.edge_weights.make();
  for (const SpaceFilterSpec& filter : shared.scene.space)
    all.push_back(filter.edges.empty() || !is_linear(filter) ? EdgeWeights{}
                                                             : make_edge_weights(hits, filter, shared.scene.border));
}

std::int64_t bytes_of_weights(const Scene& scene, std::span<const Noise>) {
  std::int64_t taps = 0;
  for (const SpaceFilterSpec& filter : scene.space)
    taps += filter.edges.empty() || !is_linear(filter) ? 0 : taps_of_filter(filter);
  return 4 * pixels_of(scene) * taps;
}

}  // namespace noiseloom::render
