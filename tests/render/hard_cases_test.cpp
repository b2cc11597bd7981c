// Numbers at the ends of their range, chances of nearly nothing, places without an end: what breaks renderers.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "noiseloom/core/error.h"
#include "noiseloom/core/math.h"
#include "noiseloom/files/image_decoder.h"
#include "noiseloom/files/npy.h"
#include "render/scene_support.h"
#include "render/world/kernel.h"
#include "render/world/sky_light.h"
#include "render/world/surface.h"
#include "support/run_files.h"

namespace noiseloom::render {
namespace {

constexpr float largest_below_one = 0x1.fffffep-1F;

Noise noise_of_values(std::vector<float> values, int channels = 1, const std::string& space = "uniform") {
  const auto cells = static_cast<std::int32_t>(values.size()) / channels;
  Texture texture = make_texture(Extents({cells, 1, 1}), channels);
  texture.values = std::move(values);
  Noise noise{.spec = {.kind = NoiseKind::file, .name = "values"},
              .texture = std::make_shared<const Texture>(std::move(texture)),
              .channels = channels};
  noise.samples.space = space;
  noise.extents = noise.texture->extents;
  return noise;
}

Result rendered_with(const std::string& text, const Noise& noise) {
  ThreadPool pool(1);
  return render(scene_of(text), {noise}, pool);
}

std::string picture_text(int width, int frames, const std::string& effects) {
  return "[image]\nwidth = " + std::to_string(width) + "\nheight = 5\nframes = " + std::to_string(frames) +
         "\nrepeats = 1\noutputs = [\"images\"]\n[[noise]]\nkind = \"white\"\n" + effects;
}

// 0 and the largest number below 1 are numbers as all others: vacuum scatters nothing, what is opaque hides all.
TEST(HardCases, NumbersAtTheEndsOfTheirRange) {
  const Noise ends = noise_of_values({0, largest_below_one, 0.5F, 0x1p-24F});
  const Result vacuum =
      rendered_with(picture_text(4, 1, "[effects.free-flight]\n[effects.ray-march]\n[volume]\nextinction = 0\n"), ends);
  for (const double square : vacuum.squares) EXPECT_EQ(square, 0);
  for (const char* const alpha : {"[0]", "[1]", "[0, 1]"})
    for (const double square :
         rendered_with(picture_text(4, 1, "[effects.transparency]\nalpha = " + std::string(alpha) + "\n"), ends)
             .squares)
      EXPECT_EQ(square, 0) << alpha;
  const Result opaque = rendered_with(
      picture_text(4, 1, "[effects.free-flight]\n[volume]\ndensity = \"slab\"\nextinction = 1e4\nalbedo = 0\n"), ends);
  for (const float value : opaque.pictures[0].values) EXPECT_EQ(value, 0);
  const Result levels = rendered_with(picture_text(4, 1, "[effects.dither]\nbits = 1\n"), ends);
  for (const float value : levels.pictures[0].values) EXPECT_TRUE(value == 0 || value == 1);
  for (const char* const effect : {"[effects.ambient-occlusion]\n", "[effects.ambient-occlusion]\nuniform = true\n",
                                   "[effects.soft-shadow]\n", "[effects.sky]\n", "[effects.convolution]\n"})
    for (const double square : rendered_with(picture_text(4, 1, effect), ends).squares)
      EXPECT_TRUE(std::isfinite(square)) << effect;
}

// Codes over 255 reach 1: it is read as what is just below, and that is said.
TEST(HardCases, ANumberOfOneIsReadAsTheLargestBelow) {
  const TemporaryFolder folder;
  const NoiseSpec spec{.kind = NoiseKind::file, .name = "codes", .file = folder / "codes.npy"};
  const auto opened = [&](float last) {
    write_npy(spec.file, std::array<std::int64_t, 2>{2, 3}, std::array<float, 6>{0, 0.25F, 0.5F, 0.75F, 1, last});
    return open_noise(spec, "", nullptr);
  };
  const Noise noise = opened(1);
  EXPECT_EQ(*std::max_element(noise.texture->values.begin(), noise.texture->values.end()), largest_below_one);
  EXPECT_NE(noise.notes.back().find("2 of its 6 numbers are 1"), std::string::npos) << noise.notes.back();
  for (const double square : rendered_with(picture_text(4, 1, "[effects.transparency]\nalpha = [1]\n"), noise).squares)
    EXPECT_EQ(square, 0);
  EXPECT_THROW(opened(1.5F), UserError);
}

// Numbers of eight bits have no opacities between multiples of 1/256: the mean over all codes is the next of those, and
// that it is another is a part of the error.
TEST(HardCases, EightBitsGiveOpacitiesInTheirOwnSteps) {
  std::vector<float> codes;
  for (int code = 0; code < 256; ++code) codes.push_back((static_cast<float>(code) + 0.5F) / 256);
  for (const double alpha : {1.0 / 255, 0.3, 0.501}) {
    const Result result =
        rendered_with(picture_text(256, 1, "[effects.transparency]\nalpha = [" + std::to_string(alpha) + "]\n"),
                      noise_of_values(codes));
    const auto there = std::count(result.pictures[0].values.begin(), result.pictures[0].values.begin() + 256, 0.9F);
    EXPECT_EQ(there, std::lround(256 * alpha)) << alpha;
  }
}

// The lower ends of directions of eight bits: some lie in the plane or just below it, flipped ones across the normal.
TEST(HardCases, DirectionsOfEightBitsAndThoseInThePlane) {
  std::vector<float> codes;
  for (int c = 0; c < 3; ++c)
    for (int place = 0; place < 4096; ++place) {
      const int i = place * 1531 % 4096;  // in no order over the picture
      const double v = i * 0.6180339887498949;
      const Vector exact = cosine_direction((i + 0.5) / 4096, v - std::floor(v));
      const double value = c == 0 ? exact.x : c == 1 ? exact.y : exact.z;
      codes.push_back(static_cast<float>(std::round((value * 0.5 + 0.5) * 255) / 255 * 2 - 1));
    }
  codes[3 * 4096 - 1] = -1.0F / 255;
  const std::string image = "[image]\nwidth = 4096\nheight = 2\nframes = 1\nrepeats = 1\n[[noise]]\nkind = \"white\"\n";
  for (const char* const uniform : {"false", "true"}) {
    const Result result = rendered_with(image + "[effects.ambient-occlusion]\nuniform = " + uniform + "\n",
                                        noise_of_values(codes, 3, "hemisphere-cosine"));
    double error = 0;
    for (std::size_t i = 0; i < result.pictures[0].values.size(); ++i) {
      EXPECT_TRUE(result.pictures[0].values[i] >= 0 && result.pictures[0].values[i] <= 2);
      error += static_cast<double>(result.pictures[0].values[i] - result.truths[0].values[i]) /
               static_cast<double>(result.pictures[0].values.size());
    }
    EXPECT_NEAR(error, 0, 0.01) << uniform;
    // Along axes: to the normal, against it and at right angles to it.
    for (const char* const space : {"sphere", "hemisphere-cosine"}) {
      const Result along_axes =
          rendered_with(picture_text(6, 1, "[effects.ambient-occlusion]\nuniform = " + std::string(uniform) + "\n"),
                        noise_of_values({1, -1, 0, 0, 0, 0, 0, 0, 1, -1, 0, 0, 0, 0, 0, 0, 1, -1}, 3, space));
      for (const float value : along_axes.pictures[0].values) EXPECT_TRUE(value >= 0 && value <= 2) << space << value;
    }
  }
}

// Masses of nearly nothing are drawn as seldom, and none divides by them: mass over chance is 1 on average, and what is
// heavy is said, not clamped.
TEST(HardCases, WeightsAreWhatTheyAre) {
  const std::vector<double> masses = {0, 1e-7, 1e-20, 1, 0, 1.0 / 255, 0, 0, 0};
  const MassTable table(3, 3, masses);
  const std::vector<double> even(9, 1.0 / 9);
  double mean = 0;
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 3; ++x) mean += table.mass({x, y});
  EXPECT_NEAR(mean, 1, 1e-15);
  const Weights weights = weights_of(table, even);
  EXPECT_NEAR(weights.largest, 9 / (1 + 1.0 / 255 + 1e-7), 1e-12);
  EXPECT_EQ(weights.above_clamp, 0);
  EXPECT_EQ(weights_of(table, {0.5, 0.5, 0, 0, 0, 0, 0, 0, 0}).largest,
            table.mass({1, 0}) / 0.5);  // never drawn: no weight
  std::vector<double> chances(9, 0.125 - 1e-3 / 8);
  chances[3] = 1e-3;
  const double heavy = table.mass({0, 1});
  EXPECT_NEAR(weights_of(table, chances).largest, heavy / 1e-3, 1e-9);
  EXPECT_NEAR(weights_of(table, chances).above_clamp, heavy - weight_clamp * 1e-3, 1e-12);
}

TEST(HardCases, HeavyWeightsAreSaidAndNotClamped) {
  const std::string even =
      "[image]\nwidth = 40\nheight = 30\nframes = 2\nrepeats = 1\n[[noise]]\nkind = \"white\"\n[[noise]]\nname = "
      "\"even\"\nkind = \"white\"\nimportance = false\n";
  const Result sky = rendered(even + "[effects.sky]\n");
  ASSERT_EQ(sky.notes.size(), 1U);
  // Four texels of the sun have most of the light: each weighs its share of it over its share of the hemisphere.
  const SkyLight light = make_sky({});
  std::vector<double> chances = light.solid_angles;
  for (double& chance : chances) chance /= math::two_pi;
  const Weights weights = weights_of(light.cells, chances);
  EXPECT_GT(weights.largest, weight_clamp);
  EXPECT_EQ(sky.notes[0], note_of_weights("even", "sky", weights));
  EXPECT_NE(sky.notes[0].find("% of the mean (nothing is clamped)"), std::string::npos) << sky.notes[0];
  const Result blur = rendered(even + "[effects.convolution]\nsize = 9\n");
  ASSERT_EQ(blur.notes.size(), 1U);
  EXPECT_NE(blur.notes[0].find("weighs up to 1.2"), std::string::npos) << blur.notes[0];
  EXPECT_NE(blur.notes[0].find("would change nothing"), std::string::npos) << blur.notes[0];
}

// By the light of cells, which is the light itself over its own chance: a cell of a ten-millionth of it is no brighter
// than another, and a black one is never seen.
TEST(HardCases, CellsOfHardlyAnyLightAreNotBright) {
  set_image_decoder([](const std::string&) {
    std::vector<float> light(64 * 32, 1e-7F);
    for (std::size_t i = 0; i < light.size(); ++i) light[i] = i % 64 == 9 ? 1.0F : i % 64 < 9 ? 0.0F : light[i];
    return std::make_shared<const InputArray>(InputArray{{32, 64, 1}, light});
  });
  Scene scene = scene_of(picture_text(40, 64, "[effects.sky]\n[filter.time]\nkernels = [\"mc\"]\n"));
  scene.sky.file = "sky";
  std::vector<float> numbers;
  for (int i = 0; i < 512; ++i) {
    const double u = i * 0.7548776662466927;
    const double v = i * 0.5698402909980532;
    numbers.push_back(static_cast<float>(i % 2 == 0 ? u - std::floor(u) : v - std::floor(v)));
  }
  numbers.insert(numbers.end(), {0, largest_below_one, largest_below_one, 0});
  ThreadPool pool(1);
  const Result result = render(scene, {noise_of_values(numbers)}, pool);
  set_image_decoder(nullptr);
  for (const float value : result.pictures[0].values) EXPECT_TRUE(value >= 0 && value <= 8) << value;
}

TEST(HardCases, PlacesWithoutAnEndAreNoDistanceApart) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  constexpr int side = 9;
  Hits hits{side, side, {}};
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const bool is_sky = y < 3;
      hits.hits.push_back({{0.1 * x, y < 5 ? 0.0 : 1e9 * (x + side * y), is_sky ? infinite : 1.0 * y},
                           is_sky ? Vector{0, 0, -1} : Vector{0, 1, 0},
                           Shape::sphere});
    }
  Image image = make_image(side, side, 1);
  for (std::size_t i = 0; i < image.values.size(); ++i) image.values[i] = static_cast<float>(i % 7);
  const SpaceFilterSpec filter{.kernel = SpaceKernel::box, .size = 3, .edges = {"depth"}};
  const Image result = filtered(image, make_edge_weights(hits, filter, Border::clamp), Border::clamp);
  for (const float value : result.values) EXPECT_TRUE(std::isfinite(value));
  // Alone, as all around are far: the pixel itself is left.
  for (int y = 6; y + 1 < side; ++y)
    for (int x = 1; x + 1 < side; ++x) EXPECT_EQ(result.row(0, y)[x], image.row(0, y)[x]);
  // Beyond all distances: of one place along the ray only the pixels above and below, which have the same numbers.
  EXPECT_NEAR(result.row(0, 1)[4], (image.row(0, 0)[4] + image.row(0, 1)[4] + image.row(0, 2)[4]) / 3, 1e-6);
}

// Begun again, the sequence has nothing to do with what the average holds: its error jumps, which STBN's does not.
TEST(HardCases, AGoldenRatioThatBeginsAgainIsSeen) {
  Scene scene = scene_of(
      "[image]\nwidth = 32\nheight = 32\nframes = 100\nrepeats = 1\noutputs = [\"curves\"]\n[[noise]]\nkind = "
      "\"golden-ratio\"\n[effects.integrand]\n[filter.time]\nkernels = [\"ema\"]\n");
  Noise noise = mask(32, 32, 1, "golden-ratio");
  noise.spec = scene.noises[0];
  ThreadPool pool(1);
  const Result result = render(scene, {noise}, pool);
  const auto error = [&](int frame) { return std::sqrt(result.square(0, 0, 0, 1, frame)); };
  double before = 0;
  for (int frame = 40; frame < 64; ++frame) before = std::max(before, error(frame));
  double after = 0;
  for (int frame = 64; frame < 72; ++frame) after = std::max(after, error(frame));
  EXPECT_GT(after, 1.3 * before);
  scene.noises[0].slices = 1000;
  noise.spec = scene.noises[0];
  const Result goes_on = render(scene, {noise}, pool);
  for (int frame = 64; frame < 72; ++frame) EXPECT_LT(std::sqrt(goes_on.square(0, 0, 0, 1, frame)), 1.1 * before);
}

// Past its last slice a texture is read elsewhere: the mean is still that of all its values, so that nothing is biased,
// and the error falls on.
TEST(HardCases, AfterItsLastSliceATextureHasNoBias) {
  const Scene scene = scene_of(
      "[image]\nwidth = 24\nheight = 20\nframes = 512\nrepeats = 2\noutputs = [\"curves\"]\n[[noise]]\nkind = "
      "\"white\"\n[effects.integrand]\n[filter.time]\nkernels = [\"mc\"]\n");
  ThreadPool pool(2);
  const Result result = render(scene, {mask(8, 8, 8)}, pool);  // 64 rounds: every place once
  EXPECT_NEAR(result.rmse(0, 0, 1, 511).mean, 0, 1e-7);
  EXPECT_GT(result.rmse(0, 0, 1, 7).mean, result.rmse(0, 0, 1, 63).mean);
}

constexpr const char* all_effects =
    "[image]\nwidth = 36\nheight = 28\nframes = 64\nrepeats = 4\n[[noise]]\nkind = \"white\"\n[filter.time]\nkernels = "
    "[\"mc\"]\n[effects.integrand]\nfunction = \"gauss\"\n[effects.dither]\nbits = 2\n[effects.transparency]\nalpha = "
    "[0.3, 0.5, 0.7]\nstaggered = "
    "true\n[effects.free-flight]\n[effects.ray-march]\n[effects.ambient-occlusion]\nsamples "
    "= 2\n[effects.soft-shadow]\n[effects.sky]\n[effects.convolution]\nsize = "
    "9\n[effects.sparse]\n[volume]\nresolution "
    "= 17\n";

// Sigma over the root of n, in every effect: independent estimates have that, and only unbiased ones. Ten effects
// within five standard errors of their ratio: odds of a false alarm below 1e-5, and the seed is fixed.
TEST(HardCases, WhiteNoiseFallsAsTheRootOfTheFramesInEveryEffect) {
  const Result result = rendered(all_effects);
  ASSERT_EQ(result.effects.size(), 10U);
  for (std::size_t effect = 0; effect < result.effects.size(); ++effect) {
    std::vector<double> ratios;
    for (int repeat = 0; repeat < result.repeats; ++repeat) {
      double square = 0;  // of one frame: the mean of all, as few samples may be most of it
      for (int frame = 0; frame < 64; ++frame) square += result.square(effect, 0, repeat, 0, frame) / 64;
      for (const int n : {4, 16, 64}) ratios.push_back(n * result.square(effect, 0, repeat, 1, n - 1) / square);
    }
    const MeanAndError ratio = mean_and_error(ratios);
    EXPECT_NEAR(ratio.mean, 1, std::max(5 * ratio.error, 0.02)) << name_of(result.effects[effect]);
    EXPECT_LT(ratio.error, 0.05) << name_of(result.effects[effect]);
  }
}

// Student's test of the mean over the picture, whose pixels are independent: 10 effects at 5 deviations, odds of a
// false alarm below 1e-5 (Bonferroni).
TEST(HardCases, EveryEstimateHasTheMeanThatIsItsTruth) {
  const Result result = rendered(all_effects);
  for (std::size_t effect = 0; effect < result.effects.size(); ++effect) {
    const ResultPicture& mean = result.pictures[2 * effect + 1];
    std::vector<double> errors;
    for (std::size_t i = 0; i < mean.values.size() / static_cast<std::size_t>(mean.channels); ++i)
      errors.push_back(static_cast<double>(mean.values[i] - result.truths[2 * effect + 1].values[i]));
    const MeanAndError error = mean_and_error(errors);
    EXPECT_LT(std::fabs(error.mean), 5 * error.error) << name_of(result.effects[effect]);
  }
}

}  // namespace
}  // namespace noiseloom::render
