// What the settings of a scene ask of each other.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>

#include "noiseloom/render/expectation.h"
#include "noiseloom/render/noise.h"
#include "render/scene/scene_settings.h"
#include "render/scene/view.h"

namespace noiseloom::render {
namespace {

using settings::Reader;
using settings::Value;

const Value* element(const Value& root, std::string_view list, std::size_t index) {
  const Value* const value = settings::find_at(root, list);
  const settings::Array* const array = value == nullptr ? nullptr : value->array();
  return array == nullptr || index >= array->size() ? nullptr : &(*array)[index];
}

// A fault at an element of a list, or at one of its keys.
void fault_at(Reader& reader, const Value& root, const std::string& list, std::size_t index, const std::string& key,
              const std::string& text) {
  const Value* const found = element(root, list, index);
  const settings::Table* const table = found == nullptr ? nullptr : found->table();
  const Value* const value = table == nullptr ? nullptr : settings::find(*table, key);
  const std::string shown = fmt::format("{}[{}]", list, index);
  if (value != nullptr) {
    reader.fault(*value, shown + '.' + key, text);
  } else {
    reader.fault(found != nullptr ? found->place : root.place, fmt::format("{}: {}", shown, text));
  }
}

bool is_name(const std::string& text) {
  return !text.empty() && text.size() <= 60 && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_' ||
           c == '.';
  }) && text.front() != '.';
}

// A plane of numbers over all of them must fit into memory.
constexpr std::int64_t most_pixels_of_mesh = std::int64_t{1} << 28;

constexpr const char* name_rule = "must be a word of letters, digits, points, - and _, as it names files too";

void name_noises(Reader& reader, const Value& root, Scene& scene) {
  const auto words = reader.kind().row("noise[].kind").words;
  std::set<std::string> names;
  for (std::size_t i = 0; i < scene.noises.size(); ++i) {
    NoiseSpec& noise = scene.noises[i];
    if (noise.name.empty()) noise.name = words[static_cast<std::size_t>(noise.kind)].word;
    if (!is_name(noise.name)) fault_at(reader, root, "noise", i, "name", name_rule);
    if (!names.insert(noise.name).second)
      fault_at(reader, root, "noise", i, "name", fmt::format("a second noise of the name \"{}\"", noise.name));
  }
}

void check_targets(Reader& reader, const Value& root, const Scene& scene) {
  std::string textures;
  for (const NoiseSpec& noise : scene.noises)
    if (has_texture(noise.kind)) textures += (textures.empty() ? "" : ", ") + noise.name;
  for (std::size_t i = 0; i < scene.noises.size(); ++i) {
    const NoiseSpec& noise = scene.noises[i];
    if (noise.kind != NoiseKind::heitz_belcour || noise.target.empty()) continue;
    const auto found = std::find_if(scene.noises.begin(), scene.noises.end(),
                                    [&](const NoiseSpec& other) { return other.name == noise.target; });
    if (found == scene.noises.end() || !has_texture(found->kind))
      fault_at(reader, root, "noise", i, "target",
               fmt::format("the scene has no texture of that name; it has: {}", textures.empty() ? "none" : textures));
  }
}

void check_points(Reader& reader, const Value& root, const Scene& scene) {
  for (std::size_t i = 0; i < scene.noises.size(); ++i)
    if (const int points = scene.noises[i].points; points > 0 && (points & (points - 1)) != 0)
      fault_at(reader, root, "noise", i, "points", "must be a power of two: 1, 2, 4, ... 256");
}

void name_filters(Reader& reader, const Value& root, Scene& scene) {
  std::set<std::string> names = {"none"};
  for (std::size_t i = 0; i < scene.space.size(); ++i) {
    SpaceFilterSpec& filter = scene.space[i];
    if (filter.kernel == SpaceKernel::box && filter.size % 2 == 0)
      fault_at(reader, root, "filter.space", i, "size", "must be odd: a filter has a pixel in its middle");
    if (filter.kernel == SpaceKernel::binomial && filter.n % 2 != 0)
      fault_at(reader, root, "filter.space", i, "n", "must be even: n + 1 taps have a pixel in their middle");
    if (filter.name.empty()) {
      if (filter.kernel == SpaceKernel::box) filter.name = fmt::format("box{}", filter.size);
      if (filter.kernel == SpaceKernel::gauss) filter.name = fmt::format("gauss{}", filter.sigma);
      if (filter.kernel == SpaceKernel::binomial) filter.name = fmt::format("binomial{}", filter.n);
      if (filter.kernel == SpaceKernel::a_trous) filter.name = fmt::format("a-trous{}", filter.levels);
    }
    if (!is_name(filter.name)) fault_at(reader, root, "filter.space", i, "name", name_rule);
    if (!names.insert(filter.name).second)
      fault_at(reader, root, "filter.space", i, "name", fmt::format("a second filter of the name \"{}\"", filter.name));
  }
}

// A fault unless `word` is among `known`, with the one that may be meant.
void check_word(Reader& reader, const Value& root, std::size_t index, const std::string& key, const std::string& word,
                const std::vector<std::string>& known, const std::string& noun) {
  if (std::find(known.begin(), known.end(), word) != known.end()) return;
  const std::string near = nearest_word(word, known);
  std::string list;
  for (const std::string& one : known) list += (list.empty() ? "" : ", ") + one;
  fault_at(reader, root, "expect", index, key,
           fmt::format("the scene has no {} \"{}\"{}; it has: {}", noun, word,
                       near.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", near), list.empty() ? "none" : list));
}

void check_expectation(Reader& reader, const Value& root, Scene& scene, std::size_t i) {
  ExpectSpec& expect = scene.expects[i];
  std::vector<std::string> noises;
  for (const NoiseSpec& noise : scene.noises) noises.push_back(noise.name);
  const bool has_value = expect.rmse > 0 || expect.ratio > 0;
  if (!expect.order.empty()) {
    const std::vector<OrderTerm> terms = parse_order(expect.order);
    if (terms.empty())
      fault_at(reader, root, "expect", i, "order", "must be names with < or = between them: \"fast < stbn = other\"");
    for (const OrderTerm& term : terms) check_word(reader, root, i, "order", term.noise, noises, "noise");
    if (has_value || !expect.noise.empty())
      fault_at(reader, root, "expect", i, "order", "goes without noise, rmse and ratio");
    if (scene.repeats < 2)
      fault_at(reader, root, "expect", i, "order", "needs image.repeats = 2 or more, which show what chance makes");
  } else {
    if (expect.noise.empty() || (expect.rmse > 0) == (expect.ratio > 0))
      fault_at(reader, root, "expect", i, "noise", "needs an order, or a noise with either rmse or ratio");
    if (!expect.noise.empty()) check_word(reader, root, i, "noise", expect.noise, noises, "noise");
    if (expect.ratio > 0) check_word(reader, root, i, "against", expect.against, noises, "noise");
  }
  std::vector<std::string> effects;
  for (const Effect effect : effects_of(scene)) effects.push_back(name_of(effect));
  if (expect.effect.empty()) {
    if (effects.size() == 1) expect.effect = effects.front();
    if (effects.size() > 1) fault_at(reader, root, "expect", i, "effect", "needed, as there are several effects");
  } else {
    check_word(reader, root, i, "effect", expect.effect, effects, "effect");
  }
  std::vector<std::string> times = {"frame"};
  times.insert(times.end(), scene.time.kernels.begin(), scene.time.kernels.end());
  check_word(reader, root, i, "time", expect.time, times, "filter over time");
  std::vector<std::string> spaces = {"none"};
  for (const SpaceFilterSpec& filter : scene.space) spaces.push_back(filter.name);
  check_word(reader, root, i, "space", expect.space, spaces, "filter over space");
  if (expect.frame > scene.frames)
    fault_at(reader, root, "expect", i, "frame", fmt::format("the scene has {} frames", scene.frames));
}

void check_motion(Reader& reader, const Value& root, Scene& scene) {
  const Value* const motion = settings::find_at(root, "motion");
  const auto moves = [](const std::vector<double>& pixels) {
    return std::any_of(pixels.begin(), pixels.end(), [](double n) { return n != 0; });
  };
  scene.motion.on = moves(scene.motion.camera) || moves(scene.motion.sphere);
  if (!scene.motion.on || motion == nullptr) return;
  if (scene.motion.camera.size() != 2 || scene.motion.sphere.size() != 2)
    reader.fault(*motion, "motion", "camera and sphere must each have two numbers, [right, down]");
  for (const Effect effect : effects_of(scene))
    if (effect != Effect::occlusion && effect != Effect::shadow)
      reader.fault(*motion, "motion",
                   fmt::format("goes with ambient-occlusion and soft-shadow alone, not with {}", name_of(effect)));
  const auto whole = [](double n) { return n == std::floor(n); };
  if (scene.object.is_mesh() && !(whole(scene.motion.camera[0] - scene.motion.sphere[0]) &&
                                  whole(scene.motion.camera[1] - scene.motion.sphere[1])))
    reader.fault(*motion, "motion",
                 "must be whole pixels between camera and sphere where object.shape is a mesh: its truth is found once "
                 "for all frames");
  for (const SpaceFilterSpec& filter : scene.space)
    if (!filter.edges.empty() && filter.kernel != SpaceKernel::a_trous)
      reader.fault(*motion, "motion",
                   fmt::format("does not go with filters that keep to edges ({}), a-trous but for", filter.name));
}

void check_metrics(Reader& reader, const Value& root, const Scene& scene) {
  const std::vector<Metric> metrics = metrics_of(scene);
  if (std::find(metrics.begin(), metrics.end(), Metric::unseen) != metrics.end() && !scene.sparse.on)
    reader.fault(*settings::find_at(root, "image.metrics"), "image.metrics",
                 "has unseen, which goes with effects.sparse alone");
  const auto follows = [](const NoiseSpec& noise) { return noise.kind == NoiseKind::heitz_belcour; };
  if (std::find(metrics.begin(), metrics.end(), Metric::pattern) != metrics.end() &&
      std::none_of(scene.noises.begin(), scene.noises.end(), follows))
    reader.fault(*settings::find_at(root, "image.metrics"), "image.metrics",
                 "has pattern, for which the scene needs a noise of kind heitz-belcour");
  for (std::size_t i = 0; i < scene.expects.size(); ++i) {
    const std::string& wanted = scene.expects[i].metric;
    const auto found =
        std::find_if(metrics.begin(), metrics.end(), [&](Metric metric) { return name_of(metric) == wanted; });
    if (found == metrics.end())
      fault_at(reader, root, "expect", i, "metric",
               fmt::format("is not measured: image.metrics needs {}",
                           wanted == "low" || wanted == "middle" || wanted == "high"      ? "bands"
                           : wanted == "median" || wanted == "p99" || wanted == "largest" ? "quantiles"
                                                                                          : wanted));
    if (wanted == "unseen" && !scene.expects[i].effect.empty() && scene.expects[i].effect != "sparse")
      fault_at(reader, root, "expect", i, "metric", "goes with the effect sparse alone");
  }
  constexpr int most_frames = 1024;  // all of them are kept
  if (scene.puts_out("spectra") && scene.frames > most_frames)
    reader.fault(
        *settings::find_at(root, "image.outputs"), "image.outputs",
        fmt::format("has spectra, for which image.frames = {} is too many: at most {}", scene.frames, most_frames));
}

}  // namespace

void check_scene(Reader& reader, const Value& root, const settings::Owners& owners) {
  Scene& scene = owners.get<Scene>();
  name_noises(reader, root, scene);
  check_targets(reader, root, scene);
  check_points(reader, root, scene);
  name_filters(reader, root, scene);
  if (scene.noises.empty() && settings::find_at(root, "noise") != nullptr)
    reader.fault(*settings::find_at(root, "noise"), "noise", "needs at least one");
  if (effects_of(scene).empty() && settings::find_at(root, "effects") != nullptr)
    reader.fault(*settings::find_at(root, "effects"), "effects", "names no effect, so that there is nothing to render");
  if (scene.transparency.alpha.empty() || scene.transparency.alpha.size() > 32)
    if (const Value* alpha = settings::find_at(root, "effects.transparency.alpha"))
      reader.fault(*alpha, "effects.transparency.alpha", "must have 1 to 32 panes");
  check_motion(reader, root, scene);
  if (scene.object.is_mesh() && reader.faults().empty() && pixels_of_shares(scene) > most_pixels_of_mesh)
    reader.fault(*settings::find_at(root, "object"), "object",
                 fmt::format("is passed over by all frames in {} pixels together: accepted are {}, with a motion that "
                             "is slower or of fewer frames",
                             pixels_of_shares(scene), most_pixels_of_mesh));
  std::set<std::string> kernels;
  for (const std::string& kernel : scene.time.kernels)
    if (!kernels.insert(kernel).second)
      reader.fault(*settings::find_at(root, "filter.time.kernels"), "filter.time.kernels",
                   fmt::format("has \"{}\" twice", kernel));
  for (std::size_t i = 0; i < scene.expects.size(); ++i) check_expectation(reader, root, scene, i);
  check_metrics(reader, root, scene);
}

}  // namespace noiseloom::render
