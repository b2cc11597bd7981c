// The effects: what a pixel estimates from random numbers, and what that is on average.
//
// Each is a struct with the same members, which estimate_image() and truth_image() are templates over:
//   E(const Shared&, int repeat, const Job*)                the job is null where truth is asked for
//   int channels() const                                    of its picture
//   int numbers() const                                     that a pixel takes in a frame from that noise
//   void estimate(int x, int y, Draw draw, float* out)      one value for each channel
//   void expect(int x, int y, double* out)                  the exact mean over independent uniform numbers
#pragma once

#include <cstdint>
#include <span>

#include "noiseloom/render/noise.h"
#include "noiseloom/render/passes.h"
#include "noiseloom/render/scene.h"
#include "render/world/image.h"

namespace noiseloom::render {

struct Shared;
struct Job;

// What the rest of the program knows of an effect.
struct EffectCalls {
  Effect effect;
  int (*channels)(const Scene&);
  int (*numbers)(const Scene&, const Noise&);  // 0 where it cannot use the noise
  bool (*truth_changes_with_repeat)(const Scene&);
  void (*estimate)(Job&);
  Image (*truth)(const Shared&, int repeat);
  Image (*converged)(const Shared&) = nullptr;  // what finer steps tend to, where that is not the truth itself
  // What a pixel takes for both of these beside the expectation.
  Counts (*work_of_truth)(const Scene&) = nullptr;
};
const EffectCalls& calls_of(Effect effect);

// `numbers` where the noise holds numbers of 0 to 1, else 0.
int if_numbers(int numbers, const Noise& noise);
// Values that a pixel reads of the noise for so many numbers, and what such readings are counted as.
std::int64_t values_of_pixel(const Noise& noise, int numbers);
Work work_of_reading(const Noise& noise);
// What a ray of an effect is counted as.
Work work_of_rays(const Scene& scene);

// The picture that is dithered: values of 0 to 1.
Image test_picture(const DitherSpec& spec, int width, int height);
int channels_of(TestPicture picture);

}  // namespace noiseloom::render
