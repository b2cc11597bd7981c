// What a picture is blurred with: the mass of each pixel of a kernel, and pixels drawn with the chance of their mass.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "noiseloom/render/noise.h"
#include "noiseloom/render/scene.h"
#include "render/world/image.h"

namespace noiseloom::render {

struct Texel {
  int x = 0;
  int y = 0;
};

// Masses of a grid, which add up to 1.
class MassTable {
 public:
  MassTable() = default;
  // `masses`: [y][x], finite, none below 0, not all 0.
  MassTable(int width, int height, const std::vector<double>& masses);

  int width() const { return width_; }
  int height() const { return height_; }
  double mass(Texel texel) const;
  // The texel whose place in the distribution is 0 <= u, v < 1: v over rows, u over the texels of one. Never empty.
  Texel at(double u, double v) const;

 private:
  int width_ = 0;
  int height_ = 0;
  std::vector<double> rows_;   // mass up to the end of each row
  std::vector<double> cells_;  // [y][x]: mass of the row up to the end of each texel
};

// What estimates weigh that are drawn with other chances than the masses of a table: mass over chance, 1 on average.
struct Weights {
  double largest = 0;
  double above_clamp = 0;  // what a clamp at weight_clamp would take from the mean of 1
};
// What renderers keep the weights of samples below, so that few pixels are bright; nothing is clamped here.
inline constexpr double weight_clamp = 20;
// `chances`: [y][x], which add up to 1.
Weights weights_of(const MassTable& masses, const std::vector<double>& chances);
// A sentence about them.
std::string note_of_weights(const std::string& noise, const std::string& effect, const Weights& weights);

struct BlurMasses {
  MassTable masses;
  Image picture;  // that is blurred: lights before stripes, a torus
};

MassTable make_kernel(const ConvolutionSpec& spec);
Image picture_of_lights(int width, int height);

// The sample space whose points are those of the kernel; empty where it has none.
const char* space_of_kernel(BlurKernel kernel);
// The texel of a grid over the disk's square, [-1, 1]^2, or over [0, 1)^2.
Texel texel_of(double x, double y, bool of_disk, int width, int height);

}  // namespace noiseloom::render
