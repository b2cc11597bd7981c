// Histories of pixels: found again where things move, begun again where they cannot be.
#include <gtest/gtest.h>

#include <cmath>

#include "noiseloom/core/error.h"
#include "render/scene_support.h"
#include "render/surface.h"

namespace noiseloom::render {
namespace {

const std::string moving =
    "[image]\nwidth = 60\nheight = 48\nframes = 20\nrepeats = 6\n[[noise]]\nkind = "
    "\"white\"\n[effects.ambient-occlusion]\n"
    "[filter.time]\nkernels = [\"mc\"]\n";

TEST(Histories, WhatWasSeenIsFoundAgainExactly) {
  const MotionSpec motion{.on = true, .camera = {3, 1}, .sphere = {-2, 2}};
  const double pixel = 6.0 / 60;  // the view is 6 wide
  const auto hits_at = [&](int frame) { return make_hits(60, 48, frame * 5, frame * -1); };
  int found = 0;
  for (const int frame : {1, 4}) {
    const Hits now = hits_at(frame);
    const Hits before = hits_at(frame - 1);
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 60; ++x) {
        const Hit& hit = now.at(x, y);
        const Step step = step_of(motion, hit.shape);
        const int before_x = x - step.right;
        const int before_y = y - step.down;
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
      const double in_frame = static_cast<double>(result.pictures[0].values[i]) - 0.5;
      const double in_mean = static_cast<double>(result.pictures[1].values[i]) - 0.5;
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

TEST(Histories, MotionGoesWithSurfacesOnly) {
  EXPECT_THROW(scene_of("[[noise]]\nkind = \"white\"\n[effects.dither]\n[motion]\ncamera = [1, 0]\n"), UserError);
  EXPECT_THROW(scene_of(moving + "[motion]\ncamera = [1]\n"), UserError);
  EXPECT_THROW(
      scene_of(moving + "[[filter.space]]\nkernel = \"box\"\nedges = [\"depth\"]\n[motion]\ncamera = [1, 0]\n"),
      UserError);
}

}  // namespace
}  // namespace noiseloom::render
