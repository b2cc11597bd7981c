#include "render/jobs/seeds.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <utility>

#include "render/jobs/retarget.h"
#include "render/measures/pattern.h"
#include "render/scene_support.h"

namespace noiseloom::render {
namespace {

std::vector<float> scattered_values(std::size_t count, std::size_t step) {
  std::vector<float> values;
  for (std::size_t i = 0; i < count; ++i) values.push_back(static_cast<float>(i * step % 97));
  return values;
}

TEST(Seeds, AllStayAndFollowTheMaskWithinTheirBlocks) {
  constexpr int width = 13;
  constexpr int height = 9;
  Seeds seeds(width * height);
  std::iota(seeds.begin(), seeds.end(), 0U);
  const auto brightness = scattered_values(seeds.size(), 31);
  const auto mask = scattered_values(seeds.size(), 17);
  const Seeds moved = moved_seeds(seeds, brightness, mask, width, height, 4, 3, 1);
  Seeds sorted = moved;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(sorted, seeds);
  const auto block_of = [](std::size_t pixel) {
    return (static_cast<int>(pixel) / width + 1) / 4 * 10 + (static_cast<int>(pixel) % width + 3) / 4;
  };
  for (std::size_t a = 0; a < moved.size(); ++a) {
    EXPECT_EQ(block_of(a), block_of(moved[a]));
    for (std::size_t b = 0; b < moved.size(); ++b) {
      if (block_of(a) != block_of(b) || !(mask[a] < mask[b])) continue;
      EXPECT_LE(brightness[moved[a]], brightness[moved[b]]);
    }
  }
}

TEST(Seeds, EqualsKeepTheirOrder) {
  Seeds seeds(16);
  std::iota(seeds.begin(), seeds.end(), 0U);
  EXPECT_EQ(moved_seeds(seeds, std::vector<float>(16), std::vector<float>(16), 4, 4, 4, 0, 0), seeds);
}

// White in the first frame; where the picture is smooth, as the mask from the second on.
TEST(Seeds, ErrorsBecomeThoseOfTheMask) {
  const Scene scene = scene_of(
      "[image]\nwidth = 64\nheight = 64\nframes = 3\nrepeats = 2\n[[noise]]\nkind = \"white\"\n[[noise]]\nkind = "
      "\"blue-2d\"\n[[noise]]\nkind = \"heitz-belcour\"\ntarget = \"blue-2d\"\n[effects.integrand]\n[[filter.space]]\n"
      "kernel = \"binomial\"\n");
  std::vector<Noise> noises = noises_of(scene);
  Texture checkers = make_texture(Extents({2, 2, 1}), 1);
  checkers.values = {0.1F, 0.7F, 0.9F, 0.3F};
  noises[1].extents = checkers.extents;
  noises[1].texture = std::make_shared<const Texture>(std::move(checkers));
  ThreadPool pool(2);
  const Result result = render(scene, noises, pool);
  EXPECT_NEAR(result.rmse(0, 2, 1, 0).mean / result.rmse(0, 0, 1, 0).mean, 1, 0.05);
  EXPECT_LT(result.rmse(0, 2, 1, 1).mean, 0.8 * result.rmse(0, 0, 1, 1).mean);
  EXPECT_NEAR(result.rmse(0, 2, 0, 2).mean / result.rmse(0, 2, 0, 0).mean, 1, 1e-6);
}

// Blocks lie elsewhere in every frame, so that seeds come ever nearer to where a mask that stays wants them.
TEST(Seeds, UnderAMaskThatStaysFramesGetBetter) {
  const Scene scene = scene_of(
      "[image]\nwidth = 64\nheight = 64\nframes = 12\nrepeats = 4\nmetrics = [\"pattern\"]\n[[noise]]\nkind = "
      "\"blue-2d\"\n[[noise]]\nkind = \"heitz-belcour\"\ntarget = \"blue-2d\"\n[effects.integrand]\n");
  std::vector<Noise> noises = noises_of(scene);
  const Noise one = mask(13, 11, 1, "blue-2d");
  Texture same = make_texture(Extents({13, 11, 12}), 1);
  for (const SliceIndex s : same.extents.slices())
    std::copy(one.texture->values.begin(), one.texture->values.end(), same.slice(s));
  noises[0].extents = same.extents;
  noises[0].texture = std::make_shared<const Texture>(std::move(same));
  ThreadPool pool(1);
  const Result result = render(scene, noises, pool);
  const auto apart = [&](int frame) { return result.value(Metric::pattern, 0, 1, 0, frame).mean; };
  double before = 1.5;
  for (const int frame : {0, 1, 2, 4, 11}) {
    EXPECT_LT(apart(frame), before) << frame;
    before = apart(frame);
  }
  EXPECT_LT(apart(11), 0.7 * apart(1));
}

TEST(Seeds, AreCarriedFromAMaskToNearlyTheNext) {
  constexpr int width = 24;
  constexpr int height = 20;
  constexpr int radius = 3;
  const auto from = scattered_values(width * height, 17);
  const auto to = scattered_values(width * height, 31);
  const Carrying carrying = carrying_between(from, to, width, height, radius);
  const std::vector<std::size_t> sources = carrying.sources(width, height, 0, 0);
  double before = 0;
  double after = 0;
  std::size_t across_the_edge = 0;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    EXPECT_LE(std::abs(carrying.steps[i].dx), radius);
    EXPECT_LE(std::abs(carrying.steps[i].dy), radius);
    before += std::abs(static_cast<double>(from[i]) - static_cast<double>(to[i]));
    after += std::abs(static_cast<double>(from[sources[i]]) - static_cast<double>(to[i]));
    const int x = static_cast<int>(i % width) + carrying.steps[i].dx;
    const int y = static_cast<int>(i / width) + carrying.steps[i].dy;
    if (x < 0 || x >= width || y < 0 || y >= height) {
      ++across_the_edge;
    } else {
      EXPECT_EQ(sources[i], static_cast<std::size_t>(y * width + x));
    }
  }
  EXPECT_GT(across_the_edge, 0U);
  EXPECT_LT(after, 0.5 * before);
  // Pictures of any size, wherever they lie on the mask, keep every seed.
  for (const auto& [picture_width, picture_height] : {std::pair{7, 5}, {61, 43}, {1, 1}}) {
    std::vector<std::size_t> all = carrying.sources(picture_width, picture_height, 1000003, 17);
    std::sort(all.begin(), all.end());
    for (std::size_t i = 0; i < all.size(); ++i) ASSERT_EQ(all[i], i);
  }
  for (const Carrying::Step& step : carrying_between(from, from, width, height, radius).steps)
    EXPECT_TRUE(step.dx == 0 && step.dy == 0);
}

// A mask of which neighbours differ much, the fractions of a plane that rises by the R2 sequence [Roberts18]; higher by
// a part of 1 in each of five slices.
Texture fractional_masks() {
  Texture texture = make_texture(Extents({32, 32, 5}), 1);
  for (const SliceIndex s : texture.extents.slices())
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 32; ++x) {
        const double height = 0.7548776662466927 * x + 0.5698402909980532 * y + 0.37 * s.value();
        texture.slice(s)[y * 32 + x] = static_cast<float>(height - std::floor(height));
      }
  return texture;
}

// Seeds that are not carried follow each slice anew, within blocks, and what the seeds of a block have in common stays
// in an average.
TEST(Seeds, ThatAreCarriedLeaveLessErrorThanWhatIsSortedAnewAndThanWhiteNoise) {
  const std::string text =
      "[image]\nwidth = 61\nheight = 64\nframes = 12\nrepeats = 8\n[[noise]]\nkind = \"white\"\n[[noise]]\nkind = "
      "\"blue-2d\"\n[[noise]]\nname = \"sorted\"\nkind = \"heitz-belcour\"\ntarget = \"blue-2d\"\n[[noise]]\nname = "
      "\"carried\"\nkind = \"heitz-belcour\"\ntarget = \"blue-2d\"\nretarget = 6\n[effects.integrand]\n"
      "[filter.time]\nkernels = [\"ema\"]\n[[filter.space]]\nkernel = \"gauss\"\n";
  const auto expectation = [](const char* order, const char* time, int frame) {
    return fmt::format("[[expect]]\norder = \"{}\"\ntime = \"{}\"\nspace = \"gauss1\"\nframe = {}\n", order, time,
                       frame);
  };
  const Scene scene =
      scene_of(text + expectation("carried < white", "frame", 12) + expectation("carried < white < sorted", "ema", 12) +
               expectation("carried = white", "frame", 1) + expectation("carried < sorted", "ema", 4));
  std::vector<Noise> noises = noises_of(scene);
  Texture slices = fractional_masks();
  noises[1].extents = slices.extents;
  noises[1].texture = std::make_shared<const Texture>(std::move(slices));
  ThreadPool pool(2);
  const Result result = render(scene, noises, pool);
  for (const ExpectationResult& one_of_all : check_expectations(scene, result))
    EXPECT_EQ(one_of_all.outcome, Outcome::holds) << one_of_all.text << ": " << one_of_all.found;
  for (const int threads : {1, 5}) {
    ThreadPool others(threads);
    EXPECT_EQ(render(scene, noises, others).squares, result.squares);
  }
}

TEST(Seeds, HowWellAnErrorFollowsAMaskIsMeasured) {
  const std::vector<float> mask = scattered_values(20 * 12, 17);
  Image image = make_image(20, 12, 1);
  for (std::size_t i = 0; i < mask.size(); ++i) image.values[i] = 0.25F * mask[i] * mask[i] - 3;
  EXPECT_NEAR(pattern_error(image, 1, mask), 0, 1e-12);
  for (float& value : image.values) value = -value;
  EXPECT_NEAR(pattern_error(image, 1, mask), 2, 1e-12);
  // A ramp that is steeper than the mask hides it, as a window has both; equal values are of one rank.
  image.values.assign(mask.size(), 0.5F);
  EXPECT_EQ(pattern_error(image, 1, mask), 1);
  for (std::size_t i = 0; i < mask.size(); ++i) image.values[i] = i % 2 == 0 ? 1.0F : 0.0F;
  const double of_chance = pattern_error(image, 1, scattered_values(mask.size(), 2 * 31));
  EXPECT_NEAR(of_chance, 1, 0.3);
}

TEST(Seeds, AStylisedPatternCanBeTheTarget) {
  const std::string base =
      "[image]\nwidth = 64\nheight = 64\nframes = 3\nrepeats = 2\nmetrics = [\"pattern\"]\n[[noise]]\nkind = "
      "\"white\"\n[effects.integrand]\n";
  EXPECT_ANY_THROW(scene_of(base));
  const Result result =
      rendered(base + "[[noise]]\nkind = \"blue-2d\"\n[[noise]]\nkind = \"heitz-belcour\"\ntarget = \"blue-2d\"\n");
  EXPECT_NEAR(result.value(Metric::pattern, 0, 0, 0, 2).mean, 1, 0.03);
  EXPECT_NEAR(result.value(Metric::pattern, 0, 2, 0, 0).mean, 1, 0.03);  // nothing is moved before the first frame
  EXPECT_LT(result.value(Metric::pattern, 0, 2, 0, 2).mean, 0.6);        // within blocks of 4, of windows of 8
  EXPECT_NEAR(result.value(Metric::pattern, 0, 1, 0, 2).mean, 0, 1e-6);  // the mask itself
}

TEST(Seeds, FollowATextureOfTheScene) {
  const std::string base = "[[noise]]\nkind = \"white\"\n[effects.integrand]\n[[noise]]\nkind = \"heitz-belcour\"\n";
  EXPECT_ANY_THROW(scene_of(base));
  EXPECT_ANY_THROW(scene_of(base + "target = \"white\"\n"));
  EXPECT_ANY_THROW(scene_of(base + "target = \"none\"\n"));
  EXPECT_NO_THROW(scene_of(base + "target = \"blue-2d\"\n[[noise]]\nkind = \"blue-2d\"\n"));
}

}  // namespace
}  // namespace noiseloom::render
