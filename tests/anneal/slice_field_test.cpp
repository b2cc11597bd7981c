#include "noiseloom/anneal/slice_field.h"

#include <gtest/gtest.h>

#include <numeric>

#include "anneal/texture_fixture.h"

namespace noiseloom {
namespace {

using namespace testing_support;

constexpr std::int64_t width = 13;
constexpr std::int64_t height = 7;

float value_at(std::int64_t x, std::int64_t y, int c) {
  return static_cast<float>(((x + width) % width) * 100 + ((y + height) % height) * 10 + c);
}

SliceField numbered_field() {
  const Footprint footprint(Extents({width, height}), product({group({0, 1}, box(4))}));
  SliceField field(FieldLayout(footprint, 2));
  Permutation order = identity_permutation(width * height);
  std::vector<float> list;
  std::reverse(order.begin(), order.end());
  for (Cell id = 0; id < width * height; ++id) {
    const Cell cell = width * height - 1 - id;
    for (int c = 0; c < 2; ++c) list.push_back(value_at(cell % width, cell / width, c));
  }
  field.fill(order, list);
  return field;
}

TEST(SliceField, BorderRepeatsTheTorus) {
  const SliceField field = numbered_field();
  const FieldLayout& layout = field.layout();
  EXPECT_EQ(layout.reach_x, 3);
  EXPECT_EQ(layout.reach_y, 3);
  for (int c = 0; c < 2; ++c) {
    for (std::int64_t y = -3; y < height + 3; ++y) {
      for (std::int64_t x = -3; x < width + 3; ++x) {
        EXPECT_EQ(field.plane(c)[(y + 3) * layout.stride + x + 3], value_at(x, y, c));
      }
    }
  }
}

TEST(SliceField, SwapMovesSamplesAndTheirImages) {
  const SliceField before = numbered_field();
  SliceField field = before;
  const Cell a = 0;              // a corner: three images
  const Cell b = width * 3 + 6;  // no image
  field.swap(a, b);
  float sample[2];
  field.get(a, sample);
  EXPECT_EQ(sample[1], value_at(6, 3, 1));
  EXPECT_EQ(field.plane(0)[(height + 3) * field.layout().stride + width + 3], value_at(6, 3, 0));
  field.swap(a, b);
  for (std::int64_t k = 0; k < field.layout().plane_size; ++k) EXPECT_EQ(field.plane(1)[k], before.plane(1)[k]);
}

TEST(SliceField, PlanarAndInterleavedHoldTheCells) {
  const SliceField field = numbered_field();
  const std::vector<float> planar = field.planar();
  std::vector<float> interleaved(planar.size());
  field.interleaved(interleaved);
  for (Cell cell = 0; cell < width * height; ++cell) {
    for (int c = 0; c < 2; ++c) {
      const float expected = value_at(cell % width, cell / width, c);
      EXPECT_EQ(planar[static_cast<std::size_t>(c * width * height + cell)], expected);
      EXPECT_EQ(interleaved[static_cast<std::size_t>(2 * cell + c)], expected);
    }
  }
}

}  // namespace
}  // namespace noiseloom
