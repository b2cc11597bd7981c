// Histories of pixels: found again where things move, begun again where they cannot be.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "noiseloom/core/error.h"
#include "render/scene_support.h"
#include "render/world/surface.h"

namespace noiseloom::render {
namespace {

const std::string moving =
    "[image]\nwidth = 60\nheight = 48\nframes = 20\nrepeats = 6\n[[noise]]\nkind = "
    "\"white\"\n[effects.ambient-occlusion]\n"
    "[filter.time]\nkernels = [\"mc\"]\n";

TEST(Histories, WhatWasSeenIsFoundAgainExactly) {
  const MotionSpec motion{.on = true, .camera = {3, 1}, .sphere = {-2, 2}};
  const double pixel = 6.0 / 60;  // the view is 6 wide
  const auto hits_at = [&](int frame) { return make_hits(60, 48, frame * 5.0, frame * -1.0, {}); };
  int found = 0;
  for (const int frame : {1, 4}) {
    const Hits now = hits_at(frame);
    const Hits before = hits_at(frame - 1);
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 60; ++x) {
        const Hit& hit = now.at(x, y);
        const Step step = step_of(motion, hit.shape);
        const int before_x = x - static_cast<int>(step.right);
        const int before_y = y - static_cast<int>(step.down);
        if (before_x < 0 || before_x >= 60 || before_y < 0 || before_y >= 48) continue;
        const Hit& other = before.at(before_x, before_y);
        if (other.shape != hit.shape) continue;
        // Places are told from the sphere, which moves over the plane; a pixel down the screen is 1 / 0.6 of it there.
        const bool on_plane = hit.shape == Shape::plane;
        EXPECT_NEAR(hit.place.x - other.place.x, on_plane ? 2 * pixel : 0, 1e-12);
        EXPECT_NEAR(hit.place.z - other.place.z, on_plane ? 2 * pixel / 0.6 : 0, 1e-12);
        ++found;
      }
  }
  EXPECT_GT(found, 4500);
}

// The picture of what the camera sees for the first time is a frame's; what stays is averaged over all frames.
TEST(Histories, AMovingCameraLosesWhatEntersThePictureAlone) {
  const Result result = rendered(moving + "[motion]\ncamera = [1, 0]\n");
  double frame = 0;
  double mean = 0;
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 60; ++x) {
      const auto i = static_cast<std::size_t>(y * 60 + x);
      const auto error = [&](std::size_t stage) {
        return static_cast<double>(result.pictures[stage].values[i]) -
               static_cast<double>(result.truths[stage].values[i]);
      };
      const double in_frame = error(0);
      const double in_mean = error(1);
      if (x == 59) {
        EXPECT_EQ(in_frame, in_mean);
      }
      if (x >= 40) continue;
      frame += in_frame * in_frame;
      mean += in_mean * in_mean;
    }
  EXPECT_NEAR(mean / frame * 20, 1, 0.2);
}

TEST(Histories, WithoutMotionOrRejectionTheyArePlainAverages) {
  Scene plain = scene_of(moving);
  plain.time.kernels = {"ema", "mc"};
  Scene hardly = plain;
  hardly.time.rejection = 1e-300;
  const Result a = rendered(plain);
  const Result b = rendered(hardly);
  for (std::size_t stage = 0; stage < 3; ++stage)
    for (int frame = 0; frame < 20; ++frame)
      EXPECT_NEAR(b.rmse(0, 0, stage, frame).mean, a.rmse(0, 0, stage, frame).mean, 1e-6);
}

TEST(Histories, OneThatIsAlwaysRejectedIsTheFrame) {
  Scene scene = scene_of(moving + "rejection = 1\n[motion]\ncamera = [1, 2]\nsphere = [1, 0]\n");
  scene.time.kernels = {"ema", "mc"};
  const Result result = rendered(scene);
  for (const std::size_t stage : {1U, 2U})
    for (int frame = 0; frame < 20; ++frame)
      EXPECT_EQ(result.square(0, 0, 1, stage, frame), result.square(0, 0, 1, 0, frame));
}

// [FAST24]: with the chance b of rejection the variance of the average tends to sum_m b (1 - b)^(m-1) v_m, where v_m is
// that of a history of m frames.
TEST(Histories, RejectionLeavesWhatTheFormulaOfTheFilterSays) {
  Scene scene = scene_of(
      "[image]\nwidth = 64\nheight = 64\nframes = 60\nrepeats = 4\noutputs = []\n[[noise]]\nkind = \"white\"\n"
      "[effects.integrand]\n[filter.time]\nkernels = [\"ema\"]\nrejection = 0.2\n");
  double expected = 0;
  double weight = 0.2;
  for (int m = 0; m < 200; ++m, weight *= 0.8) {
    const double kept = std::pow(0.81, m);
    expected += weight * (0.1 / 1.9 * (1 - kept) + kept);
  }
  const Result result = rendered(scene);
  EXPECT_NEAR(result.rmse(0, 0, 1, 59).mean * result.rmse(0, 0, 1, 59).mean * 12 / expected, 1, 0.03);
}

TEST(Histories, WhatLeavesThePictureByItsWholeWidthIsNew) {
  const Result result = rendered(moving + "[motion]\ncamera = [60, 0]\n");
  for (int frame = 0; frame < 20; ++frame)
    EXPECT_EQ(result.square(0, 0, 0, 1, frame), result.square(0, 0, 0, 0, frame));
}

// The plane behind a moving sphere has no history where it comes into view.
TEST(Histories, ASphereThatMovesHidesAndShows) {
  const Result slow = rendered(moving + "[motion]\nsphere = [1, 0]\n");
  const Result fast = rendered(moving + "[motion]\nsphere = [3, 0]\n");
  const Result still = rendered(moving);
  EXPECT_LT(still.rmse(0, 0, 1, 5).mean, slow.rmse(0, 0, 1, 5).mean);
  EXPECT_LT(slow.rmse(0, 0, 1, 5).mean, fast.rmse(0, 0, 1, 5).mean);
  EXPECT_LT(fast.rmse(0, 0, 1, 5).mean, 0.7 * fast.rmse(0, 0, 0, 5).mean);
}

// A mean of two frames of white noise, of which the first is read between pixels with the weights w: the variance is
// that of one times (1 + sum w^2) / 4.
TEST(Histories, WhatIsReadBetweenPixelsHasTheVarianceOfItsWeights) {
  constexpr double cubic = 2.0 * (9.0 * 9 + 1) / (16 * 16);
  const std::pair<const char*, double> readings[] = {{"bilinear", 0.5}, {"catmull-rom", cubic}};
  for (const auto& [resampling, squares] : readings) {
    const Result result = rendered(
        "[image]\nwidth = 160\nheight = 90\nframes = 2\nrepeats = 4\n[[noise]]\nkind = "
        "\"white\"\n[effects.ambient-occlusion]\n[filter.time]\nkernels = [\"mc\"]\n"
        "resampling = \"" +
        std::string(resampling) + "\"\n[motion]\ncamera = [0.5, 0]\n");
    const double ratio = result.rmse(0, 0, 1, 1).mean / result.rmse(0, 0, 0, 1).mean;
    EXPECT_NEAR(ratio * ratio / ((1 + squares) / 4), 1, 0.04) << resampling;
  }
}

TEST(Histories, AClampKeepsThemWithinTheirNeighbours) {
  const auto scene = [](const std::string& clamp, const std::string& function) {
    return scene_of(
        "[image]\nwidth = 30\nheight = 20\nframes = 5\nrepeats = 1\n[[noise]]\nkind = \"white\"\n"
        "[effects.integrand]\nfunction = \"" +
        function + "\"\n[filter.time]\nkernels = [\"ema\"]\nclamp = " + clamp + "\n");
  };
  for (const char* const clamp : {"\"min-max\"", "\"variance\""})
    for (const double square : rendered(scene(clamp, "constant")).squares) EXPECT_NEAR(square, 0, 1e-12);
  // The mean of the neighbours alone is left of a history that may not stray from it.
  const Result tight = rendered(scene("\"variance\"\ngamma = 0", "identity"));
  const Result bounded = rendered(scene("\"min-max\"", "identity"));
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 30; ++x) {
      const auto frame_at = [&](int dx, int dy) {
        const int from_x = std::clamp(x + dx, 0, 29);
        const int from_y = std::clamp(y + dy, 0, 19);
        return tight.pictures[0].values[static_cast<std::size_t>(from_y * 30 + from_x)];
      };
      float sum = 0;
      float least = 1;
      float most = 0;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          sum += frame_at(dx, dy);
          least = std::min(least, frame_at(dx, dy));
          most = std::max(most, frame_at(dx, dy));
        }
      const auto i = static_cast<std::size_t>(y * 30 + x);
      EXPECT_NEAR(tight.pictures[1].values[i], 0.1F * frame_at(0, 0) + 0.9F * sum / 9, 1e-5);
      EXPECT_GE(bounded.pictures[1].values[i], least - 1e-6F);
      EXPECT_LE(bounded.pictures[1].values[i], most + 1e-6F);
    }
}

// The exact mean of what moves goes through the same average: where nothing is clamped, noise alone is left.
TEST(Histories, AnAverageOfWhatMovesIsMeasuredAgainstTheSameAverageOfItsMeans) {
  Scene scene = scene_of(moving + "[motion]\nsphere = [2.5, 0.25]\n");
  scene.frames = 16;
  Scene clamped = scene;
  clamped.time.clamp = Clamp::variance;
  const double plain = rendered(scene).rmse(0, 0, 1, 15).mean;
  const double frame = rendered(scene).rmse(0, 0, 0, 15).mean;
  EXPECT_LT(plain, 0.6 * frame);
  EXPECT_GT(rendered(clamped).rmse(0, 0, 1, 15).mean, plain);
}

TEST(Histories, MotionGoesWithSurfacesOnly) {
  EXPECT_THROW(scene_of("[[noise]]\nkind = \"white\"\n[effects.dither]\n[motion]\ncamera = [1, 0]\n"), UserError);
  EXPECT_THROW(scene_of(moving + "[motion]\ncamera = [1]\n"), UserError);
  EXPECT_THROW(
      scene_of(moving + "[[filter.space]]\nkernel = \"box\"\nedges = [\"depth\"]\n[motion]\ncamera = [1, 0]\n"),
      UserError);
}

}  // namespace
}  // namespace noiseloom::render
