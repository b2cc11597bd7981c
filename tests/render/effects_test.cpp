// Estimates are unbiased, and errors follow their closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "render/scene_support.h"

namespace noiseloom::render {
namespace {

// The mean of a one-frame picture over all moves of a mask is the mean over its list of values: so with as many
// repeats as the mask has values, each pixel has seen each value. Here the picture is as large as the mask instead,
// and constant, which is the same sum.
double mean_over_mask(const std::string& effect, double& truth) {
  Scene scene =
      scene_of("[image]\nwidth = 64\nheight = 64\nframes = 1\nrepeats = 1\n[[noise]]\nkind = \"blue-2d\"\n" + effect);
  ThreadPool pool(2);
  const Result result = render(scene, {mask(64, 64, 1)}, pool);
  const auto mean = [](const std::vector<float>& values) {
    double sum = 0;
    for (const float value : values) sum += static_cast<double>(value);
    return sum / static_cast<double>(values.size());
  };
  truth = mean(result.truths[0].values);
  return mean(result.pictures[0].values);
}

TEST(Effects, IntegrandsAreTheirMeansOverAllValues) {
  for (const char* const function : {"constant", "identity", "step", "sine"}) {
    double truth = 0;
    const double found = mean_over_mask(std::string("[effects.integrand]\nfunction = \"") + function + "\"\n", truth);
    EXPECT_NEAR(found, truth, 1e-6) << function;
  }
}

TEST(Effects, TwoNumbersGiveTheirClosedForms) {
  for (const char* const function : {"circle", "gauss"}) {
    const Scene scene = scene_of(
        std::string("[image]\nframes = 64\nrepeats = 4\nwidth = 64\nheight = 64\n[[noise]]\nkind = \"sobol-owen\"\n"
                    "[filter.time]\nkernels = [\"mc\"]\n[effects.integrand]\nfunction = \"") +
        function + "\"\n");
    const Result result = rendered(scene);
    double sum = 0;
    const ResultPicture& picture = result.pictures[1];  // mc
    for (const float value : picture.values) sum += static_cast<double>(value);
    const double truth = static_cast<double>(result.truths[0].values[0]);
    const double spread = result.rmse(0, 0, 1, 63).mean / std::sqrt(64 * 64);
    EXPECT_NEAR(sum / (64 * 64), truth, 5 * spread) << function;
  }
}

// Panes, exactly: over all pairs of values of two numbers, by a texture that holds every pair.
TEST(Effects, PanesAreCompositedOneOverTheOther) {
  constexpr int n = 20;  // opacities are multiples of 1/20
  Texture texture = make_texture(Extents({n, n, 1}), 2);
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      texture.values[static_cast<std::size_t>(y * n + x)] = static_cast<float>((x + 0.5) / n);
      texture.values[static_cast<std::size_t>(n * n + y * n + x)] = static_cast<float>((y + 0.5) / n);
    }
  Noise noise{.spec = {.kind = NoiseKind::file, .name = "pairs"},
              .texture = std::make_shared<const Texture>(std::move(texture)),
              .channels = 2};
  noise.samples.space = "vector2";
  for (const char* const alpha : {"[0.5, 0.5]", "[0.1, 0.9]", "[0.0, 0.35]", "[1.0, 0.5]", "[0.05, 1.0]"}) {
    Scene scene = scene_of(std::string("[image]\nwidth = 1\nheight = 1\nframes = 1\nrepeats = 1\n[[noise]]\nkind = "
                                       "\"white\"\n[effects.transparency]\nalpha = ") +
                           alpha + "\n");
    ThreadPool pool(1);
    std::array<double, 3> mean{};
    Result result;
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        Texture moved = make_texture(Extents({1, 1, 1}), 2);
        moved.values = {noise.texture->values[static_cast<std::size_t>(y * n + x)],
                        noise.texture->values[static_cast<std::size_t>(n * n + y * n + x)]};
        Noise one = noise;
        one.texture = std::make_shared<const Texture>(std::move(moved));
        result = render(scene, {one}, pool);
        for (std::size_t c = 0; c < 3; ++c) mean[c] += static_cast<double>(result.pictures[0].values[c]) / (n * n);
      }
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(mean[c], static_cast<double>(result.truths[0].values[c]), 1e-6) << alpha;
  }
}

const std::string of_one_number =
    "[image]\nwidth = 6\nheight = 4\nrepeats = 1\noutputs = [\"images\"]\n[[noise]]\nkind = \"white\"\n[filter.time]\n"
    "kernels = [\"mc\"]\n[effects.integrand]\nfunction = \"sine\"\n[effects.dither]\npicture = \"ramp\"\n"
    "[effects.transparency]\nalpha = [0.3]\n[effects.free-flight]\n[effects.ray-march]\nsteps = 1\n[effects.sparse]\n"
    "[volume]\nresolution = 9\n";

Noise noise_of(Texture texture) {
  return {.spec = {.kind = NoiseKind::file, .name = "values"},
          .texture = std::make_shared<const Texture>(std::move(texture))};
}

// Every pixel of a picture that is averaged over all places of a mask is the mean over the list of its values.
TEST(Effects, OverAllShiftsEveryEffectHasTheMeanOverAllValues) {
  constexpr int n = 64;
  Scene scene = scene_of(of_one_number);
  ThreadPool pool(1);
  Texture list = make_texture(Extents({1, 1, n}), 1);
  for (int i = 0; i < n; ++i) list.values[static_cast<std::size_t>(i)] = (static_cast<float>(i) + 0.5F) / n;
  scene.frames = n;
  const Result means = render(scene, {noise_of(list)}, pool);
  scene.frames = 4;
  const std::size_t num_effects = means.effects.size();
  EXPECT_EQ(num_effects, 6U);
  std::vector<std::vector<double>> sums(num_effects);
  for (int shift = 0; shift < 16; ++shift) {
    Texture moved = make_texture(Extents({4, 4, 4}), 1);
    for (int i = 0; i < n; ++i) {
      const int x = (i + shift) % 4;
      const int y = (i / 4 + shift / 4) % 4;
      moved.values[static_cast<std::size_t>(i / 16 * 16 + y * 4 + x)] =
          list.values[static_cast<std::size_t>(i * 37 % n)];
    }
    const Result result = render(scene, {noise_of(moved)}, pool);
    for (std::size_t effect = 0; effect < num_effects; ++effect) {
      const std::vector<float>& values = result.pictures[2 * effect + 1].values;  // mc
      sums[effect].resize(values.size());
      for (std::size_t i = 0; i < values.size(); ++i) sums[effect][i] += static_cast<double>(values[i]) / 16;
    }
  }
  for (std::size_t effect = 0; effect < num_effects; ++effect)
    for (std::size_t i = 0; i < sums[effect].size(); ++i)
      EXPECT_NEAR(sums[effect][i], static_cast<double>(means.pictures[2 * effect + 1].values[i]), 1e-6)
          << name_of(means.effects[effect]);
}

// And that list, the finer the closer, has the mean that truth is.
TEST(Effects, TheMeanOverFineValuesIsTheTruth) {
  constexpr int n = 4096;
  Scene scene = scene_of(of_one_number);
  scene.frames = n;
  ThreadPool pool(2);
  Texture list = make_texture(Extents({1, 1, n}), 1);
  for (int i = 0; i < n; ++i) list.values[static_cast<std::size_t>(i)] = (static_cast<float>(i) + 0.5F) / n;
  const Result result = render(scene, {noise_of(list)}, pool);
  const auto is_smooth = [](Effect effect) { return effect == Effect::integrand || effect == Effect::ray_march; };
  for (std::size_t effect = 0; effect < result.effects.size(); ++effect)
    for (std::size_t i = 0; i < result.truths[2 * effect].values.size(); ++i)
      EXPECT_NEAR(result.pictures[2 * effect + 1].values[i], result.truths[2 * effect].values[i],
                  is_smooth(result.effects[effect]) ? 5e-6F : 0.5F / n)
          << name_of(result.effects[effect]) << " " << i;
}

TEST(Effects, AMeanOfManyFramesLosesNothing) {
  Scene scene = scene_of(
      "[image]\nwidth = 1\nheight = 1\nframes = 50000\nrepeats = 1\noutputs = [\"images\"]\n[[noise]]\nkind = "
      "\"white\"\n[filter.time]\nkernels = [\"mc\"]\n[effects.integrand]\n");
  Texture texture = make_texture(Extents({1, 1, 5}), 1);
  texture.values = {0.99F, 0.01F, 0.5F, 0.33F, 0.17F};
  ThreadPool pool(1);
  const Result result = render(scene, {noise_of(texture)}, pool);
  EXPECT_NEAR(result.pictures[1].values[0], 0.4F, 6e-8F);
}

// Two panes that are asked with the same number are there together or not at all: that is said.
TEST(Effects, ValuesOfOnePixelThatAreTheSameAreTold) {
  const Scene scene = scene_of(
      "[image]\nframes = 4096\nrepeats = 1\nwidth = 1\nheight = 1\noutputs = [\"images\"]\n[[noise]]\nkind = "
      "\"white\"\n[filter.time]\nkernels = [\"mc\"]\n[effects.transparency]\nalpha = [0.5, 0.5]\n");
  Texture texture = make_texture(Extents({1, 1, 4096}), 1);
  for (std::size_t i = 0; i < 4096; ++i) texture.values[i] = (static_cast<float>(i) + 0.5F) / 4096;
  Noise noise = noise_of(std::move(texture));
  ThreadPool pool(1);
  const Result result = render(scene, {noise}, pool);
  const ResultPicture& behind = result.truths[0];
  // Half of the time the front pane, which is red, and never the other: as if its opacity were 0.
  const float red = 0.9F;
  EXPECT_GT(std::fabs(result.pictures[1].values[0] - behind.values[0]), 0.05F);
  EXPECT_NEAR(result.pictures[1].values[0], 0.5F * red + 0.5F * (0.25F + 0.75F * 0.5F), 1e-3F);
  const auto notes = notes_of_reading(scene, {noise});
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_NE(notes[0].find("of the 2 values that transparency reads"), std::string::npos) << notes[0];
  noise.spec.values_from = ValuesFrom::slices;
  EXPECT_TRUE(notes_of_reading(scene, {noise}).empty());
  noise.notes = {"was damaged"};  // what is known from opening it is known of the result
  EXPECT_EQ(notes_of_reading(scene, {noise}),
            std::vector<std::string>{"noise \"" + noise.spec.name + "\": was damaged"});
  EXPECT_TRUE(notes_of_reading(scene, {mask(4, 4, 1)}).empty());
}

TEST(Effects, OpacitiesOfNothingAndAllAreExact) {
  for (const char* const alpha : {"[0]", "[1]", "[0, 0, 1, 0.5]"}) {
    const Result result = rendered(std::string("[image]\nframes = 3\n[[noise]]\nkind = \"white\"\n[[noise]]\nkind = "
                                               "\"ign\"\n[effects.transparency]\nalpha = ") +
                                   alpha + "\n");
    for (const double square : result.squares) EXPECT_EQ(square, 0) << alpha;
  }
}

TEST(Effects, ALevelStaysWhateverTheNumber) {
  for (const int bits : {1, 2, 8, 16}) {
    Scene scene = scene_of(
        "[image]\nframes = 4\nheight = 50\n[[noise]]\nkind = \"white\"\n[effects.dither]\n"
        "picture = \"flats\"\n");
    scene.dither.bits = bits;
    const Result result = rendered(scene);
    const ResultPicture& picture = result.pictures[0];
    for (int y = 20; y < 30; ++y)  // the patches that are on levels
      for (int x = 0; x < picture.width; ++x) {
        const auto i = static_cast<std::size_t>(y * picture.width + x);
        EXPECT_EQ(picture.values[i], result.truths[0].values[i]) << bits;
      }
    EXPECT_GT(result.rmse(0, 0, 0, 3).mean, 0);
  }
}

TEST(Effects, DitheringIsItsPictureOnAverage) {
  for (const char* const picture : {"ramp", "dark-ramp", "flats", "colours", "zone-plate"}) {
    const Result result = rendered(
        std::string("[image]\nwidth = 40\nheight = 40\nframes = 400\nrepeats = 1\n[[noise]]\nkind = \"white\"\n"
                    "[filter.time]\nkernels = [\"mc\"]\n[effects.dither]\nbits = 2\npicture = \"") +
        picture + "\"\n");
    // The error of the mean of 400 frames is a twentieth of that of one. Both are estimates: of flats, few pixels make
    // most of the error of one frame.
    EXPECT_NEAR(result.rmse(0, 0, 1, 399).mean / result.rmse(0, 0, 0, 399).mean, 0.05, 0.006) << picture;
  }
}

TEST(Effects, WhiteNoiseAveragesAsIndependentNumbersDo) {
  const Result result = rendered(
      "[image]\nwidth = 128\nheight = 128\nframes = 64\nrepeats = 6\n[[noise]]\nkind = \"white\"\n[effects.integrand]\n"
      "function = \"identity\"\n[filter.time]\nkernels = [\"ema\", \"mc\"]\n");
  const double variance = 1.0 / 12;
  for (const int frame : {0, 1, 3, 31, 63}) {
    const double kept = std::pow(0.9, 2.0 * frame);
    const double ema = variance * (0.1 / 1.9 * (1 - kept) + kept);
    const double mc = variance / (frame + 1);
    for (const auto& [stage, expected] : {std::pair(1, ema), std::pair(2, mc)}) {
      std::vector<double> squares;
      for (int repeat = 0; repeat < 6; ++repeat)
        squares.push_back(result.square(0, 0, repeat, static_cast<std::size_t>(stage), frame));
      const MeanAndError found = mean_and_error(squares);
      EXPECT_NEAR(found.mean, expected, std::max(4 * found.error, 0.005 * expected)) << stage << " " << frame;
    }
  }
}

TEST(Effects, AverageOfOneFrameIsTheFrame) {
  Scene scene = scene_of(
      "[image]\nframes = 7\n[[noise]]\nkind = \"ign\"\n[effects.integrand]\n[filter.time]\nkernels = "
      "[\"ema\", \"mc\"]\nalpha = 1.0\n");
  const Result result = rendered(scene);
  for (int frame = 0; frame < 7; ++frame) EXPECT_EQ(result.square(0, 0, 0, 1, frame), result.square(0, 0, 0, 0, frame));
  EXPECT_EQ(result.square(0, 0, 0, 2, 0), result.square(0, 0, 0, 0, 0));
  scene.time.alpha = 1e-9;
  scene.time.start = EmaStart::cumulative;
  const Result mean = rendered(scene);
  EXPECT_NEAR(mean.square(0, 0, 0, 1, 6) / mean.square(0, 0, 0, 2, 6), 1, 1e-4);
}

TEST(Effects, SamplesThatAreNoNumbersAreRefused) {
  const Scene scene = scene_of("[[noise]]\nkind = \"white\"\n[effects.dither]\n");
  ThreadPool pool(1);
  Noise noise = mask(4, 4, 1);
  EXPECT_NO_THROW(render(scene, {noise}, pool));
  // A tent, a list and the density of an image are numbers, but no uniform ones: their estimates have another mean.
  for (const char* space : {"sphere", "tent", "gauss2", "disk", "file", "image"}) {
    noise.samples.space = space;
    EXPECT_THROW(render(scene, {noise}, pool), UserError) << space;
  }
}

}  // namespace
}  // namespace noiseloom::render
