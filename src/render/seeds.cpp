#include "render/seeds.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "render/a_trous.h"
#include "render/frames.h"
#include "render/job.h"
#include "render/scene_sizes.h"

namespace noiseloom::render {
namespace {

// Where the blocks of a frame begin: the R2 sequence [Roberts18].
int start_of_blocks(std::int64_t frame, double step, int block) {
  const double place = static_cast<double>(frame) * step;
  return std::min(block - 1, static_cast<int>((place - std::floor(place)) * block));
}

}  // namespace

std::vector<float> mask_of(const Job& job, const Noise& noise) {
  const Scene& scene = job.scene();
  const auto& noises = *job.shared.noises.get(Data::noises, job.pass);
  const auto target = std::find_if(noises.begin(), noises.end(),
                                   [&](const Noise& other) { return other.spec.name == noise.spec.target; });
  NoiseReader reader(*target, move_of_repeat(scene.seed, job.repeat), 1, scene.width);
  std::vector<float> mask;
  for (int y = 0; y < scene.height; ++y) {
    reader.read(y, job.frame);
    for (int x = 0; x < scene.width; ++x) mask.push_back(reader.at(x)(0));
  }
  return mask;
}

Seeds moved_seeds(const Seeds& seeds, const std::vector<float>& brightness, const std::vector<float>& mask, int width,
                  int height, int block, int left, int top) {
  Seeds moved = seeds;
  std::vector<std::size_t> pixels;
  std::vector<std::size_t> by_brightness;
  for (int first_y = -top; first_y < height; first_y += block)
    for (int first_x = -left; first_x < width; first_x += block) {
      pixels.clear();
      for (int y = std::max(0, first_y); y < std::min(height, first_y + block); ++y)
        for (int x = std::max(0, first_x); x < std::min(width, first_x + block); ++x)
          pixels.push_back(static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
      by_brightness = pixels;
      std::stable_sort(by_brightness.begin(), by_brightness.end(),
                       [&](std::size_t a, std::size_t b) { return brightness[a] < brightness[b]; });
      std::stable_sort(pixels.begin(), pixels.end(), [&](std::size_t a, std::size_t b) { return mask[a] < mask[b]; });
      for (std::size_t rank = 0; rank < pixels.size(); ++rank) moved[pixels[rank]] = seeds[by_brightness[rank]];
    }
  return moved;
}

bool has_seeds(const Scene& scene) {
  return std::any_of(scene.noises.begin(), scene.noises.end(),
                     [](const NoiseSpec& noise) { return noise.kind == NoiseKind::heitz_belcour; });
}

void move_seeds(Job& job) {
  const Noise& noise = job.noise_of_job();
  if (noise.spec.kind != NoiseKind::heitz_belcour) return;
  const Scene& scene = job.scene();
  if (!job.seeds.is_there()) {
    Seeds& seeds = job.seeds.make(Seeds(static_cast<std::size_t>(pixels_of(scene))));
    std::iota(seeds.begin(), seeds.end(), 0U);
    return;
  }
  // What is there yet is the picture of the frame before.
  const Image& before = job.estimate.get(Data::estimate, job.pass);
  Seeds& seeds = job.seeds.get(Data::seeds, job.pass);
  const int block = noise.spec.block;
  seeds = moved_seeds(seeds, brightness_of(before, job.channels()), mask_of(job, noise), scene.width, scene.height,
                      block, start_of_blocks(job.frame, 0.7548776662466927, block),
                      start_of_blocks(job.frame, 0.5698402909980532, block));
  count_of(*job.counts, Work::moved_seeds) += pixels_of(scene);
}

Counts work_of_seeds(const Scene& scene, std::span<const Noise> noises) {
  const auto with_seeds = std::count_if(noises.begin(), noises.end(),
                                        [](const Noise& noise) { return noise.spec.kind == NoiseKind::heitz_belcour; });
  Counts counts{};
  count_of(counts, Work::moved_seeds) =
      pixels_of(scene) * (num_rendered(scene) - 1) * with_seeds * scene.repeats * std::ssize(effects_of(scene));
  return counts;
}

}  // namespace noiseloom::render
