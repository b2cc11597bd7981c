// The effects: what a pixel estimates from random numbers, and what that is on average.
//
// Each is a struct with the same members, which estimate_image() and truth_image() are templates over:
//   E(const Shared&, int repeat)
//   int channels() const                                    of its picture
//   int numbers() const                                     that a pixel takes in a frame
//   void estimate(int x, int y, Draw draw, float* out)      one value for each channel
//   void expect(int x, int y, double* out)                  the exact mean over independent uniform numbers
#pragma once

#include <span>

#include "noiseloom/render/noise.h"
#include "noiseloom/render/scene.h"
#include "render/image.h"

namespace noiseloom::render {

struct Shared;
struct Job;

// What the rest of the program knows of an effect.
struct EffectCalls {
  Effect effect;
  int (*channels)(const Scene&);
  int (*numbers)(const Scene&);
  bool (*truth_changes_with_repeat)(const Scene&);
  void (*estimate)(Job&);
  Image (*truth)(const Shared&, int repeat);
};
const EffectCalls& calls_of(Effect effect);

// The picture that is dithered: values of 0 to 1.
Image test_picture(const DitherSpec& spec, int width, int height);
int channels_of(TestPicture picture);

}  // namespace noiseloom::render
