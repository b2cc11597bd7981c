// Settings of effects with a kernel, a map or a sky, of motion, and of the filters over time and space.
#include "render/scene/scene_settings.h"

namespace noiseloom::render {
namespace {

// In the order of BlurKernel.
constexpr Word kernel_words[] = {
    {"disk", "of a lens that is wide open", "circle bokeh"},
    {"hexagon", "of a lens of six blades"},
    {"star", "of five points"},
    {"gauss", "a Gaussian, six deviations wide", "gaussian"},
    {"image", "the brightness of an image, pixel by pixel", "file png"},
};
// In the order of ImportanceMap.
constexpr Word importance_words[] = {
    {"ramp", "from 0 to 1, left to right", "gradient"},
    {"spots", "soft spots of 0.74 on a ground of 0.04"},
    {"flat", "the same everywhere", "constant"},
    {"image", "the brightness of an image, stretched over the picture", "file png map"},
};
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
    {"a-trous", "5 x 5 taps again and again, ever further apart, guided by the variance of the noise", "svgf atrous"},
};
// In the order of Clamp.
constexpr Word clamp_words[] = {
    {"none", "it stays as it is"},
    {"min-max", "between the least and the largest value of 3 x 3 pixels of the frame", "minmax aabb box"},
    {"variance", "within gamma standard deviations of their mean", "variance-clipping"},
};
// In the order of Resampling.
constexpr Word resampling_words[] = {
    {"bilinear", "of four pixels", "linear"},
    {"catmull-rom", "of sixteen pixels; of four at edges", "bicubic cubic"},
};
// In the order of Border.
constexpr Word border_words[] = {{"clamp", "pixels outside are those of the border", "edge replicate"},
                                 {"wrap", "the picture is a torus", "periodic repeat toroidal"}};

constexpr settings::Condition with_kernel(std::string_view word) { return {"filter.space[].kernel", word}; }

}  // namespace

std::vector<Setting> rows_of_more_effects() {
  return {
      {.key = "effects.sky",
       .type = Type::table,
       .sentence = "The same object and plane, lit by a sky: one direction a pixel and frame, drawn by its light.",
       .field = [](Scene& s) -> Field { return &s.sky.on; }},
      {.key = "effects.sky.file",
       .type = Type::file,
       .sentence =
           "Equirectangular image of the sky, y up, of which the upper half is used; a sun in a pale sky where "
           "it is not said. Noises may be textures of { image = ..., onto = \"hemisphere\" } of the same image.",
       .field = [](Scene& s) -> Field { return &s.sky.file; },
       .zero_is_unset = true},
      {.key = "effects.sky.columns",
       .type = Type::integer,
       .sentence = "Cells around the horizon that the sky is divided into, a quarter as many up to the zenith; no more "
                   "than the image has. The time that the truth takes grows with their square.",
       .field = [](Scene& s) -> Field { return &s.sky.columns; },
       .range = at_least(4, 512),
       .unit = "cells"},
      {.key = "effects.sky.turn",
       .type = Type::integer,
       .sentence = "How far the sky turns about the vertical from a frame to the next; below 0: the other way.",
       .field = [](Scene& s) -> Field { return &s.sky.turn; },
       .range = at_least(-512, 512),
       .unit = "cells"},
      {.key = "effects.convolution",
       .type = Type::table,
       .sentence = "Lamps before stripes, blurred by a kernel: one of its points a pixel and frame, drawn by its mass.",
       .field = [](Scene& s) -> Field { return &s.convolution.on; }},
      {.key = "effects.convolution.kernel",
       .type = Type::word,
       .sentence = "Its form. Noises may be textures of points of the same form.",
       .field = [](Scene& s) -> Field { return &s.convolution.kernel; },
       .words = kernel_words},
      {.key = "effects.convolution.size",
       .type = Type::integer,
       .sentence = "Its width and height.",
       .field = [](Scene& s) -> Field { return &s.convolution.size; },
       .range = at_least(1, 255),
       .unit = "pixels",
       .when = {"effects.convolution.kernel", "disk hexagon star gauss"}},
      {.key = "effects.convolution.file",
       .type = Type::file,
       .sentence = "The image, at most 255 pixels along each axis.",
       .field = [](Scene& s) -> Field { return &s.convolution.file; },
       .when = {"effects.convolution.kernel", "image"},
       .required = true},
      {.key = "effects.convolution.srgb",
       .type = Type::boolean,
       .sentence = "Whether its numbers are codes of sRGB in place of light.",
       .field = [](Scene& s) -> Field { return &s.convolution.srgb; },
       .when = {"effects.convolution.kernel", "image"}},
      {.key = "effects.sparse",
       .type = Type::table,
       .sentence = "Samples in some pixels only: where the number is below the importance of the pixel. The picture is "
                   "1 in these and 0 elsewhere.",
       .field = [](Scene& s) -> Field { return &s.sparse.on; }},
      {.key = "effects.sparse.importance",
       .type = Type::word,
       .sentence = "The chance that a pixel is to be sampled.",
       .field = [](Scene& s) -> Field { return &s.sparse.importance; },
       .words = importance_words},
      {.key = "effects.sparse.level",
       .type = Type::number,
       .sentence = "That chance.",
       .field = [](Scene& s) -> Field { return &s.sparse.level; },
       .range = at_least(0, 1),
       .when = {"effects.sparse.importance", "flat"}},
      {.key = "effects.sparse.file",
       .type = Type::file,
       .sentence = "The image.",
       .field = [](Scene& s) -> Field { return &s.sparse.file; },
       .when = {"effects.sparse.importance", "image"},
       .required = true},

      {.key = "motion",
       .type = Type::table,
       .sentence =
           "What moves, for ambient-occlusion and soft-shadow: [right, down] in pixels of the picture a frame. Whole "
           "pixels are found again exactly, others are read as filter.time.resampling says."},
      {.key = "motion.camera",
       .type = Type::number,
       .sentence = "The view over the plane.",
       .field = [](Scene& s) -> Field { return &s.motion.camera; },
       .list = true,
       .range = at_least(-1000, 1000)},
      {.key = "motion.sphere",
       .type = Type::number,
       .sentence = "The sphere over the plane.",
       .field = [](Scene& s) -> Field { return &s.motion.sphere; },
       .list = true,
       .range = at_least(-1000, 1000)},
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
      {.key = "filter.time.rejection",
       .type = Type::number,
       .sentence = "Chance that the history of a pixel is rejected in a frame.",
       .field = [](Scene& s) -> Field { return &s.time.rejection; },
       .range = at_least(0, 1)},
      {.key = "filter.time.clamp",
       .type = Type::word,
       .sentence = "What the history of a pixel is kept within. It is not linear: what it does to the mean is part of "
                   "the error.",
       .field = [](Scene& s) -> Field { return &s.time.clamp; },
       .words = clamp_words},
      {.key = "filter.time.gamma",
       .type = Type::number,
       .sentence = "Standard deviations to either side of the mean.",
       .field = [](Scene& s) -> Field { return &s.time.gamma; },
       .range = at_least(0, 100),
       .when = {"filter.time.clamp", "variance"}},
      {.key = "filter.time.resampling",
       .type = Type::word,
       .sentence = "How the history of what moves by parts of a pixel is read.",
       .field = [](Scene& s) -> Field { return &s.time.resampling; },
       .words = resampling_words},
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
      {.key = "filter.space[].levels",
       .type = Type::integer,
       .sentence = "How often: taps are 1, 2, 4, ... pixels apart.",
       .field = [](SpaceFilterSpec& f) -> Field { return &f.levels; },
       .range = at_least(1, 8),
       .when = with_kernel("a-trous")},
      {.key = "filter.space[].luminance",
       .type = Type::number,
       .sentence = "Difference of brightness at which a tap weighs 1/e, in standard deviations of the noise.",
       .field = [](SpaceFilterSpec& f) -> Field { return &f.luminance; },
       .range = above(0, 1000),
       .when = with_kernel("a-trous")},
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
