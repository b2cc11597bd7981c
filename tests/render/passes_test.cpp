// Only what a scene calls for is done, and as much of it as was predicted.
#include "noiseloom/render/passes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include "render/scene_support.h"

namespace noiseloom::render {
namespace {

constexpr const char* everything = R"(
[image]
width = 17
height = 9
frames = 4
repeats = 2
outputs = ["curves", "images", "predictions", "spectra"]
metrics = ["deviation", "ssim", "bands", "unseen", "quantiles", "pattern"]
[[noise]]
kind = "white"
[[noise]]
kind = "blue-2d"
[[noise]]
kind = "heitz-belcour"
target = "blue-2d"
retarget = 3
[effects.integrand]
function = "steps"
[effects.dither]
bits = 2
[effects.transparency]
alpha = [0.3, 0.5, 0.7]
staggered = true
[effects.free-flight]
[effects.ray-march]
[effects.ambient-occlusion]
samples = 2
[effects.soft-shadow]
[effects.sky]
turn = 5
[effects.convolution]
size = 5
[effects.sparse]
[volume]
resolution = 9
[filter.time]
kernels = ["ema", "mc"]
[[filter.space]]
kernel = "box"
size = 3
[[filter.space]]
kernel = "binomial"
edges = ["depth", "normal"]
[[filter.space]]
kernel = "a-trous"
levels = 2
edges = ["depth", "normal"]
)";

constexpr const char* in_motion = R"(
[image]
width = 40
height = 30
frames = 4
repeats = 2
[[noise]]
kind = "white"
[[noise]]
kind = "blue-2d"
[effects.ambient-occlusion]
[effects.soft-shadow]
[motion]
camera = [3, 1.5]
sphere = [-2, 0]
[filter.time]
kernels = ["ema", "mc"]
rejection = 0.1
clamp = "variance"
[[filter.space]]
kernel = "box"
size = 3
)";

const PassResult& pass_of(const Result& result, std::string_view name) {
  const auto found = std::find_if(result.passes.begin(), result.passes.end(),
                                  [&](const PassResult& one) { return one.planned.pass->name == name; });
  EXPECT_NE(found, result.passes.end());
  return *found;
}

void expect_as_planned(const Result& result) {
  for (const PassResult& one : result.passes) {
    EXPECT_EQ(one.calls, one.planned.calls) << one.planned.pass->name;
    EXPECT_EQ(one.counted, one.planned.work) << one.planned.pass->name;
    if (!one.planned.on) {
      EXPECT_EQ(one.calls, 0) << one.planned.pass->name;
      EXPECT_EQ(one.counted, Counts{}) << one.planned.pass->name;
      EXPECT_EQ(one.planned.bytes, 0);
      EXPECT_TRUE(one.planned.why.starts_with("off: ")) << one.planned.why;
    }
  }
}

TEST(Passes, ASceneWithEveryEffectDoesWhatItsPlanSays) {
  const Result result = rendered(everything);
  expect_as_planned(result);
  for (const PassResult& one : result.passes) {
    const std::string_view name = one.planned.pass->name;
    const bool is_of_motion = name == "moving hits" || name == "histories";
    const bool is_of_mesh = name == "mesh" || name == "mesh shares";  // mesh_test.cpp
    EXPECT_EQ(one.planned.on, !is_of_motion && !is_of_mesh) << name;
  }
  const std::int64_t pixels = 17 * 9 * 4 * 2;
  EXPECT_EQ(count_of(pass_of(result, "transparency").counted, Work::computed_values), pixels * 3 * 2);
  EXPECT_EQ(count_of(pass_of(result, "transparency").counted, Work::texture_values), pixels * 3);
  EXPECT_EQ(count_of(pass_of(result, "integrand").counted, Work::estimates), pixels * 3);
  EXPECT_EQ(count_of(pass_of(result, "filter over space").counted, Work::taps),
            pixels * 3 * 3 * (1 + 3 + 3 + 1 + 1 + 1 + 1 + 2 * 3 + 3 + 1) * (6 + 9));
  EXPECT_EQ(count_of(pass_of(result, "filter over space").counted, Work::guided_taps),
            pixels * 3 * 3 * 10 * 2 * (25 + 9));
}

TEST(Passes, WhatIsNotNamedIsOff) {
  Scene scene = scene_of(everything);
  scene.noises.pop_back();  // seeds are moved from frame to frame
  scene.metrics.pop_back();
  scene.dither.on = false;
  scene.time.kernels.clear();
  scene.outputs.clear();
  const Result result = rendered(scene);
  expect_as_planned(result);
  for (const char* const off : {"picture", "dither", "predictions", "filter over time", "pictures"})
    EXPECT_FALSE(pass_of(result, off).planned.on) << off;
  EXPECT_TRUE(result.pictures.empty());
  // Without curves and averages the last frame alone is worth anything.
  EXPECT_EQ(pass_of(result, "integrand").calls, 2 * 2);
}

TEST(Passes, AFrameThatAnExpectationAsksForIsRendered) {
  Scene scene = scene_of(everything);
  scene.noises.pop_back();  // seeds are moved from frame to frame
  scene.metrics.pop_back();
  scene.time.kernels.clear();
  scene.outputs.clear();
  scene.expects.push_back({.order = "white = white", .effect = "dither", .frame = 2});
  const Result result = rendered(scene);
  expect_as_planned(result);
  EXPECT_EQ(pass_of(result, "dither").calls, 2 * 2 * 2);
  EXPECT_GT(result.square(1, 0, 0, 0, 1), 0);
}

TEST(Passes, OneEffectLessLeavesTheOthersBytes) {
  const Result all = rendered(everything);
  Scene scene = scene_of(everything);
  scene.integrand.on = false;
  const Result less = rendered(scene);
  const auto others = static_cast<std::ptrdiff_t>(all.squares.size() / 10);
  EXPECT_TRUE(std::equal(less.squares.begin(), less.squares.end(), all.squares.begin() + others));
  const auto pictures = static_cast<std::ptrdiff_t>(all.pictures.size() / 10);
  for (std::size_t i = 0; i < less.pictures.size(); ++i)
    EXPECT_EQ(less.pictures[i].values, all.pictures[i + static_cast<std::size_t>(pictures)].values);
}

TEST(Passes, ThreadsDoNotChangeABit) {
  const Result one = rendered(everything, 1);
  // 60 jobs: on 7 threads the last 4 have their rows on all.
  for (const int threads : {2, 7}) {
    const Result several = rendered(everything, threads);
    EXPECT_EQ(several.squares, one.squares);
    EXPECT_EQ(several.further[1], one.further[1]);
    for (std::size_t i = 0; i < one.pictures.size(); ++i) EXPECT_EQ(several.pictures[i].values, one.pictures[i].values);
    EXPECT_EQ(results_csv(several), results_csv(one));
  }
}

TEST(Passes, EveryNeedOfThePictureIsNeeded) {
  const Scene scene = scene_of(everything);
  const std::vector<Noise> noises = noises_of(scene);
  ThreadPool pool(1);
  // A need that is taken from all passes leaves its maker off; whoever reads the data then says so.
  for (int data = 0; data < num_data; ++data) {
    std::vector<Pass> passes(all_passes().begin(), all_passes().end());
    bool changed = false;
    for (Pass& pass : passes)
      if (pass.needs.has(static_cast<Data>(data))) {
        pass.needs.flip(static_cast<Data>(data));
        changed = true;
      }
    const bool moves = static_cast<Data>(data) == Data::moving_hits;
    const bool is_of_mesh = static_cast<Data>(data) == Data::mesh || static_cast<Data>(data) == Data::shares;
    if (changed && !moves && !is_of_mesh) {
      EXPECT_THROW(render(scene, noises, pool, passes), std::logic_error) << name_of(static_cast<Data>(data));
    }
    if (moves) {
      const Scene moving = scene_of(in_motion);
      EXPECT_THROW(render(moving, noises_of(moving), pool, passes), std::logic_error);
    }
  }
}

TEST(Passes, WhatMovesDoesWhatItsPlanSays) {
  const Result result = rendered(in_motion);
  expect_as_planned(result);
  for (const char* const on : {"moving hits", "histories"}) EXPECT_TRUE(pass_of(result, on).planned.on) << on;
  for (const char* const off : {"primary hits", "filter over time"})
    EXPECT_FALSE(pass_of(result, off).planned.on) << off;
  EXPECT_EQ(rendered(in_motion, 5).squares, rendered(in_motion, 1).squares);
}

TEST(Passes, SecondsOfPassesAreThoseOfTheWall) {
  Scene scene = scene_of(everything);
  scene.width = 60;
  scene.height = 50;
  scene.repeats = 1;
  scene.outputs.clear();
  scene.metrics.clear();
  const Result result = rendered(scene, 1);
  double sum = 0;
  for (const PassResult& one : result.passes) sum += one.seconds;
  EXPECT_LE(sum, result.seconds);
  EXPECT_GT(sum, 0.8 * result.seconds);  // what is left is storing, and a busy machine
}

}  // namespace
}  // namespace noiseloom::render
