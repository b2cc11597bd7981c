// The table of all settings of a scene.
#include "render/scene/scene_settings.h"

#include <iterator>

namespace noiseloom::render {
namespace {

constexpr double largest_size = 8192;

constexpr Word output_words[] = {
    {"curves", "the error of every frame: curves.csv", "plots csv"},
    {"images", "the last frame after every filter, and its error", "pictures png"},
    {"predictions", "beside each error what the score of the texture promises", "score r sqrt-r"},
    {"spectra", "of the error, over the picture and over time: spectra.csv, pictures, powers in bands",
     "spectrum dft fft"},
};

constexpr Word metric_words[] = {
    {"deviation", "of the error around its own mean, as an error of brightness alone does not count", "std stddev"},
    {"ssim", "1 - structural similarity, over windows of 11 pixels", "dssim structure"},
    {"bands", "the error below 0.05 cycles a pixel, from there to 0.15, and above: low, middle, high", "band power"},
    {"unseen", "effects.sparse: the share of pixels that no frame so far has sampled", "coverage unique"},
    {"pattern",
     "1 - the rank correlation of the error with the mask that heitz-belcour follows, in windows of 8 pixels",
     "target stylised"},
    {"flip", "the difference that is seen when picture and truth are shown in turns, at 67 pixels a degree",
     "perceptual"},
    {"quantiles",
     "of a pixel's error the median, what 99 % stay below, and the largest: few wrong pixels move the last alone",
     "median percentile fireflies outliers p99"},
};

// In the order of Metric.
constexpr Word measured_words[] = {
    {"rmse", "the root of the mean squared error", "mse error"},
    {"deviation", "the same around the error's own mean", "std stddev"},
    {"ssim", "1 - structural similarity", "dssim"},
    {"low", "the error below 0.05 cycles a pixel"},
    {"middle", "the error from 0.05 to 0.15 cycles a pixel"},
    {"high", "the error above 0.15 cycles a pixel"},
    {"unseen", "the share of pixels without a sample so far", "coverage"},
    {"pattern", "1 - the rank correlation of the error with a mask"},
    {"flip", "the mean of FLIP"},
    {"median", "the median of the pixels' errors"},
    {"p99", "what the errors of 99 % of the pixels stay below", "percentile-99"},
    {"largest", "the largest error of a pixel", "max firefly"},
};

constexpr Word time_words[] = {{"frame", "each frame alone", "none raw"},
                               {"ema", "exponential moving average", "exponential taa"},
                               {"mc", "mean of all frames so far", "monte-carlo cumulative ca"}};

std::vector<Setting> rows_of_image() {
  return {
      {.key = "title",
       .type = Type::text,
       .sentence = "What the scene shows.",
       .field = [](Scene& s) -> Field { return &s.title; }},
      {.key = "image", .type = Type::table, .sentence = "What is rendered."},
      {.key = "image.width",
       .type = Type::integer,
       .sentence = "Width.",
       .field = [](Scene& s) -> Field { return &s.width; },
       .range = at_least(1, largest_size),
       .unit = "pixels"},
      {.key = "image.height",
       .type = Type::integer,
       .sentence = "Height.",
       .field = [](Scene& s) -> Field { return &s.height; },
       .range = at_least(1, largest_size),
       .unit = "pixels"},
      {.key = "image.frames",
       .type = Type::integer,
       .sentence = "Frames in a row.",
       .field = [](Scene& s) -> Field { return &s.frames; },
       .range = at_least(1, 1e6)},
      {.key = "image.repeats",
       .type = Type::integer,
       .sentence =
           "How often all is rendered again, with every noise moved to another place and time: errors are means "
           "over these, and standard errors come from how they differ.",
       .field = [](Scene& s) -> Field { return &s.repeats; },
       .range = at_least(1, 4096)},
      {.key = "image.seed",
       .type = Type::integer,
       .sentence = "Chooses where noises are moved to.",
       .field = [](Scene& s) -> Field { return &s.seed; },
       .range = at_least(0)},
      {.key = "image.outputs",
       .type = Type::word,
       .sentence = "What is written beside the table of results. What no output needs is not computed.",
       .field = [](Scene& s) -> Field { return &s.outputs; },
       .list = true,
       .words = output_words},
      {.key = "image.metrics",
       .type = Type::word,
       .sentence = "What is measured in every picture beside the root of the mean squared error.",
       .field = [](Scene& s) -> Field { return &s.metrics; },
       .list = true,
       .words = metric_words},
  };
}

std::vector<Setting> rows_of_expectations() {
  return {
      {.key = "expect",
       .type = Type::tables,
       .sentence = "What must come out: with any of these a scene is a test.",
       .field = [](Scene& s) -> Field { return &s.expects; },
       .example = "{ order = \"stbn < white\", time = \"ema\" }"},
      {.key = "expect[].order",
       .type = Type::text,
       .sentence = "Noises by their errors: \"fast < stbn < white\"; \"a = b\" where the two differ by no more than "
                   "`within`, or by chance. A "
                   "difference counts from two standard errors on; below, the order is undecided, and not fulfilled.",
       .field = [](ExpectSpec& e) -> Field { return &e.order; },
       .zero_is_unset = true},
      {.key = "expect[].metric",
       .type = Type::word,
       .sentence = "By what errors are compared; other than rmse it must be among image.metrics.",
       .field = [](ExpectSpec& e) -> Field { return &e.metric; },
       .words = measured_words},
      {.key = "expect[].noise",
       .type = Type::text,
       .sentence = "In place of an order: the noise whose error has a value of its own.",
       .field = [](ExpectSpec& e) -> Field { return &e.noise; },
       .zero_is_unset = true},
      {.key = "expect[].rmse",
       .type = Type::number,
       .sentence = "Its root of the mean squared error, or its value of another metric.",
       .field = [](ExpectSpec& e) -> Field { return &e.rmse; },
       .range = settings::above(0),
       .zero_is_unset = true},
      {.key = "expect[].ratio",
       .type = Type::number,
       .sentence = "Its error over that of another noise.",
       .field = [](ExpectSpec& e) -> Field { return &e.ratio; },
       .range = settings::above(0),
       .zero_is_unset = true},
      {.key = "expect[].against",
       .type = Type::text,
       .sentence = "That other noise.",
       .field = [](ExpectSpec& e) -> Field { return &e.against; }},
      {.key = "expect[].within",
       .type = Type::number,
       .sentence = "How far the value may be off, or errors that are to be equal apart, as a share; beside three "
                   "standard errors.",
       .field = [](ExpectSpec& e) -> Field { return &e.within; },
       .range = at_least(0, 1)},
      {.key = "expect[].effect",
       .type = Type::text,
       .sentence = "Which effect; may be left out where there is one.",
       .field = [](ExpectSpec& e) -> Field { return &e.effect; },
       .zero_is_unset = true},
      {.key = "expect[].time",
       .type = Type::word,
       .sentence = "After which filter over time.",
       .field = [](ExpectSpec& e) -> Field { return &e.time; },
       .words = time_words},
      {.key = "expect[].space",
       .type = Type::text,
       .sentence = "After which filter over space, by its name; \"none\" before all.",
       .field = [](ExpectSpec& e) -> Field { return &e.space; }},
      {.key = "expect[].frame",
       .type = Type::integer,
       .sentence = "At which frame, counted from 1; the last where it is not said.",
       .field = [](ExpectSpec& e) -> Field { return &e.frame; },
       .range = at_least(1),
       .zero_is_unset = true},
      {.key = "expect[].source",
       .type = Type::text,
       .sentence = "Where it is claimed; shown with the outcome.",
       .field = [](ExpectSpec& e) -> Field { return &e.source; },
       .zero_is_unset = true},
  };
}

std::vector<Setting> all_rows() {
  std::vector<Setting> rows;
  for (std::vector<Setting> part : {rows_of_image(), rows_of_noises(), rows_of_effects(), rows_of_object(),
                                    rows_of_more_effects(), rows_of_filters(), rows_of_expectations()})
    rows.insert(rows.end(), std::make_move_iterator(part.begin()), std::make_move_iterator(part.end()));
  return rows;
}

}  // namespace

const settings::FileKind& scene_kind() {
  static const std::vector<Setting> rows = all_rows();
  static const settings::FileKind kind = settings::file_kind<Scene>(
      {.noun = "scene", .settings = rows, .check = check_scene, .override_example = "image.frames=16"});
  return kind;
}

}  // namespace noiseloom::render
