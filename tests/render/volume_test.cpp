#include "render/world/volume.h"

#include <gtest/gtest.h>

#include <cmath>

#include "noiseloom/core/math.h"
#include "render/scene_support.h"

namespace noiseloom::render {
namespace {

const std::string in_volume =
    "[image]\nwidth = 24\nheight = 20\nframes = 300\nrepeats = 1\n[[noise]]\nkind = \"white\"\n[filter.time]\nkernels "
    "= "
    "[\"mc\"]\n[effects.free-flight]\n[effects.ray-march]\nsteps = 4\n";

TEST(Volume, ExponentialIsWhatItSays) {
  EXPECT_EQ(exp_minus(0), 1.0F);
  for (int i = 1; i < 8700; ++i) {
    const float x = 0.01F * static_cast<float>(i);
    const double exact = math::exp(-static_cast<double>(x));
    EXPECT_NEAR(static_cast<double>(exp_minus(x)) / exact, 1, 6e-7) << x;
  }
  EXPECT_EQ(exp_minus(1e4F), 0.0F);
  EXPECT_TRUE(std::isnan(exp_minus(std::nanf(""))));
}

TEST(Volume, ACloudHasPlacesOfAllDensitiesAndNoneOutside) {
  VolumeSpec spec;
  spec.extinction = 10;
  const Grid grid = make_density(spec);
  float largest = 0;
  int between = 0;
  for (const float value : grid.values) {
    EXPECT_GE(value, 0.0F);
    largest = std::max(largest, value);
    between += value > 1 && value < 9 ? 1 : 0;
  }
  EXPECT_EQ(largest, 10.0F);
  EXPECT_GT(between, static_cast<int>(grid.values.size()) / 100);
  EXPECT_EQ(grid.at(0, 0, 0), 0.0F);
  const Grid light = make_light(spec, grid);
  for (const float value : light.values) EXPECT_TRUE(value > 0 && value <= 0.9F);
}

// Light falls straight down through a slab: what a place at depth y scatters, and so the whole picture, is known.
TEST(Volume, ASlabIsLambertBeer) {
  for (const double extinction : {0.5, 3.0}) {
    Scene scene = scene_of(in_volume + "[volume]\ndensity = \"slab\"\n");
    scene.volume.extinction = extinction;
    scene.frames = 1;
    const Result result = rendered(scene);
    for (int y = 0; y < 20; ++y) {
      const double v = (y + 0.5) / 20;
      // The grid of a slab has two corners, between which light is linear.
      const auto light_at = [&](double depth) { return 0.9 * (0.25 + 0.75 * std::exp(-0.5 * extinction * depth)); };
      const double light = (1 - v) * light_at(0) + v * light_at(1);
      const double through = std::exp(-extinction);
      const double expected = (1 - through) * light + through * background(y, 20);
      for (std::size_t effect = 0; effect < 2; ++effect)
        EXPECT_NEAR(static_cast<double>(result.truths[effect].values[static_cast<std::size_t>(y * 24 + 3)]), expected,
                    2e-6);
    }
    // A march through what is the same everywhere has no error at all, up to rounding.
    EXPECT_LT(result.rmse(1, 0, 0, 0).mean, 1e-6);
    EXPECT_LT(result.bias[result.stages.size()], 1e-5);
  }
}

TEST(Volume, WhereThereIsNothingTheBackgroundIsSeenWhateverTheNumber) {
  Scene scene = scene_of(in_volume);
  scene.volume.extinction = 0;
  scene.frames = 3;
  const Result result = rendered(scene);
  for (const double square : result.squares) EXPECT_EQ(square, 0);
}

TEST(Volume, TheDensestCloudHasNoNans) {
  Scene scene = scene_of(in_volume);
  scene.frames = 3;
  for (const double extinction : {1e5, 1e4, 1e-20, 1e-40}) {
    scene.volume.extinction = extinction;
    for (const double square : rendered(scene).squares) EXPECT_TRUE(square >= 0 && square < 1) << extinction;
  }
}

// The error of the mean of 300 frames is 1 / sqrt(300) of that of one; a bias would stay.
TEST(Volume, EstimatesAreUnbiased) {
  const Result result = rendered(scene_of(in_volume));
  for (std::size_t effect = 0; effect < 2; ++effect)
    EXPECT_NEAR(result.rmse(effect, 0, 1, 299).mean / result.rmse(effect, 0, 0, 299).mean, 1 / std::sqrt(300), 0.012)
        << effect;
}

TEST(Volume, MoreStepsHaveLessBias) {
  Scene scene = scene_of(in_volume);
  scene.frames = 1;
  double before = 1;
  for (const int steps : {1, 4, 64}) {
    scene.ray_march.steps = steps;
    const Result result = rendered(scene);
    const double bias = result.bias[result.stages.size()];
    EXPECT_LT(bias, 0.5 * before);
    before = bias;
  }
}

}  // namespace
}  // namespace noiseloom::render
