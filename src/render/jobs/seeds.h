// Seeds of pixels that are moved so that the noise of the next frame follows a mask [Heitz19].
//
// Each pixel has a seed, which gives its random numbers. Behind a frame, pixels of a block are put in order by how
// bright they came out, and by the mask of the next frame: the seed of the n-th darkest moves to the pixel of the n-th
// lowest value. Where the picture is smooth, the errors of the next frame are then as the mask is. Blocks lie elsewhere
// in every frame, so that seeds travel. Each seed stays in the picture once. Where the mask of the next frame is
// another, seeds can be carried to it (retarget.h).
#pragma once

#include <cstdint>
#include <vector>

#include "noiseloom/render/noise.h"
#include "noiseloom/render/passes.h"
#include "render/world/image.h"

namespace noiseloom::render {

using Seeds = std::vector<std::uint32_t>;  // [pixel]

// `brightness`, `mask`: of each pixel. Blocks of `block` by `block` pixels, one of which begins at (-left, -top), 0 <=
// left, top < block; at the borders they are cut. Of equals the earlier pixel comes first.
Seeds moved_seeds(const Seeds& seeds, const std::vector<float>& brightness, const std::vector<float>& mask, int width,
                  int height, int block, int left, int top);

// The noise of the scene that the seeds of another follow.
const Noise& target_of(std::span<const Noise> noises, const NoiseSpec& spec);

// Of a frame of a job: the first number of the texture that the seeds of the noise follow, pixel by pixel.
std::vector<float> mask_of(const Job& job, const Noise& noise, std::int64_t frame);

bool has_seeds(const Scene& scene);
// Before a frame: every seed at its place in the first, else moved by the picture of the frame before.
void move_seeds(Job& job);
Counts work_of_seeds(const Scene& scene, std::span<const Noise> noises);

}  // namespace noiseloom::render
