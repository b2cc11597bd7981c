// A picture in memory, and filters over it.
#pragma once

#include <cstddef>
#include <vector>

#include "noiseloom/render/scene.h"

namespace noiseloom::render {

// Planar: [channel][y][x].
struct Image {
  int width = 0;
  int height = 0;
  int channels = 0;
  std::vector<float> values;

  std::size_t pixels() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  const float* row(int channel, int y) const { return values.data() + offset(channel, y); }
  float* row(int channel, int y) { return values.data() + offset(channel, y); }

 private:
  std::size_t offset(int channel, int y) const {
    return (static_cast<std::size_t>(channel) * static_cast<std::size_t>(height) + static_cast<std::size_t>(y)) *
           static_cast<std::size_t>(width);
  }
};

Image make_image(int width, int height, int channels);

// Where a place outside of 0..size-1 is read.
int inside(int place, int size, Border border);
// Taps along one axis, an odd number that adds up to 1: those of the filter.
std::vector<float> taps_of(const SpaceFilterSpec& filter);
// The image, filtered along x and then along y.
Image filtered(const Image& image, const std::vector<float>& taps, Border border);

}  // namespace noiseloom::render
