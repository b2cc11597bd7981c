#include "noiseloom/render/scene.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "noiseloom/config/settings_file.h"

namespace noiseloom::render {
namespace {

Scene parsed(const settings::Source& source, const std::vector<std::string>& overrides) {
  settings::Parsed<Scene> result = settings::parse<Scene>(scene_kind(), source, overrides);
  result.value.written_paths = std::move(result.written_paths);
  return std::move(result.value);
}

}  // namespace

bool MotionSpec::is_whole() const {
  const auto whole = [](double n) { return n == std::floor(n); };
  return std::all_of(camera.begin(), camera.end(), whole) && std::all_of(sphere.begin(), sphere.end(), whole);
}

bool Scene::puts_out(const std::string& what) const {
  return std::find(outputs.begin(), outputs.end(), what) != outputs.end();
}

std::string name_of(Effect effect) {
  switch (effect) {
    case Effect::integrand:
      return "integrand";
    case Effect::dither:
      return "dither";
    case Effect::transparency:
      return "transparency";
    case Effect::free_flight:
      return "free-flight";
    case Effect::ray_march:
      return "ray-march";
    case Effect::occlusion:
      return "ambient-occlusion";
    case Effect::shadow:
      return "soft-shadow";
    case Effect::sky:
      return "sky";
    case Effect::convolution:
      return "convolution";
    case Effect::sparse:
      return "sparse";
  }
  return {};
}

bool truth_changes_with_frame(const Scene& scene, Effect effect) {
  return scene.motion.on || (effect == Effect::sky && scene.sky.turn != 0) ||
         (effect == Effect::integrand && scene.integrand.function == Integrand::jittered_steps);
}

std::string name_of(Metric metric) {
  static constexpr const char* names[num_metrics] = {"rmse",   "deviation", "ssim", "low",    "middle", "high",
                                                     "unseen", "pattern",   "flip", "median", "p99",    "largest"};
  return names[static_cast<int>(metric)];
}

bool is_root(Metric metric) {
  return metric == Metric::rmse || metric == Metric::deviation || metric == Metric::low || metric == Metric::middle ||
         metric == Metric::high;
}

std::vector<Metric> metrics_of(const Scene& scene) {
  std::vector<Metric> metrics = {Metric::rmse};
  const auto has = [&](const char* word) {
    return std::find(scene.metrics.begin(), scene.metrics.end(), word) != scene.metrics.end();
  };
  if (has("deviation")) metrics.push_back(Metric::deviation);
  if (has("ssim")) metrics.push_back(Metric::ssim);
  if (has("bands")) metrics.insert(metrics.end(), {Metric::low, Metric::middle, Metric::high});
  if (has("unseen")) metrics.push_back(Metric::unseen);
  if (has("pattern")) metrics.push_back(Metric::pattern);
  if (has("flip")) metrics.push_back(Metric::flip);
  if (has("quantiles")) metrics.insert(metrics.end(), {Metric::median, Metric::p99, Metric::largest});
  return metrics;
}

std::vector<Effect> effects_of(const Scene& scene) {
  std::vector<Effect> effects;
  if (scene.integrand.on) effects.push_back(Effect::integrand);
  if (scene.dither.on) effects.push_back(Effect::dither);
  if (scene.transparency.on) effects.push_back(Effect::transparency);
  if (scene.free_flight.on) effects.push_back(Effect::free_flight);
  if (scene.ray_march.on) effects.push_back(Effect::ray_march);
  if (scene.occlusion.on) effects.push_back(Effect::occlusion);
  if (scene.shadow.on) effects.push_back(Effect::shadow);
  if (scene.sky.on) effects.push_back(Effect::sky);
  if (scene.convolution.on) effects.push_back(Effect::convolution);
  if (scene.sparse.on) effects.push_back(Effect::sparse);
  return effects;
}

std::string Stage::to_string() const {
  if (space == "none") return time;
  return time == "frame" ? space : time + " + " + space;
}

std::vector<Stage> stages_of(const Scene& scene) {
  std::vector<std::string> times = {"frame"};
  times.insert(times.end(), scene.time.kernels.begin(), scene.time.kernels.end());
  std::vector<Stage> stages;
  for (const std::string& time : times) {
    stages.push_back({time, "none"});
    for (const SpaceFilterSpec& filter : scene.space) stages.push_back({time, filter.name});
  }
  return stages;
}

Scene load_scene(const std::string& path, const std::vector<std::string>& overrides) {
  return parsed(settings::load_source(path, scene_kind().noun), overrides);
}

Scene parse_scene(const std::string& text, const std::string& name, const std::string& folder,
                  const std::vector<std::string>& overrides) {
  return parsed({.text = text, .name = name, .folder = folder}, overrides);
}

std::string to_toml(const Scene& scene) { return settings::to_toml(scene_kind(), scene, scene.written_paths); }

std::string describe_scene_settings() { return settings::describe(scene_kind()); }

}  // namespace noiseloom::render
