// A scene: what is rendered with several noises, through which filters, and what is expected to come out. Plain values,
// read from a file of settings of its own kind (config/settings.h); `noiseloom render --help-scene` prints its keys.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "noiseloom/config/file_names.h"
#include "noiseloom/config/settings.h"
#include "noiseloom/image/texture_read.h"

namespace noiseloom::render {

// In the order of the words of noise[].kind.
enum class NoiseKind {
  file,
  config,
  white,
  blue_2d,
  blue_3d,
  golden_ratio,
  ign,
  sobol_owen,
  sobol_rotated,
  heitz_belcour,
  tables,
  sobol_blue
};

struct NoiseSpec {
  NoiseKind kind = NoiseKind::white;
  std::string name = {};                  // empty: the word of its kind
  std::string file = {};                  // file: a run file, images or arrays; config: a config of `generate`;
                                          // tables: source text
  std::vector<std::string> changes = {};  // config: as --set of `generate`
  std::string samples = "uniform";        // file: what the values mean where the file does not say
  ValuesFrom values_from = ValuesFrom::offsets;
  int size = 128;   // blue-2d, blue-3d, golden-ratio: pixels along x and y of the texture
  int slices = 64;  // blue-2d, blue-3d: of the texture; golden-ratio, ign: frames after which they begin again
  std::uint64_t seed = 1;
  std::string target = {};  // heitz-belcour: the noise of the scene that seeds follow
  int block = 4;            // heitz-belcour: pixels along each side within which a seed moves in a frame
  int retarget = 0;         // heitz-belcour: pixels by which seeds move so that they follow the mask of the next frame
  int points = 16;          // sobol-blue: frames whose mean has blue errors, and every power of two below
  int numbers = 2;          // sobol-blue: of an estimate, whose errors go together
  bool importance = true;   // numbers are bent to what an effect's integrand weighs, where the effect knows how
};

// The integrals that every pixel estimates, in the order of the words of effects.integrand.function.
enum class Integrand { constant, identity, step, steps, jittered_steps, sine, circle, gauss };

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
enum class Density { slab, cloud, file };

struct VolumeSpec {
  Density density = Density::cloud;
  double extinction = 12;
  double albedo = 0.9;
  int resolution = 64;  // cloud, file: corners of cells along an axis
  std::uint64_t seed = 1;
  std::string file = {};         // file: of OpenVDB
  std::string grid = "density";  // file: which of its grids
};

struct FreeFlightSpec {
  bool on = false;
  int steps = 64;
};

struct RayMarchSpec {
  bool on = false;
  int steps = 4;
};

// What rests on the plane, in the order of the words of object.shape, and which axis of its file points upward.
enum class ObjectShape { sphere, mesh };
enum class UpAxis { y, z };

// What the file of a mesh holds.
struct Triangles {
  std::vector<float> places;           // x, y, z of each vertex
  std::vector<std::uint32_t> corners;  // three vertices of each triangle, counted from 0

  std::size_t size() const { return corners.size() / 3; }
};

// What was read of a mesh for the plan, until the mesh is made of it: a file of a gigabyte is read once.
struct ReadTriangles {
  std::string file = {};  // empty: nothing is kept
  Triangles triangles = {};
};

struct ObjectSpec {
  ObjectShape shape = ObjectShape::sphere;
  std::string file = {};  // mesh
  double size = 2;        // mesh: its largest extent; the sphere's is 2
  UpAxis up = UpAxis::y;
  double turn = 0;   // degrees about the vertical
  int truth = 1024;  // directions of each pixel of which the truth is the mean
  std::shared_ptr<ReadTriangles> read = std::make_shared<ReadTriangles>();  // no setting
  bool is_mesh() const { return shape == ObjectShape::mesh; }
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

// In the order of the words of effects.convolution.kernel.
enum class BlurKernel { disk, hexagon, star, gauss, image };

struct ConvolutionSpec {
  bool on = false;
  BlurKernel kernel = BlurKernel::disk;
  int size = 33;          // pixels across
  std::string file = {};  // image
  bool srgb = false;      // image: its numbers are codes
};

// In the order of the words of effects.sparse.importance.
enum class ImportanceMap { ramp, spots, flat, image };

struct SparseSpec {
  bool on = false;
  ImportanceMap importance = ImportanceMap::spots;
  double level = 0.25;    // flat
  std::string file = {};  // image
};

struct SkySpec {
  bool on = false;
  std::string file = {};  // empty: a sun in a sky that grows paler toward the horizon
  // Of cells around the horizon, a quarter as many above each other: under a sky with a sun of two degrees the truth is
  // then 0.016 (rms) from that of 512 columns, twice as far with half as many, and 99 % of its values within 0.008.
  int columns = 128;
  int turn = 0;  // cells by which it turns in a frame
};

// Pixels of the picture in a frame, to the right and downward. Where they are whole, what has been seen is found again
// exactly; else it is read between pixels.
struct MotionSpec {
  bool on = false;  // whether any of these is not 0
  std::vector<double> camera = {0, 0};
  std::vector<double> sphere = {0, 0};
  bool is_whole() const;
};

enum class EmaStart { full, cumulative };
// What a history is kept within, in the order of the words of filter.time.clamp.
enum class Clamp { none, min_max, variance };
// How a history is read between pixels, in the order of the words of filter.time.resampling.
enum class Resampling { bilinear, catmull_rom };

struct TimeFilterSpec {
  std::vector<std::string> kernels;  // "ema", "mc"
  double alpha = 0.1;
  EmaStart start = EmaStart::full;
  double rejection = 0;  // chance that a pixel begins again in a frame
  Clamp clamp = Clamp::none;
  double gamma = 1.25;  // variance: standard deviations to either side of the mean
  Resampling resampling = Resampling::catmull_rom;
};

enum class SpaceKernel { box, gauss, binomial, a_trous };
enum class Border { clamp, wrap };

struct SpaceFilterSpec {
  SpaceKernel kernel = SpaceKernel::box;
  int size = 5;                         // box
  double sigma = 1;                     // gauss
  int n = 2;                            // binomial: n + 1 taps
  int levels = 5;                       // a_trous: of taps that are 1, 2, 4, ... pixels apart
  double luminance = 4;                 // a_trous: standard deviations of brightness at which a tap weighs 1/e
  std::vector<std::string> edges = {};  // "depth", "normal": what a tap is weighed by besides
  double depth = 0.05;                  // distance from the tangent plane at which a tap weighs 1/e
  int power = 32;                       // of the cosine between normals
  std::string name = {};                // empty: kernel and number, "box5"
};

// What is measured of a picture against its truth. The first is measured always.
enum class Metric { rmse, deviation, ssim, low, middle, high, unseen, pattern, flip, median, p99, largest };
inline constexpr int num_metrics = 12;

struct ExpectSpec {
  std::string order = {};  // "fast < stbn < white", "blue-2d = white"
  std::string metric = "rmse";
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
  std::vector<std::string> metrics = {};  // beside rmse
  std::vector<NoiseSpec> noises;
  IntegrandSpec integrand;
  DitherSpec dither;
  TransparencySpec transparency;
  VolumeSpec volume;
  FreeFlightSpec free_flight;
  RayMarchSpec ray_march;
  ObjectSpec object;
  OcclusionSpec occlusion;
  ShadowSpec shadow;
  SkySpec sky;
  ConvolutionSpec convolution;
  SparseSpec sparse;
  MotionSpec motion;
  TimeFilterSpec time;
  std::vector<SpaceFilterSpec> space;
  Border border = Border::clamp;
  std::vector<ExpectSpec> expects;
  WrittenPaths written_paths;

  bool puts_out(const std::string& what) const;
};

// A picture is rendered for each effect that a scene names.
enum class Effect {
  integrand,
  dither,
  transparency,
  free_flight,
  ray_march,
  occlusion,
  shadow,
  sky,
  convolution,
  sparse
};
std::string name_of(Effect effect);
std::vector<Effect> effects_of(const Scene& scene);
// Whether what an effect estimates is another in every frame: where something moves, or the integrand does.
bool truth_changes_with_frame(const Scene& scene, Effect effect);

std::string name_of(Metric metric);
// Of its square a mean is taken over repeats, and the root of that shown.
bool is_root(Metric metric);
// In order, rmse first: "bands" and "quantiles" stand for three each.
std::vector<Metric> metrics_of(const Scene& scene);

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
