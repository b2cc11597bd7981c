// The table of passes, and what each does.
#include "noiseloom/render/passes.h"

#include <algorithm>
#include <cmath>

#include "render/effect_list.h"
#include "render/filter_passes.h"
#include "render/frames.h"
#include "render/job.h"
#include "render/prediction.h"
#include "render/scene_sizes.h"
#include "render/truth_pass.h"

namespace noiseloom::render {
namespace {

constexpr const char* applies = "";

// Noises.

void make_noises(Shared& shared) { shared.noises.make(&shared.opened); }

std::int64_t bytes_of_noises(const Scene&, std::span<const Noise> noises) {
  std::int64_t bytes = 0;
  for (const Noise& noise : noises) bytes += noise.texture == nullptr ? 0 : 4 * std::ssize(noise.texture->values);
  return bytes;
}

// What is seen: a volume or surfaces.

bool has_volume(const Scene& scene) { return scene.free_flight.on || scene.ray_march.on; }
bool has_edges(const Scene& scene) {
  return std::any_of(scene.space.begin(), scene.space.end(), [](const auto& filter) { return !filter.edges.empty(); });
}

std::string off_without_volume(const Scene& scene) {
  return has_volume(scene) ? applies : "no effect in a volume (free-flight, ray-march)";
}

std::int64_t corners_of(const Scene& scene) {
  const std::int64_t n = scene.volume.density == Density::slab ? 2 : scene.volume.resolution;
  return n * n * n;
}
std::int64_t nodes_of(const Scene& scene) {
  return scene.volume.density == Density::slab ? 2 : scene.volume.resolution;
}
std::int64_t bytes_of_grid(const Scene& scene, std::span<const Noise>) { return 4 * corners_of(scene); }

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

void trace_hits(Shared& shared) {
  const Hits& hits = shared.hits.make(make_hits(shared.scene.width, shared.scene.height, shared.pool));
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
    all.push_back(filter.edges.empty() ? EdgeWeights{} : make_edge_weights(hits, filter, shared.scene.border));
}

std::int64_t bytes_of_weights(const Scene& scene, std::span<const Noise>) {
  std::int64_t taps = 0;
  for (const SpaceFilterSpec& filter : scene.space) {
    const std::int64_t across = std::ssize(taps_of(filter));
    taps += filter.edges.empty() ? 0 : across * across;
  }
  return 4 * pixels_of(scene) * taps;
}

// What scores promise.

void predict(Shared& shared) {
  const std::vector<Noise>& noises = *shared.noises.get(Data::noises, shared.pass);
  auto& predictions = shared.predictions.make();
  for (const Noise& noise : noises) {
    const auto ratios = predicted_ratios(noise, shared.scene, shared.stages, shared.pool);
    predictions.insert(predictions.end(), ratios.begin(), ratios.end());
  }
}

// Estimates.

template <Effect effect>
Counts work_of_effect(const Scene& scene, std::span<const Noise> noises) {
  Counts counts{};
  const std::int64_t pixels = pixels_of(scene) * num_rendered(scene) * scene.repeats;
  for (const Noise& noise : noises) {
    const std::int64_t numbers = calls_of(effect).numbers(scene, noise);
    count_of(counts, Work::estimates) += pixels;
    count_of(counts, Work::noise_values) += pixels * ((numbers + noise.channels - 1) / noise.channels);
  }
  if (scene.motion.on) count_of(counts, Work::expectations) = count_of(counts, Work::estimates);
  if (effect == Effect::occlusion)
    count_of(counts, Work::rays) = count_of(counts, Work::estimates) * scene.occlusion.samples;
  if (effect == Effect::shadow) count_of(counts, Work::rays) = count_of(counts, Work::estimates);
  if (effect == Effect::ray_march)
    count_of(counts, Work::march_steps) = count_of(counts, Work::estimates) * scene.ray_march.steps;
  return counts;
}

std::int64_t bytes_of_estimate(const Scene& scene, std::span<const Noise>) { return bytes_of_image(scene); }

Counts no_work(const Scene&, std::span<const Noise>) { return {}; }

std::string always(const Scene&) { return applies; }

constexpr Pass pass_table[] = {
    {"noises", {}, {Data::noises}, always, make_noises, nullptr, no_work, bytes_of_noises},
    {"picture",
     {},
     {Data::picture},
     [](const Scene& scene) -> std::string { return scene.dither.on ? applies : "nothing is dithered"; },
     [](Shared& shared) {
       shared.picture.make(test_picture(shared.scene.dither, shared.scene.width, shared.scene.height));
     },
     nullptr,
     no_work,
     [](const Scene& scene, std::span<const Noise>) {
       return 4 * pixels_of(scene) * channels_of(scene.dither.picture);
     }},
    {"density",
     {},
     {Data::density},
     off_without_volume,
     [](Shared& shared) { shared.density.make(make_density(shared.scene.volume)); },
     nullptr,
     no_work,
     bytes_of_grid},
    {"light",
     {Data::density},
     {Data::light},
     off_without_volume,
     [](Shared& shared) {
       shared.light.make(make_light(shared.scene.volume, shared.density.get(Data::density, shared.pass)));
     },
     nullptr,
     no_work,
     bytes_of_grid},
    {"columns",
     {Data::density, Data::light},
     {Data::columns},
     off_without_volume,
     trace_columns,
     nullptr,
     work_of_columns,
     [](const Scene& scene, std::span<const Noise>) { return 8 * pixels_of(scene) * nodes_of(scene); }},
    {"flights",
     {Data::columns},
     {Data::flights},
     [](const Scene& scene) -> std::string { return scene.free_flight.on ? applies : "no effects.free-flight"; },
     [](Shared& shared) {
       shared.flights.make(
           make_flights(shared.columns.get(Data::columns, shared.pass), shared.scene.free_flight.steps));
     },
     nullptr,
     no_work,
     [](const Scene& scene, std::span<const Noise>) { return 8 * pixels_of(scene) * scene.free_flight.steps; }},
    {"primary hits",
     {},
     {Data::hits},
     [](const Scene& scene) -> std::string {
       if (scene.motion.on) return "what is seen moves";
       return scene.occlusion.on || scene.shadow.on || has_edges(scene)
                  ? applies
                  : "no effect on surfaces (ambient-occlusion, soft-shadow), and no filter with edges";
     },
     trace_hits,
     nullptr,
     work_of_hits,
     [](const Scene& scene, std::span<const Noise>) {
       return static_cast<std::int64_t>(sizeof(Hit)) * pixels_of(scene);
     }},
    {"edge weights",
     {Data::hits},
     {Data::edge_weights},
     [](const Scene& scene) -> std::string { return has_edges(scene) ? applies : "no filter.space with edges"; },
     weigh_edges,
     nullptr,
     no_work,
     bytes_of_weights},
    {"truth",
     {Data::picture, Data::columns, Data::flights, Data::hits, Data::edge_weights},
     {Data::truth},
     always,
     make_truth,
     nullptr,
     work_of_truth,
     bytes_of_truth},
    {"predictions",
     {Data::noises},
     {Data::predictions},
     [](const Scene& scene) -> std::string {
       return scene.puts_out("predictions") ? applies : "image.outputs has no predictions";
     },
     predict,
     nullptr,
     no_work,
     [](const Scene&, std::span<const Noise>) { return std::int64_t{0}; }},
    {"moving hits",
     {},
     {Data::moving_hits},
     [](const Scene& scene) -> std::string { return scene.motion.on ? applies : "nothing moves"; },
     nullptr,
     trace_moving_hits,
     [](const Scene& scene, std::span<const Noise> noises) {
       Counts counts{};
       count_of(counts, Work::primary_rays) =
           pixels_of(scene) * num_rendered(scene) * scene.repeats * std::ssize(noises) * std::ssize(effects_of(scene));
       return counts;
     },
     [](const Scene& scene, std::span<const Noise>) {
       return 2 * static_cast<std::int64_t>(sizeof(Hit)) * pixels_of(scene);
     }},
    {"integrand",
     {Data::noises},
     {Data::estimate},
     [](const Scene& scene) -> std::string { return scene.integrand.on ? applies : "no effects.integrand"; },
     nullptr,
     [](Job& job) { integrand_calls.estimate(job); },
     work_of_effect<Effect::integrand>,
     bytes_of_estimate},
    {"dither",
     {Data::noises, Data::picture},
     {Data::estimate},
     [](const Scene& scene) -> std::string { return scene.dither.on ? applies : "no effects.dither"; },
     nullptr,
     [](Job& job) { dither_calls.estimate(job); },
     work_of_effect<Effect::dither>,
     bytes_of_estimate},
    {"transparency",
     {Data::noises},
     {Data::estimate},
     [](const Scene& scene) -> std::string { return scene.transparency.on ? applies : "no effects.transparency"; },
     nullptr,
     [](Job& job) { transparency_calls.estimate(job); },
     work_of_effect<Effect::transparency>,
     bytes_of_estimate},
    {"free-flight",
     {Data::noises, Data::flights},
     {Data::estimate},
     [](const Scene& scene) -> std::string { return scene.free_flight.on ? applies : "no effects.free-flight"; },
     nullptr,
     [](Job& job) { free_flight_calls.estimate(job); },
     work_of_effect<Effect::free_flight>,
     bytes_of_estimate},
    {"ray-march",
     {Data::noises, Data::columns},
     {Data::estimate},
     [](const Scene& scene) -> std::string { return scene.ray_march.on ? applies : "no effects.ray-march"; },
     nullptr,
     [](Job& job) { ray_march_calls.estimate(job); },
     work_of_effect<Effect::ray_march>,
     bytes_of_estimate},
    {"ambient-occlusion",
     {Data::noises, Data::hits, Data::moving_hits},
     {Data::estimate},
     [](const Scene& scene) -> std::string { return scene.occlusion.on ? applies : "no effects.ambient-occlusion"; },
     nullptr,
     [](Job& job) { occlusion_calls.estimate(job); },
     work_of_effect<Effect::occlusion>,
     bytes_of_estimate},
    {"soft-shadow",
     {Data::noises, Data::hits, Data::moving_hits},
     {Data::estimate},
     [](const Scene& scene) -> std::string { return scene.shadow.on ? applies : "no effects.soft-shadow"; },
     nullptr,
     [](Job& job) { shadow_calls.estimate(job); },
     work_of_effect<Effect::shadow>,
     bytes_of_estimate},
    {"filter over time",
     {Data::estimate},
     {Data::accumulated},
     [](const Scene& scene) -> std::string {
       if (has_histories(scene)) return "pixels have histories of their own";
       return scene.time.kernels.empty() ? "no filter.time.kernels" : applies;
     },
     nullptr,
     average,
     work_of_averages,
     bytes_of_averages},
    {"histories",
     {Data::estimate, Data::moving_hits},
     {Data::accumulated},
     [](const Scene& scene) -> std::string {
       if (scene.time.kernels.empty()) return "no filter.time.kernels";
       return has_histories(scene) ? applies : "nothing moves and filter.time.rejection is 0";
     },
     nullptr,
     average_histories,
     work_of_histories,
     bytes_of_averages},
    {"filter over space",
     {Data::estimate, Data::accumulated},
     {Data::filtered},
     [](const Scene& scene) -> std::string { return scene.space.empty() ? "no filter.space" : applies; },
     nullptr,
     filter,
     work_of_filters,
     bytes_of_filtered},
    {"errors",
     {Data::truth, Data::estimate, Data::accumulated, Data::filtered},
     {Data::errors},
     always,
     nullptr,
     measure,
     work_of_errors,
     bytes_of_errors},
    {"pictures",
     {Data::truth, Data::estimate, Data::accumulated, Data::filtered},
     {Data::pictures},
     [](const Scene& scene) -> std::string {
       return scene.puts_out("images") ? applies : "image.outputs has no images";
     },
     nullptr,
     keep,
     no_work,
     bytes_of_pictures},
};

// Whoever needs data comes after all that make it.
constexpr bool is_in_order() {
  for (std::size_t reader = 0; reader < std::size(pass_table); ++reader)
    for (std::size_t maker = reader; maker < std::size(pass_table); ++maker)
      if (pass_table[reader].needs.meets(pass_table[maker].makes)) return false;
  return true;
}
static_assert(is_in_order());

}  // namespace

std::span<const Pass> all_passes() { return pass_table; }

const EffectCalls& calls_of(Effect effect) {
  switch (effect) {
    case Effect::integrand:
      return integrand_calls;
    case Effect::dither:
      return dither_calls;
    case Effect::transparency:
      return transparency_calls;
    case Effect::free_flight:
      return free_flight_calls;
    case Effect::ray_march:
      return ray_march_calls;
    case Effect::occlusion:
      return occlusion_calls;
    case Effect::shadow:
      break;
  }
  return shadow_calls;
}

int if_numbers(int numbers, const Noise& noise) { return noise.numbers_in_value() > 0 ? numbers : 0; }

const Truth& Job::truth() const {
  const std::vector<Truth>& repeats = shared.truth.get(Data::truth, pass)[effect];
  return repeats[repeats.size() == 1 ? 0 : static_cast<std::size_t>(repeat)];
}

}  // namespace noiseloom::render
