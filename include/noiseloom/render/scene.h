// A scene: what is rendered with several noises, through which filters, and what is expected to come out. Plain values,
// read from a file of settings of its own kind (config/settings.h); `noiseloom render --help-scene` prints its keys.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "noiseloom/config/file_names.h"
#include "noiseloom/config/settings.h"
#include "noiseloom/image/texture_read.h"

namespace noiseloom::render {

// In the order of the words of noise[].kind.
enum class NoiseKind { file, config, white, blue_2d, blue_3d, golden_ratio, ign, sobol_owen, sobol_rotated };

struct NoiseSpec {
  NoiseKind kind = NoiseKind::white;
  std::string name = {};                  // empty: the word of its kind
  std::string file = {};                  // file: a run file, images or arrays; config: a config of `generate`
  std::vector<std::string> changes = {};  // config: as --set of `generate`
  std::string samples = "uniform";        // file: what the values mean where the file does not say
  ValuesFrom values_from = ValuesFrom::offsets;
  int size = 128;   // blue-2d, blue-3d, golden-ratio: pixels along x and y of the texture
  int slices = 64;  // blue-2d, blue-3d: of the texture; golden-ratio, ign: frames after which they begin again
  std::uint64_t seed = 1;
};

// The integrals that every pixel estimates, in the order of the words of effects.integrand.function.
enum class Integrand { constant, identity, step, steps, sine, circle, gauss };

struct IntegrandSpec {
  bool on = false;
  Integrand function = Integrand::identity;
  double threshold = 0.5;  // step
};

// In the order of the words of effects.dither.picture.
enum class TestPicture { ramp, dark_ramp, flats, colours, zone_plate };

struct DitherSpec {
  bool on = false;
  int bits = 1;
  TestPicture picture = TestPicture::colours;
};

struct TransparencySpec {
  bool on = false;
  std::vector<double> alpha = {0.5};  // of the panes, front to back
  bool staggered = false;             // each pane covers a part of the picture, and overlaps its neighbours
};

// In the order of the words of volume.density.
enum class Density { slab, cloud };

struct VolumeSpec {
  Density density = Density::cloud;
  double extinction = 12;
  double albedo = 0.9;
  int resolution = 64;  // cloud: corners of cells along an axis
  std::uint64_t seed = 1;
};

struct FreeFlightSpec {
  bool on = false;
  int steps = 64;
};

struct RayMarchSpec {
  bool on = false;
  int steps = 4;
};

struct OcclusionSpec {
  bool on = false;
  int samples = 1;
  bool uniform = false;  // numbers become directions of equal density, weighted by their cosine
};

struct ShadowSpec {
  bool on = false;
  double radius = 8;  // of the sun, degrees
};

// Whole pixels of the picture in a frame, to the right and downward, so that what has been seen is found again exactly.
struct MotionSpec {
  bool on = false;  // whether any of these is not 0
  std::vector<int> camera = {0, 0};
  std::vector<int> sphere = {0, 0};
};

enum class EmaStart { full, cumulative };

struct TimeFilterSpec {
  std::vector<std::string> kernels;  // "ema", "mc"
  double alpha = 0.1;
  EmaStart start = EmaStart::full;
  double rejection = 0;  // chance that a pixel begins again in a frame
};

enum class SpaceKernel { box, gauss, binomial };
enum class Border { clamp, wrap };

struct SpaceFilterSpec {
  SpaceKernel kernel = SpaceKernel::box;
  int size = 5;                         // box
  double sigma = 1;                     // gauss
  int n = 2;                            // binomial: n + 1 taps
  std::vector<std::string> edges = {};  // "depth", "normal": what a tap is weighed by besides
  double depth = 0.05;                  // distance from the tangent plane at which a tap weighs 1/e
  int power = 32;                       // of the cosine between normals
  std::string name = {};                // empty: kernel and number, "box5"
};

struct ExpectSpec {
  std::string order = {};  // "fast < stbn < white", "blue-2d = white"
  std::string noise = {};  // whose error must be `rmse` or `ratio`
  double rmse = 0;         // 0: not said
  double ratio = 0;        // to `against`; 0: not said
  std::string against = "white";
  double within = 0.02;     // relative
  std::string effect = {};  // empty: the only one
  std::string time = "frame";
  std::string space = "none";
  int frame = 0;            // counted from 1; 0: the last
  std::string source = {};  // where it is claimed
};

struct Scene {
  std::string title;
  int width = 256;
  int height = 256;
  int frames = 64;
  int repeats = 4;
  std::uint64_t seed = 1;
  std::vector<std::string> outputs = {"curves", "images"};
  std::vector<NoiseSpec> noises;
  IntegrandSpec integrand;
  DitherSpec dither;
  TransparencySpec transparency;
  VolumeSpec volume;
  FreeFlightSpec free_flight;
  RayMarchSpec ray_march;
  OcclusionSpec occlusion;
  ShadowSpec shadow;
  MotionSpec motion;
  TimeFilterSpec time;
  std::vector<SpaceFilterSpec> space;
  Border border = Border::clamp;
  std::vector<ExpectSpec> expects;
  WrittenPaths written_paths;

  bool puts_out(const std::string& what) const;
};

// A picture is rendered for each effect that a scene names.
enum class Effect { integrand, dither, transparency, free_flight, ray_march, occlusion, shadow };
std::string name_of(Effect effect);
std::vector<Effect> effects_of(const Scene& scene);

// What an error is measured after: a filter over time ("frame" is none), then one over space ("none", or its name).
struct Stage {
  std::string time;
  std::string space;
  std::string to_string() const;  // "frame", "ema + box5"
};
// The frame alone first; for each filter over time all those over space.
std::vector<Stage> stages_of(const Scene& scene);

const settings::FileKind& scene_kind();
// Throws UserError with every fault, as load_config does.
Scene load_scene(const std::string& path, const std::vector<std::string>& overrides);
Scene parse_scene(const std::string& text, const std::string& name, const std::string& folder,
                  const std::vector<std::string>& overrides = {});
// Every setting that applies.
std::string to_toml(const Scene& scene);
// The reference of all settings.
std::string describe_scene_settings();

}  // namespace noiseloom::render
