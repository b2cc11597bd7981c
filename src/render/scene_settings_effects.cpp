// Settings of [effects], and of the filters over time and space.
#include "render/scene_settings.h"

namespace noiseloom::render {
namespace {

using settings::above;
using settings::at_least;
using settings::Field;
using settings::Setting;
using settings::Type;
using settings::Word;

// In the order of Integrand.
constexpr Word integrand_words[] = {
    {"constant", "1/2, whatever the number: no error at all"},
    {"identity", "the number itself", "ramp linear"},
    {"step", "1 below the threshold, 0 above", "heaviside"},
    {"steps", "a step at a random threshold, another in every repeat", "random-steps"},
    {"sine", "sin(pi u)", "sin"},
    {"circle", "of two numbers: 1 within 0.4 of the middle of the unit square", "disk"},
    {"gauss", "of two numbers: a Gaussian of deviation 0.2 around the middle", "gaussian"},
};

// In the order of TestPicture.
constexpr Word picture_words[] = {
    {"ramp", "grey from 0 to 1", "gradient"},
    {"dark-ramp", "grey from 0 to 1/8", "dark"},
    {"flats", "patches of grey on and beside the levels"},
    {"colours", "all hues, paler downward", "colors wheel hues"},
    {"zone-plate", "rings that become finer outward", "zone"},
};

// In the order of Density.
constexpr Word density_words[] = {{"slab", "the same everywhere", "constant homogeneous"},
                                  {"cloud", "a ball of noise of five octaves", "heterogeneous fbm"}};

constexpr Word edge_words[] = {{"depth", "distance from the plane that touches the surface", "position"},
                               {"normal", "angle between the surfaces"}};

constexpr Word time_kernel_words[] = {
    {"ema", "exponential moving average", "exponential taa history"},
    {"mc", "mean of all frames so far", "monte-carlo cumulative ca mean"},
};
// In the order of EmaStart.
constexpr Word start_words[] = {
    {"full", "the first frame has the weight 1"},
    {"cumulative", "frame n has the weight 1/n until that is below alpha"},
};
// In the order of SpaceKernel.
constexpr Word space_kernel_words[] = {
    {"box", "equal weights", "uniform mean"},
    {"gauss", "Gaussian, cut off at four deviations", "gaussian"},
    {"binomial", "binomial coefficients"},
};
// In the order of Border.
constexpr Word border_words[] = {{"clamp", "pixels outside are those of the border", "edge replicate"},
                                 {"wrap", "the picture is a torus", "periodic repeat toroidal"}};

constexpr settings::Condition with_kernel(std::string_view word) { return {"filter.space[].kernel", word}; }

}  // namespace

std::vector<Setting> rows_of_effects() {
  return {
      {.key = "effects",
       .type = Type::table,
       .sentence = "What is simulated, a picture for each. An effect that is not written is off.",
       .required = true},
      {.key = "effects.integrand",
       .type = Type::table,
       .sentence = "The same integral in every pixel, without a picture.",
       .field = [](Scene& s) -> Field { return &s.integrand.on; }},
      {.key = "effects.integrand.function",
       .type = Type::word,
       .sentence = "Of what.",
       .field = [](Scene& s) -> Field { return &s.integrand.function; },
       .words = integrand_words},
      {.key = "effects.integrand.threshold",
       .type = Type::number,
       .sentence = "Of the step.",
       .field = [](Scene& s) -> Field { return &s.integrand.threshold; },
       .range = at_least(0, 1),
       .when = {"effects.integrand.function", "step"}},
      {.key = "effects.dither",
       .type = Type::table,
       .sentence = "A picture of few levels, the noise deciding which: a number for each channel of colour.",
       .field = [](Scene& s) -> Field { return &s.dither.on; }},
      {.key = "effects.dither.bits",
       .type = Type::integer,
       .sentence = "Of each channel.",
       .field = [](Scene& s) -> Field { return &s.dither.bits; },
       .range = at_least(1, 16)},
      {.key = "effects.dither.picture",
       .type = Type::word,
       .sentence = "Of what.",
       .field = [](Scene& s) -> Field { return &s.dither.picture; },
       .words = picture_words},
      {.key = "effects.transparency",
       .type = Type::table,
       .sentence = "Panes that are there or not, each with the chance of its opacity, over a chequered gradient.",
       .field = [](Scene& s) -> Field { return &s.transparency.on; }},
      {.key = "effects.transparency.alpha",
       .type = Type::number,
       .sentence = "Opacities of the panes, from front to back.",
       .field = [](Scene& s) -> Field { return &s.transparency.alpha; },
       .list = true,
       .range = at_least(0, 1)},
      {.key = "effects.transparency.staggered",
       .type = Type::boolean,
       .sentence = "Whether each pane covers a part of the picture only, and some of its neighbours.",
       .field = [](Scene& s) -> Field { return &s.transparency.staggered; }},
      {.key = "effects.free-flight",
       .type = Type::table,
       .sentence = "Light scattered once in a volume: a number says how far it flies.",
       .field = [](Scene& s) -> Field { return &s.free_flight.on; }},
      {.key = "effects.free-flight.steps",
       .type = Type::integer,
       .sentence = "Parts of equal density that the way through the volume is cut into.",
       .field = [](Scene& s) -> Field { return &s.free_flight.steps; },
       .range = at_least(1, 1024)},
      {.key = "effects.ray-march",
       .type = Type::table,
       .sentence = "Light through a volume in steps, a number saying where they begin.",
       .field = [](Scene& s) -> Field { return &s.ray_march.on; }},
      {.key = "effects.ray-march.steps",
       .type = Type::integer,
       .sentence = "Steps through the volume.",
       .field = [](Scene& s) -> Field { return &s.ray_march.steps; },
       .range = at_least(1, 1024)},
      {.key = "effects.ambient-occlusion",
       .type = Type::table,
       .sentence = "How much of the sky a sphere and the plane that it rests on see.",
       .field = [](Scene& s) -> Field { return &s.occlusion.on; }},
      {.key = "effects.ambient-occlusion.samples",
       .type = Type::integer,
       .sentence = "Directions of a pixel in a frame.",
       .field = [](Scene& s) -> Field { return &s.occlusion.samples; },
       .range = at_least(1, 64)},
      {.key = "effects.ambient-occlusion.uniform",
       .type = Type::boolean,
       .sentence = "Whether pairs of numbers become directions of equal density, weighted by their cosine, in place of "
                   "directions as dense as the cosine. Textures of directions are taken as they are.",
       .field = [](Scene& s) -> Field { return &s.occlusion.uniform; }},
      {.key = "effects.soft-shadow",
       .type = Type::table,
       .sentence = "The shadow of a sun that is not a point, on the same sphere and plane.",
       .field = [](Scene& s) -> Field { return &s.shadow.on; }},
      {.key = "effects.soft-shadow.radius",
       .type = Type::number,
       .sentence = "Of the sun.",
       .field = [](Scene& s) -> Field { return &s.shadow.radius; },
       .range = at_least(0.1, 30),
       .unit = "degrees"},

      {.key = "volume", .type = Type::table, .sentence = "What effects in a volume look into: the unit cube."},
      {.key = "volume.density",
       .type = Type::word,
       .sentence = "Its form.",
       .field = [](Scene& s) -> Field { return &s.volume.density; },
       .words = density_words},
      {.key = "volume.extinction",
       .type = Type::number,
       .sentence = "Largest density: the optical depth that the side of the cube would have of it.",
       .field = [](Scene& s) -> Field { return &s.volume.extinction; },
       .range = at_least(0, 1e5)},
      {.key = "volume.albedo",
       .type = Type::number,
       .sentence = "Part of the light that is scattered.",
       .field = [](Scene& s) -> Field { return &s.volume.albedo; },
       .range = at_least(0, 1)},
      {.key = "volume.resolution",
       .type = Type::integer,
       .sentence = "Places along each side at which the density is given.",
       .field = [](Scene& s) -> Field { return &s.volume.resolution; },
       .range = at_least(2, 512),
       .when = {"volume.density", "cloud"}},
      {.key = "volume.seed",
       .type = Type::integer,
       .sentence = "Another seed gives another cloud.",
       .field = [](Scene& s) -> Field { return &s.volume.seed; },
       .range = at_least(0),
       .when = {"volume.density", "cloud"}},
  };
}

std::vector<Setting> rows_of_filters() {
  return {
      {.key = "filter",
       .type = Type::table,
       .sentence = "What is done to the frames before their errors are measured again."},
      {.key = "filter.border",
       .type = Type::word,
       .sentence = "What filters over space find beyond the border of the picture.",
       .field = [](Scene& s) -> Field { return &s.border; },
       .words = border_words},
      {.key = "filter.time", .type = Type::table, .sentence = "What is done to the frames."},
      {.key = "filter.time.kernels",
       .type = Type::word,
       .sentence = "Errors are measured after each of these, and of each frame alone.",
       .field = [](Scene& s) -> Field { return &s.time.kernels; },
       .list = true,
       .words = time_kernel_words},
      {.key = "filter.time.alpha",
       .type = Type::number,
       .sentence = "ema: weight of the new frame.",
       .field = [](Scene& s) -> Field { return &s.time.alpha; },
       .range = above(0, 1)},
      {.key = "filter.time.start",
       .type = Type::word,
       .sentence = "ema: how it begins.",
       .field = [](Scene& s) -> Field { return &s.time.start; },
       .words = start_words},
      {.key = "filter.space",
       .type = Type::tables,
       .sentence = "Filters of the picture. Errors are measured before them and after each.",
       .field = [](Scene& s) -> Field { return &s.space; },
       .example = "{ kernel = \"box\", size = 5 }"},
      {.key = "filter.space[].kernel",
       .type = Type::word,
       .sentence = "Its form, along x and along y.",
       .field = [](SpaceFilterSpec& f) -> Field { return &f.kernel; },
       .words = space_kernel_words,
       .required = true},
      {.key = "filter.space[].size",
       .type = Type::integer,
       .sentence = "Taps along each axis, an odd number.",
       .field = [](SpaceFilterSpec& f) -> Field { return &f.size; },
       .range = at_least(1, 255),
       .when = with_kernel("box")},
      {.key = "filter.space[].sigma",
       .type = Type::number,
       .sentence = "Standard deviation.",
       .field = [](SpaceFilterSpec& f) -> Field { return &f.sigma; },
       .range = at_least(0.1, 32),
       .unit = "pixels",
       .when = with_kernel("gauss")},
      {.key = "filter.space[].n",
       .type = Type::integer,
       .sentence = "One less than the taps along each axis, an even number.",
       .field = [](SpaceFilterSpec& f) -> Field { return &f.n; },
       .range = at_least(2, 40),
       .when = with_kernel("binomial")},
      {.key = "filter.space[].edges",
       .type = Type::word,
       .sentence = "What a pixel's neighbours are weighed by besides, so that edges of the surfaces stay.",
       .field = [](SpaceFilterSpec& f) -> Field { return &f.edges; },
       .list = true,
       .words = edge_words},
      {.key = "filter.space[].depth",
       .type = Type::number,
       .sentence = "edges by depth: distance at which a neighbour weighs 1/e; the sphere has the radius 1.",
       .field = [](SpaceFilterSpec& f) -> Field { return &f.depth; },
       .range = above(0)},
      {.key = "filter.space[].power",
       .type = Type::integer,
       .sentence = "edges by normal: power of the cosine of the angle.",
       .field = [](SpaceFilterSpec& f) -> Field { return &f.power; },
       .range = at_least(1, 1024)},
      {.key = "filter.space[].name",
       .type = Type::text,
       .sentence = "What tables and expectations call it; its kernel and number, such as box5, where it is not said.",
       .field = [](SpaceFilterSpec& f) -> Field { return &f.name; },
       .zero_is_unset = true},
  };
}

}  // namespace noiseloom::render
