#include "anneal/texture_fixture.h"

#include <algorithm>
#include <cmath>

namespace noiseloom::test {

std::vector<Space> all_spaces() {
  return {{"scalar", DistanceKind::absolute, 1},      {"circle", DistanceKind::circle, 1},
          {"vector1", DistanceKind::euclidean, 1},    {"vector2", DistanceKind::euclidean, 2},
          {"vector3", DistanceKind::euclidean, 3},    {"vector4", DistanceKind::euclidean, 4},
          {"vector5", DistanceKind::euclidean, 5},    {"vector8", DistanceKind::euclidean, 8},
          {"direction2", DistanceKind::angle, 2},     {"sphere", DistanceKind::angle, 3},
          {"direction4", DistanceKind::angle, 4},     {"axis", DistanceKind::axis, 3},
          {"rotation", DistanceKind::axis, 4},        {"manhattan2", DistanceKind::manhattan, 2},
          {"manhattan7", DistanceKind::manhattan, 7}, {"chebyshev2", DistanceKind::chebyshev, 2},
          {"chebyshev3", DistanceKind::chebyshev, 3}, {"cosine2", DistanceKind::cosine, 2},
          {"cosine3", DistanceKind::cosine, 3}};
}

ValueKernel kernel_of(const Space& space, ValueKernelKind kind, int num_axes) {
  return {kind, space.distance, space.channels, static_cast<double>(space.channels) / num_axes, 1 / 0.49};
}

double oracle_kernel(const ValueKernel& kernel, const float* a, const float* b) {
  double dot = 0;
  double square = 0;
  double to_opposite = 0;
  double sum = 0;
  double largest = 0;
  for (int c = 0; c < kernel.channels; ++c) {
    dot += double{a[c]} * double{b[c]};
    square += (double{a[c]} - double{b[c]}) * (double{a[c]} - double{b[c]});
    to_opposite += (double{a[c]} + double{b[c]}) * (double{a[c]} + double{b[c]});
    sum += std::abs(double{a[c]} - double{b[c]});
    largest = std::max(largest, std::abs(double{a[c]} - double{b[c]}));
  }
  double d = std::sqrt(square);
  if (kernel.distance == DistanceKind::circle) d = std::min(d, 1 - d);
  if (kernel.distance == DistanceKind::axis) d *= std::sqrt(to_opposite) / 2;
  if (kernel.distance == DistanceKind::angle) d = std::acos(std::clamp(dot, -1.0, 1.0));
  if (kernel.distance == DistanceKind::cosine) d = square / 2;  // 1 - dot, but for lengths rounded to float
  if (kernel.distance == DistanceKind::manhattan) d = sum;
  if (kernel.distance == DistanceKind::chebyshev) d = largest;
  return kernel.kind == ValueKernelKind::distance ? -d
                                                  : std::exp(-std::pow(d, kernel.exponent) * kernel.inverse_sigma_s2);
}

Texture::Texture(const Footprint& footprint, const ValueKernel& kernel, unsigned seed)
    : footprint_(footprint), kernel_(kernel), engine_(seed) {
  const Extents& extents = footprint.extents();
  const auto channels = static_cast<std::size_t>(kernel.channels);
  const Permutation in_order = identity_permutation(extents.cells_per_slice());
  for (std::int32_t slice = 0; slice < extents.num_slices(); ++slice) {
    std::vector<float> list(in_order.size() * channels);
    for (std::size_t k = 0; k < in_order.size(); ++k) draw(&list[k * channels]);
    fields_.emplace_back(FieldLayout(footprint, kernel.channels));
    fields_.back().fill(in_order, list);
  }
}

void Texture::draw(float* sample) {
  std::normal_distribution<float> normal;
  double length = 0;
  for (int c = 0; c < kernel_.channels; ++c) {
    sample[c] = normal(engine_);
    length += double{sample[c]} * double{sample[c]};
  }
  for (int c = 0; c < kernel_.channels; ++c) {
    sample[c] = is_between_unit_vectors(kernel_.distance) ? static_cast<float>(double{sample[c]} / std::sqrt(length))
                                                          : std::uniform_real_distribution<float>(0, 1)(engine_);
  }
}

double Texture::between(SliceIndex slice, Cell cell, SliceIndex other_slice, Cell other) const {
  float a[8];
  float b[8];
  field(slice).get(cell, a);
  field(other_slice).get(other, b);
  return oracle_kernel(kernel_, a, b);
}

template <class Visit>
void Texture::for_taps(SliceIndex slice, Cell cell, const Visit& visit) const {
  const Extents& extents = footprint_.extents();
  const std::int64_t width = extents.width();
  const std::int64_t height = extents.height();
  for (const SliceTaps& taps : footprint_.slices()) {
    const SliceIndex other = extents.slice_at(slice, taps.offset);
    for (const PlaneTap& tap : taps.taps) {
      const std::int64_t x = (cell % width + tap.dx + width) % width;
      const std::int64_t y = (cell / width + tap.dy + height) % height;
      visit(tap.weight, other, x + width * y);
    }
  }
}

double Texture::energy() const {
  double sum = 0;
  for (const SliceIndex slice : footprint_.extents().slices()) {
    for (Cell cell = 0; cell < footprint_.extents().cells_per_slice(); ++cell) {
      for_taps(slice, cell, [&](double weight, SliceIndex other, Cell other_cell) {
        sum += weight * between(slice, cell, other, other_cell);
      });
    }
  }
  return sum;
}

double Texture::magnitude(SliceIndex slice, Cell i, Cell j) const {
  double sum = 0;
  for (const Cell centre : {i, j}) {
    for_taps(slice, centre, [&](double weight, SliceIndex other, Cell cell) {
      for (const Cell from : {i, j}) sum += std::abs(weight * between(slice, from, other, cell));
    });
  }
  return 2 * sum;
}

}  // namespace noiseloom::test
