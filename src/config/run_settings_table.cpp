// The table of all settings of a run.
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

constexpr Word value_kernel_table[] = {
    {"distance", "minus the distance of the two samples: filter-adapted noise", "fast euclidean"},
    {"stbn", "exp(-d^(D/n) / sigma_s^2): spatiotemporal blue noise masks", "blue-noise bluenoise exponential"},
};

// In the order of Method.
constexpr Word method_table[] = {
    {"anneal", "swaps inside a slice, accepted by temperature", "annealing simulated-annealing sa swap swaps"},
    {"fast", "the published algorithm of filter-adapted sampling, for comparison", "paper ea"},
    {"void-and-cluster", "pixels turned on one by one, each in the largest void: scalar blue noise masks",
     "vc vnc void-cluster voidandcluster void_and_cluster ulichney"},
    {"construct",
     "scalars and circles placed one by one, each slice for itself, in the largest void that the filter sees",
     "construction constructive greedy"},
    {"auto", "construct for scalars and circles, anneal for all others", "automatic best"},
};

// In the order of Curve.
constexpr Word curve_table[] = {
    {"none", "samples of one number alone are constructed", "off no"},
    {"hilbert", "each step goes to a neighbour", "hilbert-curve peano"},
    {"morton", "the bits of the numbers by turns", "z-order z morton-curve lebesgue"},
};

constexpr Word precision_table[] = {
    {"float", "32 bits", "single fp32 float32"},
    {"double", "64 bits", "dual fp64 float64"},
};

constexpr Word equalize_table[] = {
    {"volume", "all slices together hold every level equally often", "all texture mask"},
    {"slice", "each slice does; costs about 1 % more power at low frequencies", "frame slices"},
};

// Bounds that no texture needs to pass, and within which all arithmetic on taps stays finite.
constexpr double max_reach = 65536;
constexpr double min_sigma = 0.001;

constexpr Condition with_kernel(std::string_view word) { return {"filter.groups[].kernel", word}; }
constexpr Condition with_method(std::string_view word) { return {"optimizer.method", word}; }
constexpr Condition with_swaps = {"optimizer.method", "anneal fast construct auto"};
constexpr Condition with_construction = {"optimizer.method", "construct auto"};
constexpr Condition with_annealing = {"optimizer.method", "anneal construct auto"};

// Kernels have defaults of their own.
void fit_defaults(const Owners& owners) {
  KernelSpec& kernel = owners.get<GroupSpec>().kernel;
  kernel = default_kernel(kernel.kind);
}

std::vector<Setting> rows() {
  return {
      {.key = "texture", .type = Type::table, .sentence = "What is made.", .required = true},
      {.key = "texture.size",
       .type = Type::custom,
       .sentence =
           "x and y, then the slice axes by name, in the order written (none for a single image). Any sizes: no "
           "power of two is needed.",
       .range = at_least(1),
       .unit = "pixels, slices",
       .required = true,
       .custom = &size_type},
      {.key = "texture.seed",
       .type = Type::integer,
       .sentence = "Another seed gives another texture of the same quality; the same seed gives the same bytes.",
       .field = [](RunConfig& c) -> Field { return &c.problem.seed; },
       .range = at_least(0)},

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
       .range = at_least(1, max_reach),
       .unit = "pixels",
       .when = with_kernel("box"),
       .required = true},
      {.key = "filter.groups[].sigma",
       .type = Type::number,
       .sentence = "Standard deviation of the filter; it is cut where 99.5 % of it is covered.",
       .field = [](GroupSpec& g) -> Field { return &g.kernel.sigma; },
       .range = at_least(min_sigma, max_reach),
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
       .range = at_least(min_sigma, max_reach),
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
       .range = at_least(1, max_reach),
       .unit = "slices",
       .when = with_kernel("gauss-energy"),
       .zero_is_unset = true},
      {.key = "filter.groups[].weight",
       .type = Type::number,
       .sentence = "Share of the group; given for all groups, adding up to 1, or for none (equal shares).",
       .field = [](GroupSpec& g) -> Field { return &g.weight; },
       .range = above(0, 1),
       .when = {"filter.combine", "sum"},
       .zero_is_unset = true},

      {.key = "energy", .type = Type::table, .sentence = "How samples are compared."},
      {.key = "energy.value_kernel",
       .type = Type::word,
       .sentence = "How alike two samples are.",
       .field = [](RunConfig& c) -> Field { return &c.problem.value_kernel.kind; },
       .words = value_kernel_table,
       .when = {"optimizer.method", "anneal fast auto"}},
      {.key = "energy.sigma_s",
       .type = Type::number,
       .sentence = "Distance at which two samples no longer count as alike.",
       .field = [](RunConfig& c) -> Field { return &c.problem.value_kernel.sigma_s; },
       .range = at_least(min_sigma, max_reach),
       .when = {"energy.value_kernel", "stbn"}},

      {.key = "optimizer", .type = Type::table, .sentence = "How it is made, and for how long."},
      {.key = "optimizer.method",
       .type = Type::word,
       .sentence =
           "The algorithm. void-and-cluster needs samples \"uniform\" and gauss-energy kernels, and combine "
           "\"sum\" where there are several groups; construct needs samples of one channel, and anneals what it "
           "has made where there is a stop rule.",
       .field = [](RunConfig& c) -> Field { return &c.optimizer.method; },
       .words = method_table},
      {.key = "optimizer.stop",
       .type = Type::table,
       .sentence = "When to stop: one of the four rules. If there is none, construct ends when every pixel has its "
                   "sample, and the others after { iterations = 1000 }.",
       .when = with_swaps,
       .one_of = true},
      {.key = "optimizer.stop.iterations",
       .type = Type::integer,
       .sentence = "After that many; one iteration is one candidate pair for every two samples.",
       .field = [](RunConfig& c) -> Field { return &c.optimizer.stop.iterations; },
       .range = at_least(1, 1e9),
       .zero_is_unset = true},
      {.key = "optimizer.stop.time",
       .type = Type::duration,
       .sentence = "After that long; the schedule is fitted to it, so the result depends on the machine.",
       .field = [](RunConfig& c) -> Field { return &c.optimizer.stop.time_s; },
       .range = above(0),
       .zero_is_unset = true},
      {.key = "optimizer.stop.score",
       .type = Type::number,
       .sentence = "When the relative error R (white noise: 1) is that low, or no longer run would make it so.",
       .field = [](RunConfig& c) -> Field { return &c.optimizer.stop.score; },
       .range = above(0, 1),
       .zero_is_unset = true},
      {.key = "optimizer.stop.improvement",
       .type = Type::number,
       .sentence = "When a hundred iterations more lower R by less than this fraction.",
       .field = [](RunConfig& c) -> Field { return &c.optimizer.stop.improvement; },
       .range = above(0, 1),
       .zero_is_unset = true},
      {.key = "optimizer.start",
       .type = Type::table,
       .sentence = "The arrangement that annealing goes on from, in place of a random one.",
       .when = {"optimizer.method", "anneal auto"}},
      {.key = "optimizer.start.file",
       .type = Type::file,
       .sentence =
           "A run file, or a .npy of the texture's shape, [slice axes..., y, x] or with the channels last. Each of "
           "its slices must hold the very samples of texture.samples, in any arrangement; for a texture of "
           "your own, name it in both places. Read when a run begins.",
       .field = [](RunConfig& c) -> Field { return &c.start.file; },
       .required = true,
       .zero_is_unset = true},
      {.key = "optimizer.precision",
       .type = Type::word,
       .sentence = "Arithmetic of the energy; the score is always computed in double.",
       .field = [](RunConfig& c) -> Field { return &c.optimizer.precision; },
       .words = precision_table,
       .when = with_swaps},
      {.key = "optimizer.cutoff",
       .type = Type::number,
       .sentence = "Taps of the overlap below this fraction of the largest are left out of the energy, never out of R.",
       .field = [](RunConfig& c) -> Field { return &c.optimizer.cutoff; },
       .range = at_least(0, 0.5),
       .when = with_swaps},
      {.key = "optimizer.background_features",
       .type = Type::integer,
       .sentence = "Product filters over slices: features that stand for the other slices (four times as many in the "
                   "last quarter, 64 in the last twentieth; four times from the start where other slices count much "
                   "and candidates are sieved), so that a deep "
                   "filter costs no more "
                   "than a shallow one. 0: every tap, exactly, as with precision \"double\".",
       .field = [](RunConfig& c) -> Field { return &c.optimizer.background_features; },
       .range = at_least(0, 64),
       .when = with_annealing,
       .former = "background_rank"},
      {.key = "optimizer.sieve_features",
       .type = Type::integer,
       .sentence = "Vectors and directions: features that the change by a swap is estimated with, so that only those "
                   "are judged by all taps that may be accepted. 0: all are judged.",
       .field = [](RunConfig& c) -> Field { return &c.optimizer.sieve_features; },
       .range = at_least(0, 64),
       .when = with_annealing},
      {.key = "optimizer.temperature",
       .type = Type::table,
       .sentence = "The temperatures of annealing; those left out are found from the problem.",
       .when = with_annealing,
       .check = check_temperatures},
      {.key = "optimizer.temperature.start",
       .type = Type::number,
       .sentence = "First temperature, in units of the mean change of energy of a swap.",
       .field = [](RunConfig& c) -> Field { return &c.optimizer.temperature_start; },
       .range = above(0),
       .zero_is_unset = true},
      {.key = "optimizer.temperature.end",
       .type = Type::number,
       .sentence = "Last temperature, in the same unit.",
       .field = [](RunConfig& c) -> Field { return &c.optimizer.temperature_end; },
       .range = above(0),
       .zero_is_unset = true},
      {.key = "optimizer.fraction",
       .type = Type::number,
       .sentence = "Share of the pairs that may swap at once, at first.",
       .field = [](RunConfig& c) -> Field { return &c.optimizer.fraction; },
       .range = above(0, 1),
       .when = with_method("fast")},
      {.key = "optimizer.grow_fraction",
       .type = Type::boolean,
       .sentence = "Double that share when few swaps are accepted.",
       .field = [](RunConfig& c) -> Field { return &c.optimizer.grow_fraction; },
       .when = with_method("fast")},
      {.key = "optimizer.density",
       .type = Type::number,
       .sentence =
           "Share of the pixels that the initial pattern turns on; 0: there is none, which is bluer and quicker (the "
           "paper has 0.1).",
       .field = [](RunConfig& c) -> Field { return &c.order.density; },
       .range = at_least(0, 0.5),
       .when = with_method("void-and-cluster")},
      {.key = "optimizer.density",
       .type = Type::number,
       .sentence =
           "Share of the pixels of a slice in the pattern that construction starts from (on a circle it is half).",
       .field = [](RunConfig& c) -> Field { return &c.construct.density; },
       .range = at_least(0, 0.5),
       .when = with_construction},
      {.key = "optimizer.sharpness",
       .type = Type::number,
       .sentence = "Power that the overlap of the filter is raised to in space, as construction wants it sharper than "
                   "it is; found from the filter where it is left out (plan says what it is).",
       .field = [](RunConfig& c) -> Field { return &c.construct.sharpness; },
       .range = above(0, 8),
       .when = with_construction,
       .zero_is_unset = true},
      {.key = "optimizer.curve",
       .type = Type::word,
       .sentence =
           "For samples vector2, vector3 and vector4: a curve that orders them, so that they are constructed as "
           "scalars are. Quicker than annealing, and not as good.",
       .field = [](RunConfig& c) -> Field { return &c.problem.samples.curve; },
       .words = curve_table,
       .when = with_construction,
       .zero_is_unset = true},
      {.key = "optimizer.bounded",
       .type = Type::custom,
       .sentence = "Axes that do not wrap around, written as those of a group; all others do.",
       .field = [](RunConfig& c) -> Field { return &c.order.bounded; },
       .when = with_method("void-and-cluster"),
       .custom = &axes_type},
      {.key = "optimizer.bits",
       .type = Type::integer,
       .sentence = "0: samples are (order + 0.5) / pixels. n: they have 2^n levels, (level + 0.5) / 2^n, with equal "
                   "counts.",
       .field = [](RunConfig& c) -> Field { return &c.order.bits; },
       .range = at_least(0, 16),
       .when = with_method("void-and-cluster")},
      {.key = "optimizer.equalize",
       .type = Type::word,
       .sentence = "What holds every level equally often.",
       .field = [](RunConfig& c) -> Field { return &c.order.equalize; },
       .words = equalize_table,
       .when = with_method("void-and-cluster")},
  };
}

std::span<const Setting> all() {
  static const std::vector<Setting> table = with_rows_of_samples(rows());
  return table;
}

}  // namespace

const FileKind& run_config_kind() {
  static const FileKind kind = file_kind<RunConfig>({.noun = "config",
                                                     .settings = all(),
                                                     .check = check_method,
                                                     .override_example = "texture.seed=2 or filter.groups[0].size=3"});
  return kind;
}

KernelSpec default_kernel(KernelKind kind) {
  KernelSpec kernel;
  kernel.kind = kind;
  if (kind == KernelKind::gauss_energy) kernel.sigma = 1.9;  // [STBN22], [Ulichney93]
  return kernel;
}

}  // namespace noiseloom::settings
