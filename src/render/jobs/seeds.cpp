#include "render/jobs/seeds.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "render/jobs/frames.h"
#include "render/jobs/job.h"
#include "render/jobs/scene_sizes.h"
#include "render/pictures/a_trous.h"

namespace noiseloom::render {
namespace {

// Where the blocks of a frame begin: the R2 sequence [Roberts18].
int start_of_blocks(std::int64_t frame, double step, int block) {
  const double place = static_cast<double>(frame) * step;
  return std::min(block - 1, static_cast<int>((place - std::floor(place)) * block));
}

// Each pixel takes the seed of the pixel from which, between the frame before and this one, the value of its mask
// comes.
Seeds carried_seeds(const Job& job, const Noise& noise, const Seeds& seeds) {
  const Scene& scene = job.scene();
  const CarryingOfFrames& carrying = job.shared.carrying.get(Data::carrying, job.pass);
  const std::size_t frame = static_cast<std::size_t>(job.repeat) * static_cast<std::size_t>(scene.frames) +
                            static_cast<std::size_t>(job.frame) - 1;
  const MaskPlace place = mask_place(target_of(*job.shared.noises.get(Data::noises, job.pass), noise.spec),
                                     move_of_repeat(scene.seed, job.repeat), job.frame - 1);
  const Carrying& step = carrying.of_noise[job.noise][carrying.which[job.noise][frame]];
  Seeds carried;
  for (const std::size_t source : step.sources(scene.width, scene.height, place.x, place.y))
    carried.push_back(seeds[source]);
  return carried;
}

}  // namespace

const Noise& target_of(std::span<const Noise> noises, const NoiseSpec& spec) {
  return *std::find_if(noises.begin(), noises.end(), [&](const Noise& one) { return one.spec.name == spec.target; });
}

std::vector<float> mask_of(const Job& job, const Noise& noise, std::int64_t frame) {
  const Scene& scene = job.scene();
  const Noise& target = target_of(*job.shared.noises.get(Data::noises, job.pass), noise.spec);
  NoiseReader reader(target, move_of_repeat(scene.seed, job.repeat), 1, scene.width);
  std::vector<float> mask;
  for (int y = 0; y < scene.height; ++y) {
    reader.read(y, frame);
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
  const bool is_carried = noise.spec.retarget > 0;
  const int block = noise.spec.block;
  // Seeds that are carried afterwards follow the mask of the frame that was rendered.
  seeds =
      moved_seeds(seeds, brightness_of(before, job.channels()), mask_of(job, noise, job.frame - (is_carried ? 1 : 0)),
                  scene.width, scene.height, block, start_of_blocks(job.frame, 0.7548776662466927, block),
                  start_of_blocks(job.frame, 0.5698402909980532, block));
  if (is_carried) seeds = carried_seeds(job, noise, seeds);
  count_of(*job.counts, Work::moved_seeds) += pixels_of(scene) * (is_carried ? 2 : 1);
}

Counts work_of_seeds(const Scene& scene, std::span<const Noise> noises) {
  std::int64_t moves = 0;
  for (const Noise& noise : noises)
    if (noise.spec.kind == NoiseKind::heitz_belcour) moves += noise.spec.retarget > 0 ? 2 : 1;
  Counts counts{};
  count_of(counts, Work::moved_seeds) =
      pixels_of(scene) * (num_rendered(scene) - 1) * moves * scene.repeats * std::ssize(effects_of(scene));
  return counts;
}

}  // namespace noiseloom::render
