// Averages over time of what moves, or is rejected at random. A pixel's history is that of the place that it shows:
// where that was seen a frame before, whole pixels away, on the same shape. Else, and where it is rejected, it begins
// again.
#include <algorithm>
#include <utility>

#include "noiseloom/core/random.h"
#include "render/filter_passes.h"
#include "render/scene_sizes.h"

namespace noiseloom::render {
namespace {

// The pixel that showed the same place a frame before, or -1.
std::ptrdiff_t place_before(const Job& job, int x, int y) {
  const Scene& scene = job.scene();
  const auto here = static_cast<std::ptrdiff_t>(y) * scene.width + x;
  if (job.frame == 0) return -1;
  if (!scene.motion.on) return here;
  const Shape shape = job.moving_hits.get(Data::moving_hits, job.pass).at(x, y).shape;
  const Step step = step_of(scene.motion, shape);
  const int before_x = x - step.right;
  const int before_y = y - step.down;
  if (before_x < 0 || before_y < 0 || before_x >= scene.width || before_y >= scene.height) return -1;
  if (job.hits_before.at(before_x, before_y).shape != shape) return -1;
  return static_cast<std::ptrdiff_t>(before_y) * scene.width + before_x;
}

bool is_rejected(const Job& job, std::size_t pixel) {
  const double chance = job.scene().time.rejection;
  if (chance <= 0) return false;
  const RandomBlock block = random_block(job.scene().seed, purpose_of_rejection, static_cast<std::uint32_t>(job.frame),
                                         static_cast<std::uint32_t>(job.repeat), pixel);
  return to_unit_double(block[0], block[1]) < chance;
}

}  // namespace

bool has_histories(const Scene& scene) { return scene.motion.on || scene.time.rejection > 0; }

void trace_moving_hits(Job& job) {
  const Scene& scene = job.scene();
  const MotionSpec& motion = scene.motion;
  if (job.moving_hits.is_there()) job.hits_before = std::move(job.moving_hits.get(Data::moving_hits, job.pass));
  const int frame = static_cast<int>(job.frame);
  job.moving_hits.make(make_hits(scene.width, scene.height, frame * (motion.camera[0] - motion.sphere[0]),
                                 frame * (motion.camera[1] - motion.sphere[1])));
  count_of(*job.counts, Work::primary_rays) += pixels_of(scene);
}

void average_histories(Job& job) {
  const Scene& scene = job.scene();
  const Image& now = job.estimate.get(Data::estimate, job.pass);
  const std::vector<std::string>& kernels = scene.time.kernels;
  const std::size_t pixels = now.pixels();
  Averages before;
  if (job.accumulated.is_there()) before = std::move(job.accumulated.get(Data::accumulated, job.pass));
  Averages& averages = job.accumulated.make();
  averages.images.assign(kernels.size(), make_image(now.width, now.height, now.channels));
  averages.lengths.resize(pixels);
  for (int y = 0; y < now.height; ++y)
    for (int x = 0; x < now.width; ++x) {
      const std::size_t here =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(now.width) + static_cast<std::size_t>(x);
      const std::ptrdiff_t found = is_rejected(job, here) ? -1 : place_before(job, x, y);
      const auto there = static_cast<std::size_t>(std::max<std::ptrdiff_t>(found, 0));
      const int length = found < 0 ? 1 : before.lengths[there] + 1;
      averages.lengths[here] = length;
      for (std::size_t k = 0; k < kernels.size(); ++k) {
        const double mean = 1.0 / length;
        const bool is_ema = kernels[k] == "ema";
        const double first = !is_ema || scene.time.start == EmaStart::cumulative ? mean : length == 1 ? 1 : 0;
        const float alpha = static_cast<float>(is_ema ? std::max(scene.time.alpha, first) : mean);
        for (std::size_t c = 0; c < static_cast<std::size_t>(now.channels); ++c) {
          const float value = now.values[c * pixels + here];
          averages.images[k].values[c * pixels + here] =
              found < 0 ? value : alpha * value + (1 - alpha) * before.images[k].values[c * pixels + there];
        }
      }
    }
  count_of(*job.counts, Work::averages) += std::ssize(now.values) * std::ssize(kernels);
  count_of(*job.counts, Work::history_reads) += static_cast<std::int64_t>(pixels);
}

Counts work_of_histories(const Scene& scene, std::span<const Noise> noises) {
  Counts counts = work_of_averages(scene, noises);
  count_of(counts, Work::history_reads) =
      pixels_of(scene) * std::ssize(effects_of(scene)) * scene.frames * scene.repeats * std::ssize(noises);
  return counts;
}

}  // namespace noiseloom::render
