// The table of all settings of a run.
#include <vector>

#include "config/run_settings.h"

namespace noiseloom::settings {
namespace {

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

// In the order of Stratify.
constexpr Word stratify_table[] = {
    {"slice", "one sample in each stratum of a slice", "space spatial"},
    {"slice+time", "and every pixel visits each of T strata once in the T slices along t, in an order of its own",
     "time temporal slice-time"},
};

// In the order of StartPattern.
constexpr Word start_pattern_table[] = {
    {"none", "as without a start", "no off"},
    {"lattice",
     "scalars in a rank-1 lattice that has little R under the filter: stripes, all but the best there is under small "
     "boxes",
     "rank-1 rank1 regular"},
};

constexpr Word precision_table[] = {
    {"float", "32 bits", "single fp32 float32"},
    {"double", "64 bits", "dual fp64 float64"},
};

constexpr Word equalize_table[] = {
    {"volume", "all slices together hold every level equally often", "all texture mask"},
    {"slice", "each slice does; costs about 1 % more power at low frequencies", "frame slices"},
};

constexpr Condition with_method(std::string_view word) { return {"optimizer.method", word}; }
constexpr Condition with_swaps = {"optimizer.method", "anneal fast construct auto"};
constexpr Condition with_construction = {"optimizer.method", "construct auto"};
constexpr Condition with_points_in_voids = {"optimizer.method", "construct auto void-and-cluster"};
constexpr Condition with_annealing = {"optimizer.method", "anneal construct auto"};

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
      {.key = "texture.stratify",
       .type = Type::word,
       .sentence =
           "What the strata of the samples are spread over. With slice+time the length of the axis t divides the "
           "pixels of a slice; samples are annealed within what was constructed for it.",
       .field = [](RunConfig& c) -> Field { return &c.problem.stratify; },
       .words = stratify_table,
       .when = with_swaps},

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
       .range = at_least(least_sigma, largest_reach),
       .when = {"energy.value_kernel", "stbn"}},

      {.key = "optimizer", .type = Type::table, .sentence = "How it is made, and for how long."},
      {.key = "optimizer.method",
       .type = Type::word,
       .sentence =
           "The algorithm. void-and-cluster needs samples \"uniform\" or a curve, and gauss-energy kernels, and "
           "combine "
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
       .when = {"optimizer.method", "anneal auto"},
       .one_of = true},
      {.key = "optimizer.start.file",
       .type = Type::file,
       .sentence =
           "A run file, or a .npy of the texture's shape, [slice axes..., y, x] or with the channels last. Each of "
           "its slices must hold the very samples of texture.samples, in any arrangement; for a texture of "
           "your own, name it in both places. Read when a run begins.",
       .field = [](RunConfig& c) -> Field { return &c.start.file; },
       .zero_is_unset = true},
      {.key = "optimizer.start.pattern",
       .type = Type::word,
       .sentence = "A pattern that is made for the filter.",
       .field = [](RunConfig& c) -> Field { return &c.start.pattern; },
       .words = start_pattern_table,
       .zero_is_unset = true},
      {.key = "optimizer.precision",
       .type = Type::word,
       .sentence = "Arithmetic of the energy; the score is always computed in double.",
       .field = [](RunConfig& c) -> Field { return &c.optimizer.precision; },
       .words = precision_table,
       .when = with_swaps},
      {.key = "optimizer.cutoff",
       .type = Type::number,
       .sentence =
           "Taps of the overlap below this fraction of the largest (of a sum: of the largest of their group) are "
           "left out of the energy, never out of R. Not given: 0.001, and with method \"fast\" 0.",
       .field = [](RunConfig& c) -> Field { return &c.optimizer.cutoff; },
       .range = at_least(0, 0.5),
       .when = with_swaps,
       .negative_is_unset = true},
      {.key = "optimizer.background_features",
       .type = Type::integer,
       .sentence =
           "Product filters over slices: features that stand for the other slices (four times as many in the "
           "coldest quarter, 64 in the coldest twentieth; four times from the start where other slices count much "
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
       .sentence =
           "The temperatures of annealing; those left out are found from the problem. Where one is given, it falls "
           "geometrically from start to end, and else as was measured to be best for the kind of filter.",
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
           "For samples vector2, vector3 and vector4: a curve that orders them, so that they are made as scalars are. "
           "Quicker than annealing, and not as good. With void-and-cluster it needs equalize = \"slice\".",
       .field = [](RunConfig& c) -> Field { return &c.problem.samples.curve; },
       .words = curve_table,
       .when = with_points_in_voids,
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
  static const std::vector<Setting> table = with_rows_of_filter(with_rows_of_samples(rows()));
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

}  // namespace noiseloom::settings
