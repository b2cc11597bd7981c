// The table of passes, and what each does.
#include "noiseloom/render/passes.h"

#include <algorithm>
#include <cmath>

#include "render/filters/filter_passes.h"
#include "render/jobs/effect_list.h"
#include "render/jobs/frames.h"
#include "render/jobs/job.h"
#include "render/jobs/scene_passes.h"
#include "render/jobs/scene_sizes.h"
#include "render/measures/measure_pass.h"
#include "render/measures/truth_pass.h"
#include "render/pictures/prediction.h"

namespace noiseloom::render {
namespace {

// Noises.

void make_noises(Shared& shared) { shared.noises.make(&shared.opened); }

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
    count_of(counts, Work::estimates) += pixels;
    count_of(counts, work_of_reading(noise)) += pixels * values_of_pixel(noise, calls_of(effect).numbers(scene, noise));
  }
  if (truth_changes_with_frame(scene, effect)) count_of(counts, Work::expectations) = count_of(counts, Work::estimates);
  if (effect == Effect::occlusion)
    count_of(counts, work_of_rays(scene)) = count_of(counts, Work::estimates) * scene.occlusion.samples;
  if (effect == Effect::shadow || effect == Effect::sky)
    count_of(counts, work_of_rays(scene)) = count_of(counts, Work::estimates);
  if (effect == Effect::ray_march)
    count_of(counts, Work::march_steps) = count_of(counts, Work::estimates) * scene.ray_march.steps;
  return counts;
}

std::int64_t bytes_of_estimate(const Scene& scene, std::span<const Noise>) { return bytes_of_image(scene); }

Counts no_work(const Scene&, std::span<const Noise>) { return {}; }

std::string always(const Scene&) { return applies; }

bool is_measured_unseen(const Scene& scene) {
  const std::vector<Metric> metrics = metrics_of(scene);
  return std::find(metrics.begin(), metrics.end(), Metric::unseen) != metrics.end();
}

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
     bytes_of_columns},
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
    {"mesh", {}, {Data::mesh}, off_without_mesh, load_mesh, nullptr, no_work, bytes_of_mesh},
    {"mesh shares",
     {Data::mesh},
     {Data::shares},
     off_without_shares,
     find_shares,
     nullptr,
     work_of_shares,
     bytes_of_shares},
    {"primary hits",
     {Data::mesh},
     {Data::hits},
     off_without_surfaces,
     trace_hits,
     nullptr,
     work_of_hits,
     [](const Scene& scene, std::span<const Noise>) {
       return static_cast<std::int64_t>(sizeof(Hit)) * pixels_of(scene);
     }},
    {"edge weights",
     {Data::hits},
     {Data::edge_weights},
     [](const Scene& scene) -> std::string {
       return has_fixed_edges(scene) ? applies : "no filter.space with edges, or they are found in every frame";
     },
     weigh_edges,
     nullptr,
     no_work,
     bytes_of_weights},
    {"kernel",
     {},
     {Data::kernel},
     [](const Scene& scene) -> std::string { return scene.convolution.on ? applies : "no effects.convolution"; },
     make_kernel_pass,
     nullptr,
     no_work,
     bytes_of_kernel},
    {"importance",
     {},
     {Data::importance},
     [](const Scene& scene) -> std::string { return scene.sparse.on ? applies : "no effects.sparse"; },
     make_importance_pass,
     nullptr,
     no_work,
     [](const Scene& scene, std::span<const Noise>) { return 4 * pixels_of(scene); }},
    {"sky light",
     {},
     {Data::sky},
     [](const Scene& scene) -> std::string { return scene.sky.on ? applies : "no effects.sky"; },
     make_sky_pass,
     nullptr,
     no_work,
     bytes_of_sky},
    {"sky truths",
     {Data::mesh, Data::hits, Data::sky},
     {Data::sky_truths},
     off_without_turning_sky,
     make_sky_truths,
     nullptr,
     work_of_sky_truths,
     bytes_of_sky_truths},
    {"truth",
     {Data::picture, Data::columns, Data::flights, Data::mesh, Data::shares, Data::hits, Data::edge_weights,
      Data::kernel, Data::importance, Data::sky},
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
    {"carrying",
     {Data::noises},
     {Data::carrying},
     off_without_carrying,
     make_carrying,
     nullptr,
     work_of_carrying,
     bytes_of_carrying},
    {"moving hits",
     {Data::mesh},
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
    {"seeds",
     {Data::noises, Data::carrying},
     {Data::seeds},
     [](const Scene& scene) -> std::string { return has_seeds(scene) ? applies : "no noise of kind heitz-belcour"; },
     nullptr,
     move_seeds,
     work_of_seeds,
     [](const Scene& scene, std::span<const Noise>) { return 8 * pixels_of(scene); }},
    {"integrand",
     {Data::noises, Data::seeds},
     {Data::estimate},
     [](const Scene& scene) -> std::string { return scene.integrand.on ? applies : "no effects.integrand"; },
     nullptr,
     [](Job& job) { integrand_calls.estimate(job); },
     work_of_effect<Effect::integrand>,
     bytes_of_estimate},
    {"dither",
     {Data::noises, Data::seeds, Data::picture},
     {Data::estimate},
     [](const Scene& scene) -> std::string { return scene.dither.on ? applies : "no effects.dither"; },
     nullptr,
     [](Job& job) { dither_calls.estimate(job); },
     work_of_effect<Effect::dither>,
     bytes_of_estimate},
    {"transparency",
     {Data::noises, Data::seeds},
     {Data::estimate},
     [](const Scene& scene) -> std::string { return scene.transparency.on ? applies : "no effects.transparency"; },
     nullptr,
     [](Job& job) { transparency_calls.estimate(job); },
     work_of_effect<Effect::transparency>,
     bytes_of_estimate},
    {"free-flight",
     {Data::noises, Data::seeds, Data::flights},
     {Data::estimate},
     [](const Scene& scene) -> std::string { return scene.free_flight.on ? applies : "no effects.free-flight"; },
     nullptr,
     [](Job& job) { free_flight_calls.estimate(job); },
     work_of_effect<Effect::free_flight>,
     bytes_of_estimate},
    {"ray-march",
     {Data::noises, Data::seeds, Data::columns},
     {Data::estimate},
     [](const Scene& scene) -> std::string { return scene.ray_march.on ? applies : "no effects.ray-march"; },
     nullptr,
     [](Job& job) { ray_march_calls.estimate(job); },
     work_of_effect<Effect::ray_march>,
     bytes_of_estimate},
    {"ambient-occlusion",
     {Data::noises, Data::seeds, Data::mesh, Data::shares, Data::hits, Data::moving_hits},
     {Data::estimate},
     [](const Scene& scene) -> std::string { return scene.occlusion.on ? applies : "no effects.ambient-occlusion"; },
     nullptr,
     [](Job& job) { occlusion_calls.estimate(job); },
     work_of_effect<Effect::occlusion>,
     bytes_of_estimate},
    {"soft-shadow",
     {Data::noises, Data::seeds, Data::mesh, Data::shares, Data::hits, Data::moving_hits},
     {Data::estimate},
     [](const Scene& scene) -> std::string { return scene.shadow.on ? applies : "no effects.soft-shadow"; },
     nullptr,
     [](Job& job) { shadow_calls.estimate(job); },
     work_of_effect<Effect::shadow>,
     bytes_of_estimate},
    {"sky",
     {Data::noises, Data::seeds, Data::mesh, Data::hits, Data::sky, Data::sky_truths},
     {Data::estimate},
     [](const Scene& scene) -> std::string { return scene.sky.on ? applies : "no effects.sky"; },
     nullptr,
     [](Job& job) { sky_calls.estimate(job); },
     work_of_effect<Effect::sky>,
     bytes_of_estimate},
    {"convolution",
     {Data::noises, Data::seeds, Data::kernel},
     {Data::estimate},
     [](const Scene& scene) -> std::string { return scene.convolution.on ? applies : "no effects.convolution"; },
     nullptr,
     [](Job& job) { convolution_calls.estimate(job); },
     work_of_effect<Effect::convolution>,
     bytes_of_estimate},
    {"sparse",
     {Data::noises, Data::seeds, Data::importance},
     {Data::estimate},
     [](const Scene& scene) -> std::string { return scene.sparse.on ? applies : "no effects.sparse"; },
     nullptr,
     [](Job& job) { sparse_calls.estimate(job); },
     work_of_effect<Effect::sparse>,
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
       return has_histories(scene) ? applies : "nothing moves, is rejected or clamped";
     },
     nullptr,
     average_histories,
     work_of_histories,
     bytes_of_averages},
    {"filter over space",
     {Data::estimate, Data::accumulated, Data::hits, Data::moving_hits, Data::edge_weights},
     {Data::filtered},
     [](const Scene& scene) -> std::string { return scene.space.empty() ? "no filter.space" : applies; },
     nullptr,
     filter,
     work_of_filters,
     bytes_of_filtered},
    {"samples so far",
     {Data::estimate},
     {Data::seen},
     [](const Scene& scene) -> std::string {
       return is_measured_unseen(scene) ? applies : "image.metrics has no unseen";
     },
     nullptr,
     see,
     no_work,
     [](const Scene& scene, std::span<const Noise>) { return pixels_of(scene); }},
    {"errors",
     {Data::noises, Data::truth, Data::estimate, Data::accumulated, Data::filtered, Data::seen},
     {Data::errors},
     always,
     nullptr,
     measure,
     work_of_errors,
     bytes_of_errors},
    {"spectra",
     {Data::truth, Data::estimate, Data::accumulated},
     {Data::stacks},
     [](const Scene& scene) -> std::string {
       return scene.puts_out("spectra") ? applies : "image.outputs has no spectra";
     },
     nullptr,
     stack,
     work_of_spectra,
     bytes_of_spectra},
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

}  // namespace noiseloom::render
