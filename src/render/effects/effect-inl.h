// The loop over pixels, once for every effect (render/jobs/effects.h): what is not named in a scene is code that is not
// called.
#pragma once

#include <array>
#include <cmath>

#include "noiseloom/core/math.h"
#include "render/jobs/effects.h"
#include "render/jobs/job.h"

namespace noiseloom::render {

inline constexpr std::size_t most_channels = 3;

// What most effects do not do.
struct PlainEffect {
  int rays() const { return 0; }         // that a pixel traces in a frame
  int march_steps() const { return 0; }  // that it takes through the volume
};

template <class E>
void estimate_image(Job& job) {
  const Noise& noise = job.noise_of_job();
  const E effect(job.shared, job.repeat, &job);
  const Scene& scene = job.scene();
  const int channels = effect.channels();
  // The truth of the frame goes with it where each has one of its own (job.h).
  const bool with_truth = truth_changes_with_frame(scene, job.shared.effects[job.effect]);
  if (!job.estimate.is_there())
    job.estimate.make(make_image(scene.width, scene.height, with_truth ? 2 * channels : channels));
  Image& image = job.estimate.get(Data::estimate, job.pass);
  const Move move = move_of_repeat(scene.seed, job.repeat);
  const bool by_seeds = noise.spec.kind == NoiseKind::heitz_belcour;
  const Seeds* const seeds = by_seeds ? &job.seeds.get(Data::seeds, job.pass) : nullptr;
  job.rows(scene.height, [&](int first, int last) {
    NoiseReader reader(noise, move, effect.numbers(), scene.width, seeds, job.repeat);
    std::array<float, most_channels> values{};
    std::array<double, most_channels> means{};
    for (int y = first; y < last; ++y) {
      reader.read(y, job.frame);
      for (int x = 0; x < scene.width; ++x) {
        effect.estimate(x, y, reader.at(x), values.data());
        for (int c = 0; c < channels; ++c) image.row(c, y)[x] = values[static_cast<std::size_t>(c)];
        if (!with_truth) continue;
        effect.expect(x, y, means.data());
        for (int c = 0; c < channels; ++c)
          image.row(channels + c, y)[x] = static_cast<float>(means[static_cast<std::size_t>(c)]);
      }
    }
  });
  const auto pixels = static_cast<std::int64_t>(image.pixels());
  if (with_truth) count_of(*job.counts, Work::expectations) += pixels;
  count_of(*job.counts, work_of_rays(scene)) += pixels * effect.rays();
  count_of(*job.counts, Work::march_steps) += pixels * effect.march_steps();
  count_of(*job.counts, Work::estimates) += pixels;
  count_of(*job.counts, work_of_reading(noise)) += pixels * values_of_pixel(noise, effect.numbers());
}

template <class E>
Image truth_image(const Shared& shared, int repeat) {
  const E effect(shared, repeat, nullptr);
  Image image = make_image(shared.scene.width, shared.scene.height, effect.channels());
  shared.pool.for_each(image.height, [&](std::int64_t row, int) {
    const int y = static_cast<int>(row);
    std::array<double, most_channels> values{};
    for (int x = 0; x < image.width; ++x) {
      effect.expect(x, y, values.data());
      for (int c = 0; c < image.channels; ++c)
        image.row(c, y)[x] = static_cast<float>(values[static_cast<std::size_t>(c)]);
    }
  });
  return image;
}

}  // namespace noiseloom::render
