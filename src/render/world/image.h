// A picture in memory, and filters over it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "noiseloom/core/parallel.h"
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

// Does something for all rows of a picture, a few at a time: in the calling thread, or on the threads of a pool where
// there is one. No row depends on another, so that the picture is the same.
struct Rows {
  ThreadPool* pool = nullptr;

  // body(first, last) for rows first <= y < last.
  template <class Body>
  void operator()(int height, const Body& body) const {
    constexpr int together = 16;
    if (pool == nullptr) return body(0, height);
    pool->for_each((height + together - 1) / together, [&](std::int64_t block, int) {
      const int first = static_cast<int>(block) * together;
      body(first, std::min(first + together, height));
    });
  }
};

// Where a place outside of 0..size-1 is read.
int inside(int place, int size, Border border);
// Taps along one axis, an odd number that adds up to 1: those of the filter.
std::vector<float> taps_of(const SpaceFilterSpec& filter);
// The image, filtered along x and then along y.
Image filtered(const Image& image, const std::vector<float>& taps, Border border, Rows rows = {});

}  // namespace noiseloom::render
