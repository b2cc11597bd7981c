// What the score promises of random steps is what random steps leave.
#include "render/pictures/prediction.h"

#include <gtest/gtest.h>

#include <cmath>

#include "noiseloom/samples/sample_space.h"
#include "render/scene_support.h"

namespace noiseloom::render {
namespace {

// A dither array over the picture and a shift of it for every slice: blue in space and over time, after a fashion.
Noise ordered(int size, int slices) {
  Noise noise = mask(size, size, slices, "ordered");
  Texture texture = *noise.texture;
  for (int t = 0; t < slices; ++t)
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        const double value = 0.7548776662 * x + 0.5698402910 * y + 0.6180339887 * t;
        texture.slice(SliceIndex(t))[y * size + x] = static_cast<float>(value - std::floor(value));
      }
  noise.texture = std::make_shared<const Texture>(std::move(texture));
  return noise;
}

TEST(Prediction, IsTheErrorOfRandomSteps) {
  Scene scene = scene_of(
      "[image]\nwidth = 32\nheight = 32\nframes = 32\nrepeats = 64\noutputs = [\"predictions\"]\n[[noise]]\nkind = "
      "\"white\"\n[[noise]]\nkind = \"blue-2d\"\n[effects.integrand]\nfunction = \"steps\"\n[filter]\nborder = "
      "\"wrap\"\n"
      "[filter.time]\nkernels = [\"ema\", \"mc\"]\nalpha = 0.2\n[[filter.space]]\nkernel = \"box\"\nsize = 3\n"
      "[[filter.space]]\nkernel = \"binomial\"\n");
  ThreadPool pool(2);
  const Result result = render(scene, {open_noise(scene.noises[0], "", nullptr), ordered(32, 32)}, pool);
  EXPECT_EQ(result.prediction(0, 1), std::nullopt);
  for (std::size_t stage = 0; stage < result.stages.size(); ++stage) {
    ASSERT_TRUE(result.prediction(1, stage)) << stage;
    const double measured = result.over_white(0, 1, stage, 31);
    EXPECT_NEAR(*result.prediction(1, stage), measured, 0.01 + 0.05 * measured) << result.stages[stage].to_string();
  }
  EXPECT_LT(*result.prediction(1, 1), 0.6);
}

}  // namespace
}  // namespace noiseloom::render
