// What features make of a texture, by double loops.
#pragma once

#include <array>
#include <vector>

#include "anneal/texture_fixture.h"
#include "noiseloom/anneal/feature_map.h"

namespace noiseloom::test {

// The samples of the first slices.
inline std::vector<float> samples_of(const Texture& texture, int slices) {
  std::vector<float> list;
  for (const SliceIndex slice : first_indices<SliceIndex>(slices)) {
    const SliceField& field = texture.field(slice);
    std::vector<float> values(field.planar().size());
    field.interleaved(values);
    list.insert(list.end(), values.begin(), values.end());
  }
  return list;
}

inline double kernel_by_features(const FeatureMap& map, const std::vector<double>& a, const std::vector<double>& b) {
  const auto n = static_cast<std::size_t>(map.num_features());
  double sum = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) sum += a[i] * map.mixing()[i * n + j] * b[j];
  }
  return sum;
}

// dE by the taps of `slices`, by a double loop, with `kernel(a, b)` of samples; the term of the pair itself counts like
// any other. What lies around the pair is that of `around`, where it is given.
template <class Kernel>
double change_by(std::span<const SliceTaps> slices, const Extents& extents, const Texture& texture, SliceIndex slice,
                 CellPair pair, const Kernel& kernel, const Texture* around = nullptr) {
  const auto value = [](const Texture& of, SliceIndex s, Cell cell) {
    std::array<float, 8> sample{};
    of.field(s).get(cell, sample.data());
    return sample;
  };
  const auto a = value(texture, slice, pair.i);
  const auto b = value(texture, slice, pair.j);
  double sum = 0;
  for (const SliceTaps& taps : slices) {
    for (const PlaneTap& tap : taps.taps) {
      for (const auto& [centre, sign] : {std::pair{Cell{pair.i}, 1.0}, {Cell{pair.j}, -1.0}}) {
        const std::int64_t x = (centre % extents.width() + tap.dx + extents.width()) % extents.width();
        const std::int64_t y = (centre / extents.width() + tap.dy + extents.height()) % extents.height();
        const Texture& others = around != nullptr ? *around : texture;
        const auto s = value(others, extents.slice_at(slice, taps.offset), x + extents.width() * y);
        sum += sign * tap.weight * (kernel(b.data(), s.data()) - kernel(a.data(), s.data()));
      }
    }
  }
  return 2 * sum;
}

}  // namespace noiseloom::test
