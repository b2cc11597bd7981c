#include "construct/lattice_oracle.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace noiseloom::oracle {

std::vector<std::uint32_t> places_of_slice(const Lattice& lattice, const Extents& extents, SliceIndex slice) {
  std::vector<std::uint32_t> places = lattice_places(lattice, extents, 1);
  const std::size_t ahead = places_ahead(lattice, extents, slice);
  for (std::uint32_t& place : places) place = static_cast<std::uint32_t>((place + ahead) % places.size());
  return places;
}

double relative_error(const Extents& extents, const FilterSpec& filter, const Lattice& lattice) {
  const Footprint overlap(extents, filter);
  const std::int64_t width = extents.width();
  const std::int64_t height = extents.height();
  std::vector<std::vector<std::uint32_t>> places;
  for (const SliceIndex slice : first_indices<SliceIndex>(extents.num_slices())) {
    places.push_back(places_of_slice(lattice, extents, slice));
  }
  const auto cells = static_cast<double>(extents.cells_per_slice());
  const double mean = 1.0 / 3;  // of the distance of two uniform samples
  double sum = mean * overlap.weight_zero();
  for (const SliceTaps& taps : overlap.slices()) {
    for (const PlaneTap& tap : taps.taps) {
      double distance = 0;
      for (const SliceIndex slice : first_indices<SliceIndex>(extents.num_slices())) {
        const auto& here = places[static_cast<std::size_t>(slice)];
        const auto& there = places[static_cast<std::size_t>(extents.slice_at(slice, taps.offset))];
        for (std::int64_t y = 0; y < height; ++y) {
          for (std::int64_t x = 0; x < width; ++x) {
            const std::int64_t other = (y + tap.dy + height) % height * width + (x + tap.dx + width) % width;
            distance += std::abs(static_cast<double>(here[static_cast<std::size_t>(y * width + x)]) -
                                 static_cast<double>(there[static_cast<std::size_t>(other)]));
          }
        }
      }
      sum += tap.weight * (mean - distance / cells / cells / extents.num_slices());
    }
  }
  return sum / (mean * overlap.weight_zero());
}

std::vector<std::uint32_t> places_by_phase(const Lattice& lattice, const Extents& extents, std::int64_t shift_x,
                                           std::int64_t shift_y) {
  const std::int64_t width = extents.width();
  const std::int64_t height = extents.height();
  const auto cells = static_cast<std::size_t>(width * height);
  const auto phase = [&](const std::vector<std::int64_t>& cycles, std::int64_t x, std::int64_t y) {
    return (cycles[0] * height * x + cycles[1] * width * y) % (width * height);
  };
  std::vector<std::size_t> order(cells);
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, {}, [&](std::size_t cell) {
    const std::int64_t x = static_cast<std::int64_t>(cell) % width + shift_x;
    const std::int64_t y = static_cast<std::int64_t>(cell) / width + shift_y;
    return std::pair(phase(lattice.cycles, x, y), phase(lattice.between, x, y));
  });
  std::vector<std::uint32_t> places(cells);
  for (std::uint32_t i = 0; i < cells; ++i) places[order[i]] = i;
  return places;
}

}  // namespace noiseloom::oracle
