// The settings of [filter]: its groups, and the kernels that they may have.
#include <algorithm>
#include <vector>

#include "config/run_settings.h"

namespace noiseloom::settings {
namespace {

constexpr Word combine_table[] = {
    {"product", "one filter over all axes: what a denoiser does that blurs in space and accumulates over time",
     "multiply separable"},
    {"sum", "each group on its own: good over space, and good over time for a pixel that is looked at alone",
     "separate add"},
};

constexpr Word kernel_table[] = {
    {"box", "mean of `size` pixels along each axis", "mean average blur uniform"},
    {"gauss", "Gaussian, integrated over each pixel", "gaussian normal"},
    {"binomial", "n + 1 binomial coefficients along each axis; n = 2 is 1 2 1", "pascal tent"},
    {"ema", "exponential moving average of a temporal accumulation that rejects its history now and then",
     "exponential exp taa temporal history"},
    {"table", "taps from a file", "file custom taps"},
    {"gauss-energy", "exp(-r^2 / 2 sigma^2) as the energy itself: the blue noise of void and cluster",
     "bluenoise blue-noise blue stbn void-and-cluster gaussian-energy"},
    {"eye", "what the eye sees of a flicker from frame to frame: a filter over time", "perceptual csf vision human"},
};

constexpr Condition with_kernel(std::string_view word) { return {"filter.groups[].kernel", word}; }

// Kernels have defaults of their own.
void fit_defaults(const Owners& owners) {
  KernelSpec& kernel = owners.get<GroupSpec>().kernel;
  kernel = default_kernel(kernel.kind);
}

std::vector<Setting> rows_of_filter() {
  return {
      {.key = "filter",
       .type = Type::table,
       .sentence = "What the renderer does to the noise; the texture is made for it.",
       .required = true},
      {.key = "filter.combine",
       .type = Type::word,
       .sentence = "How the groups work together.",
       .field = [](RunConfig& c) -> Field { return &c.problem.filter.combine; },
       .words = combine_table},
      {.key = "filter.groups",
       .type = Type::tables,
       .sentence = "One kernel for each set of axes. Axes in no group are left white.",
       .field = [](RunConfig& c) -> Field { return &c.problem.filter.groups; },
       .required = true,
       .example = R"({ axes = "xy", kernel = "box", size = 5 })",
       .check = check_groups},
      {.key = "filter.groups[].axes",
       .type = Type::custom,
       .sentence = "The axes of the group: \"xy\", \"t\", or a list such as [\"time\"] where names are longer than a "
                   "letter. With product an axis belongs to one group.",
       .field = [](GroupSpec& g) -> Field { return &g.axes; },
       .required = true,
       .custom = &axes_type},
      {.key = "filter.groups[].kernel",
       .type = Type::word,
       .sentence = "The filter along these axes.",
       .field = [](GroupSpec& g) -> Field { return &g.kernel.kind; },
       .words = kernel_table,
       .required = true,
       .chosen = fit_defaults},
      {.key = "filter.groups[].size",
       .type = Type::integer,
       .sentence = "Taps along each axis.",
       .field = [](GroupSpec& g) -> Field { return &g.kernel.size; },
       .range = at_least(1, largest_reach),
       .unit = "pixels",
       .when = with_kernel("box"),
       .required = true},
      {.key = "filter.groups[].sigma",
       .type = Type::number,
       .sentence = "Standard deviation of the filter; it is cut where 99.5 % of it is covered.",
       .field = [](GroupSpec& g) -> Field { return &g.kernel.sigma; },
       .range = at_least(least_sigma, largest_reach),
       .unit = "pixels",
       .when = with_kernel("gauss"),
       .required = true},
      {.key = "filter.groups[].n",
       .type = Type::integer,
       .sentence = "Order; n + 1 taps along each axis.",
       .field = [](GroupSpec& g) -> Field { return &g.kernel.n; },
       .range = at_least(1, 1000),
       .when = with_kernel("binomial"),
       .required = true},
      {.key = "filter.groups[].alpha",
       .type = Type::number,
       .sentence = "Weight of the newest frame.",
       .field = [](GroupSpec& g) -> Field { return &g.kernel.alpha; },
       .range = above(0, 1),
       .when = with_kernel("ema"),
       .required = true},
      {.key = "filter.groups[].rejection",
       .type = Type::number,
       .sentence = "Probability that a pixel loses its history in a frame.",
       .field = [](GroupSpec& g) -> Field { return &g.kernel.rejection; },
       .range = at_least(0, 1),
       .when = with_kernel("ema")},
      {.key = "filter.groups[].file",
       .type = Type::file,
       .sentence =
           "A .npy of one dimension, the taps along each axis of the group; or of as many as the group has axes, the "
           "first axis of the texture last: [y, x] for \"xy\", [t, y, x] for \"xyt\", however the axes are listed. "
           "Which tap is the middle one does not matter, nor does a mirrored table. Taps are taken as they are, not "
           "scaled to add up to 1: with product R is the same, with sum a group of taps that add up to 2 counts four "
           "times. Negative ones are taken too, with a word to say so. Read when a run begins, and kept in its run "
           "file.",
       .field = [](GroupSpec& g) -> Field { return &g.kernel.file; },
       .when = with_kernel("table"),
       .required = true},
      {.key = "filter.groups[].sigma",
       .type = Type::number,
       .sentence = "Width of the energy.",
       .field = [](GroupSpec& g) -> Field { return &g.kernel.sigma; },
       .range = at_least(least_sigma, largest_reach),
       .unit = "pixels",
       .when = with_kernel("gauss-energy")},
      {.key = "filter.groups[].frames_per_second",
       .type = Type::number,
       .sentence = "Of the display.",
       .field = [](GroupSpec& g) -> Field { return &g.kernel.frames_per_second; },
       .range = at_least(1, 1000),
       .when = with_kernel("eye"),
       .required = true},
      {.key = "filter.groups[].pixels_per_degree",
       .type = Type::number,
       .sentence = "Of the field of view: a monitor on a desk has 30 to 60, a headset 15 to 35.",
       .field = [](GroupSpec& g) -> Field { return &g.kernel.pixels_per_degree; },
       .range = at_least(1, 500),
       .when = with_kernel("eye"),
       .required = true},
      {.key = "filter.groups[].box",
       .type = Type::custom,
       .sentence =
           "Slice axes of the group along which the energy is not that of a Gaussian, but of the sum of box_size "
           "slices in a row: their union is blue and, with void-and-cluster, they share no pixel.",
       .field = [](GroupSpec& g) -> Field { return &g.kernel.box_axes; },
       .when = with_kernel("gauss-energy"),
       .custom = &some_axes_type},
      {.key = "filter.groups[].box_size",
       .type = Type::integer,
       .sentence = "How many slices in a row make such a sum; as many as the axis has: all of them.",
       .field = [](GroupSpec& g) -> Field { return &g.kernel.box_size; },
       .range = at_least(1, largest_reach),
       .unit = "slices",
       .when = with_kernel("gauss-energy"),
       .zero_is_unset = true},
      {.key = "filter.groups[].tiles",
       .type = Type::custom,
       .sentence =
           "With void-and-cluster: slice axes of the group whose slices are tiles, any of which may lie beside any "
           "other: what is near an edge in x or y is blue together with the far side of every tile, while inside they "
           "do not act on each other. The group must have x and y. R is that of each tile repeated beside itself.",
       .field = [](GroupSpec& g) -> Field { return &g.kernel.tile_axes; },
       .when = with_kernel("gauss-energy"),
       .custom = &some_axes_type},
      {.key = "filter.groups[].tail",
       .type = Type::number,
       .sentence =
           "With void-and-cluster: the energy is at least tail / (tail + r^(2 tail_power)) at distance r, so that the "
           "first pixels, which are out of each other's Gaussian, keep far apart too; it reaches over the "
           "whole texture, which takes time.",
       .field = [](GroupSpec& g) -> Field { return &g.kernel.tail; },
       .range = above(0, 1),
       .when = with_kernel("gauss-energy"),
       .zero_is_unset = true},
      {.key = "filter.groups[].tail_power",
       .type = Type::number,
       .sentence = "How fast the tail falls: as the distance to the power of -2 tail_power; 1 where it is left out.",
       .field = [](GroupSpec& g) -> Field { return &g.kernel.tail_power; },
       .range = at_least(0.5, 16),
       .when = with_kernel("gauss-energy"),
       .zero_is_unset = true},
      {.key = "filter.groups[].weight",
       .type = Type::number,
       .sentence = "Share of the group; given for all groups, adding up to 1, or for none (equal shares).",
       .field = [](GroupSpec& g) -> Field { return &g.weight; },
       .range = above(0, 1),
       .when = {"filter.combine", "sum"},
       .zero_is_unset = true},
  };
}

}  // namespace

std::vector<Setting> with_rows_of_filter(std::vector<Setting> rows) {
  const std::vector<Setting> own = rows_of_filter();
  const auto energy = std::find_if(rows.begin(), rows.end(), [](const Setting& s) { return s.key == "energy"; });
  rows.insert(energy, own.begin(), own.end());
  return rows;
}

KernelSpec default_kernel(KernelKind kind) {
  KernelSpec kernel;
  kernel.kind = kind;
  if (kind == KernelKind::gauss_energy) kernel.sigma = 1.9;  // [STBN22], [Ulichney93]
  return kernel;
}

}  // namespace noiseloom::settings
