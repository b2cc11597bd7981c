// Seeds that are carried along when the mask that errors follow becomes another [Heitz19].
//
// Seeds that are sorted within blocks have the pattern of the mask, better so in every frame, as long as the mask is
// the same. Where the next frame has another, what was won is lost, unless the seeds move with the values: a
// permutation takes the mask of a frame to nearly that of the next, each pixel coming from no further away than a few
// pixels, and is found once by exchanges. Where the picture is smooth, seeds bring their errors with them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "noiseloom/render/noise.h"
#include "noiseloom/render/passes.h"

namespace noiseloom::render {

struct Shared;

// Of the cells of a mask that tiles the plane: from which cell each one's value comes, relative to it.
struct Carrying {
  int width = 0;
  int height = 0;
  struct Step {
    std::int8_t dx = 0;
    std::int8_t dy = 0;
  };
  std::vector<Step> steps;  // [y][x]

  // The same for pixels of a picture, whose pixel (0, 0) lies at the cell (left, top): from which pixel each comes. A
  // permutation: those that would come from outside take, in order, those that would leave.
  std::vector<std::size_t> sources(int picture_width, int picture_height, std::int64_t left, std::int64_t top) const;
};

// From the mask `from` to nearly `to`, each [y][x]. Pixels move by at most `radius` along each axis, 0 <= radius <= 16.
Carrying carrying_between(const std::vector<float>& from, const std::vector<float>& to, int width, int height,
                          int radius);

// Those of all frames and repeats, for each noise of the scene: empty where its seeds are not carried.
struct CarryingOfFrames {
  std::vector<std::vector<Carrying>> of_noise;
  std::vector<std::vector<std::size_t>> which;  // [noise][repeat * frames + frame - 1]: to that frame
};
void make_carrying(Shared& shared);
// "" where some noise has seeds that are carried.
std::string off_without_carrying(const Scene& scene);
Counts work_of_carrying(const Scene& scene, std::span<const Noise> noises);
std::int64_t bytes_of_carrying(const Scene& scene, std::span<const Noise> noises);

}  // namespace noiseloom::render
