// What a mesh lets through of the sky and of the sun, pixel by pixel: no closed form says, so that it is the mean over
// many directions, the same for all noises.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "noiseloom/render/noise.h"
#include "noiseloom/render/passes.h"
#include "noiseloom/render/scene.h"
#include "render/world/image.h"

namespace noiseloom::render {

class Mesh;
struct Job;
struct Shared;

// Of every pixel that any frame shows. Where something moves, it is the view that moves over the mesh, by whole pixels.
struct Shares {
  // Pixels left of what the first frame shows, and above.
  int left = 0;
  int top = 0;
  Image of_sky;  // without pixels where nobody asks for it
  Image of_sun;
};

struct SharesInFrame {
  const Shares* shares = nullptr;  // null: there is no mesh
  int right = 0;                   // how far the view has moved, and from the first pixel of the shares
  int down = 0;

  double of_sky(int x, int y) const { return at(shares->of_sky, x, y); }
  double of_sun(int x, int y) const { return at(shares->of_sun, x, y); }

 private:
  double at(const Image& image, int x, int y) const { return static_cast<double>(image.row(0, y + down)[x + right]); }
};

// Null where the scene has none.
const Mesh* mesh_of(const Shared& shared, std::string_view reader);
SharesInFrame shares_in(const Shared& shared, const Job* job, std::string_view effect);

std::string off_without_mesh(const Scene& scene);
std::string off_without_shares(const Scene& scene);
void load_mesh(Shared& shared);
void find_shares(Shared& shared);
Counts work_of_shares(const Scene& scene, std::span<const Noise> noises);
std::int64_t bytes_of_mesh(const Scene& scene, std::span<const Noise> noises);
std::int64_t bytes_of_shares(const Scene& scene, std::span<const Noise> noises);

}  // namespace noiseloom::render
