#include "support/slice_construction_oracle.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "noiseloom/core/decimal.h"
#include "noiseloom/core/math.h"
#include "noiseloom/core/random.h"
#include "noiseloom/problem/colour_classes.h"
#include "noiseloom/problem/footprint.h"
#include "support/oracle.h"

namespace noiseloom::oracle {
namespace {

// `weight` times what G of src/construct/stamp_kernel.h is for one overlap, added up. Shares of F(0) below 2^-12 are
// left out.
void add_sharpened(const Footprint& footprint, double sharpness, double weight, std::vector<double>& sum) {
  const std::vector<double> overlap = overlaps(footprint);
  const auto cells = static_cast<std::size_t>(footprint.extents().cells_per_slice());
  for (std::size_t plane = 0; plane < overlap.size(); plane += cells) {
    double largest = 0;
    for (std::size_t at = plane; at < plane + cells; ++at) largest = std::max(largest, std::abs(overlap[at]));
    for (std::size_t at = plane; at < plane + cells && largest > 0; ++at) {
      const double ratio = math::pow(std::abs(overlap[at]) / largest, sharpness);
      const double sharp = std::copysign(largest * ratio, overlap[at]);
      if (at == 0 || std::abs(sharp) >= std::ldexp(std::abs(overlap[0]), -12)) sum[at] += weight * sharp;
    }
  }
}

}  // namespace

FullKernel full_kernel(const Extents& extents, const FilterSpec& filter, double sharpness, int energy_bits) {
  std::vector<double> sum(static_cast<std::size_t>(extents.num_cells()));
  if (filter.combine == Combine::product) {
    add_sharpened(Footprint(extents, filter), sharpness, 1, sum);
  } else {
    for (const GroupSpec& group : filter.groups) {
      const double weight = group.weight > 0 ? group.weight : 1.0 / static_cast<double>(filter.groups.size());
      add_sharpened(Footprint(extents, {Combine::product, {group}}), sharpness, weight, sum);
    }
  }
  FullKernel kernel;
  for (kernel.scale_log2 = 30;; --kernel.scale_log2) {
    kernel.weights.assign(sum.size(), 0);
    kernel.bias = kernel.magnitude = 0;
    for (std::size_t at = 1; at < sum.size(); ++at) {
      const double scale = std::ldexp(1.0, kernel.scale_log2) / sum[0];
      const auto weight = static_cast<std::int64_t>(std::floor(sum[at] * scale + 0.5));
      kernel.weights[at] = weight;
      kernel.magnitude += std::abs(weight);
      kernel.bias -= std::min<std::int64_t>(weight, 0);
    }
    if (kernel.magnitude < (std::int64_t{1} << energy_bits)) return kernel;
  }
}

SliceConstructionOracle::SliceConstructionOracle(const Extents& extents, const FilterSpec& filter, SampleScale scale,
                                                 const ConstructSpec& spec, std::uint64_t seed,
                                                 std::int64_t points_per_visit)
    : extents_(extents),
      circular_(scale == SampleScale::circle),
      kernel_(full_kernel(extents, filter, spec.sharpness, circular_ ? 30 : 31)),
      classes_(colour_classes(Footprint(extents, filter))),
      hash_(seed),
      cells_(static_cast<std::size_t>(extents.cells_per_slice())),
      points_(points_per_visit) {
  list_taps();
  const auto num_slices = static_cast<std::size_t>(extents.num_slices());
  progress_.phase = circular_ ? ConstructPhase::spread : ConstructPhase::relax;
  progress_.num_start_points =
      circular_ ? extents.cells_per_slice() / 2 : decimal_of(spec.density).floor_of_times(extents.cells_per_slice());
  places_.assign(num_slices, std::vector<std::uint32_t>(cells_, pixel_is_off));
  on_.assign(num_slices, std::vector<bool>(cells_, false));
  energy_.assign(num_slices, std::vector<std::int64_t>(cells_, kernel_.bias));
  for (std::size_t slice = 0; slice < num_slices && !circular_; ++slice) draw_start(seed, slice);
  end_phases();
}

void SliceConstructionOracle::advance() {
  const std::int64_t picks = picks_of_visit();
  std::int64_t swaps = 0;
  for (const std::vector<SliceIndex>& moving : classes_) {
    std::vector<Flip> flips;
    for (const SliceIndex slice : moving) swaps += visit(static_cast<std::size_t>(slice), picks, flips);
    for (const Flip& flip : flips) tell_others(flip);
  }
  ++progress_.rounds;
  if (progress_.phase == ConstructPhase::relax) {
    progress_.num_swaps += swaps;
    const std::int64_t most_swaps = circular_ ? progress_.num_start_points / 4 : 4 * progress_.num_start_points;
    if (swaps == 0 || progress_.rounds == most_swaps / points_ + 1) end_relaxing();
  } else if (progress_.phase == ConstructPhase::exchange) {
    progress_.num_placed = std::min<std::int64_t>(progress_.num_placed + 2 * picks, std::ssize(places_[0]));
  } else if (progress_.phase != ConstructPhase::spread) {
    progress_.num_placed += picks;
  }
  end_phases();
}

std::int64_t SliceConstructionOracle::energy_of(const Places& places, std::uint32_t is_on) const {
  std::int64_t energy = 0;
  for (std::size_t from = 0; from < places.size(); ++from) {
    for (std::size_t cell = 0; cell < cells_; ++cell) {
      if (places[from][cell] != is_on) continue;
      for (std::size_t to = 0; to < places.size(); ++to) {
        for (const Tap& tap : taps_[offset(from, to)]) energy += places[to][moved(cell, tap)] == is_on ? tap.weight : 0;
      }
    }
  }
  return energy;
}

void SliceConstructionOracle::list_taps() {
  taps_.resize(kernel_.weights.size() / cells_);
  for (std::size_t at = 0; at < kernel_.weights.size(); ++at) {
    if (kernel_.weights[at] == 0) continue;
    const auto cell = static_cast<std::int64_t>(at % cells_);
    taps_[at / cells_].push_back({cell % extents_.width(), cell / extents_.width(), kernel_.weights[at]});
  }
}

std::size_t SliceConstructionOracle::moved(std::size_t cell, const Tap& tap) const {
  const std::int64_t width = extents_.width();
  std::int64_t x = static_cast<std::int64_t>(cell) % width + tap.dx;
  std::int64_t y = static_cast<std::int64_t>(cell) / width + tap.dy;
  if (x >= width) x -= width;
  if (y >= extents_.height()) y -= extents_.height();
  return static_cast<std::size_t>(x + width * y);
}

std::size_t SliceConstructionOracle::offset(std::size_t from, std::size_t to) const {
  Extents::SliceCoord d = extents_.slice_coord(SliceIndex(from));
  for (std::int32_t& coordinate : d) coordinate = -coordinate;
  return static_cast<std::size_t>(extents_.slice_at(SliceIndex(to), d));
}

void SliceConstructionOracle::draw_start(std::uint64_t seed, std::size_t slice) {
  std::int64_t missing = progress_.num_start_points;
  for (std::uint64_t draw = 0; missing > 0; ++draw) {
    const RandomBlock block = random_block(seed, Purpose::slice_pattern, static_cast<std::uint32_t>(slice), 0, draw);
    const std::uint64_t bits = (std::uint64_t{block[0]} << 32) | block[1];
    const auto cell = static_cast<std::size_t>((static_cast<unsigned __int128>(bits) * cells_) >> 64);
    if (on_[slice][cell]) continue;
    places_[slice][cell] = pixel_is_on;
    turn_everywhere(slice, cell, true);
    --missing;
  }
}

void SliceConstructionOracle::act(std::size_t from, std::size_t cell, bool on, std::size_t to) {
  for (const Tap& tap : taps_[offset(from, to)]) energy_[to][moved(cell, tap)] += on ? tap.weight : -tap.weight;
}
void SliceConstructionOracle::turn(const Flip& flip) {
  on_[flip.slice][flip.cell] = flip.on;
  act(flip.slice, flip.cell, flip.on, flip.slice);
}
void SliceConstructionOracle::tell_others(const Flip& flip) {
  for (std::size_t to = 0; to < places_.size(); ++to) {
    if (to != flip.slice) act(flip.slice, flip.cell, flip.on, to);
  }
}
void SliceConstructionOracle::turn_everywhere(std::size_t slice, std::size_t cell, bool on) {
  turn({slice, cell, on});
  tell_others({slice, cell, on});
}

std::size_t SliceConstructionOracle::extreme(std::size_t slice, bool largest_on) const {
  std::size_t best = cells_;
  const auto hash_of = [&](std::size_t cell) { return hash_(slice * cells_ + cell); };
  const std::vector<std::int64_t>& energy = energy_[slice];
  for (std::size_t cell = 0; cell < cells_; ++cell) {
    if (on_[slice][cell] != largest_on) continue;
    if (progress_.phase == ConstructPhase::exchange && places_[slice][cell] < pixel_is_on) continue;
    bool better = best == cells_;
    if (!better && energy[cell] != energy[best]) {
      better = (energy[cell] > energy[best]) == largest_on;
    } else if (!better) {
      better = (hash_of(cell) > hash_of(best)) == largest_on;  // no two hashes are equal below 2^32 pixels
    }
    if (better) best = cell;
  }
  return best;
}

std::int64_t SliceConstructionOracle::picks_of_visit() const {
  const std::int64_t half = progress_.num_start_points;
  if (progress_.phase == ConstructPhase::spread) return std::min(points_, half - progress_.rounds * points_);
  if (progress_.phase == ConstructPhase::exchange) {
    const std::int64_t steps = static_cast<std::int64_t>(cells_) - half;
    return std::min(points_, steps - progress_.num_placed / 2);
  }
  const std::int64_t all =
      progress_.phase == ConstructPhase::drain ? progress_.num_start_points : static_cast<std::int64_t>(cells_);
  return progress_.phase == ConstructPhase::relax ? points_ : std::min(points_, all - progress_.num_placed);
}

std::int64_t SliceConstructionOracle::visit(std::size_t slice, std::int64_t picks, std::vector<Flip>& flips) {
  const auto flip = [&](std::size_t cell, bool on) {
    flips.push_back({slice, cell, on});
    turn(flips.back());
  };
  std::vector<std::uint32_t>& places = places_[slice];
  if (circular_ && progress_.phase != ConstructPhase::relax) {
    for (std::int64_t k = 0; k < picks; ++k) {
      const auto step = static_cast<std::uint32_t>(progress_.num_placed / 2 + k);
      const std::size_t from = progress_.phase == ConstructPhase::exchange ? extreme(slice, true) : cells_;
      if (from < cells_) {
        flip(from, false);
        places[from] = step;
      }
      const std::size_t to = extreme(slice, false);
      flip(to, true);
      places[to] = progress_.phase == ConstructPhase::spread
                       ? pixel_is_on
                       : step + static_cast<std::uint32_t>(progress_.num_start_points);
    }
    return 0;
  }
  std::int64_t swaps = 0;
  for (std::int64_t k = 0; k < picks; ++k) {
    std::size_t from = cells_;
    if (progress_.phase != ConstructPhase::fill) {
      from = extreme(slice, true);
      flip(from, false);
      const std::int64_t left = progress_.num_start_points - progress_.num_placed - k;
      if (progress_.phase == ConstructPhase::drain) places[from] = static_cast<std::uint32_t>(left - 1);
    }
    if (progress_.phase == ConstructPhase::drain) continue;
    const std::size_t to = extreme(slice, false);
    flip(to, true);
    if (from == to) break;
    ++swaps;
    if (progress_.phase == ConstructPhase::relax) {
      places[from] = pixel_is_off;
      places[to] = pixel_is_on;
    } else {
      places[to] = static_cast<std::uint32_t>(progress_.num_placed + k);
    }
  }
  return swaps;
}

void SliceConstructionOracle::enter(ConstructPhase phase) {
  progress_.phase = phase;
  progress_.rounds = 0;
  if (phase != ConstructPhase::fill) return;
  for (std::size_t slice = 0; slice < places_.size(); ++slice) {  // the pattern again
    for (std::size_t cell = 0; cell < cells_; ++cell) {
      if (places_[slice][cell] < pixel_is_on) turn_everywhere(slice, cell, true);
    }
  }
}
void SliceConstructionOracle::end_relaxing() { enter(circular_ ? ConstructPhase::exchange : ConstructPhase::drain); }
void SliceConstructionOracle::end_phases() {
  const std::int64_t points = progress_.num_start_points;
  if (progress_.phase == ConstructPhase::spread && progress_.rounds * points_ >= points) {
    enter(ConstructPhase::relax);
  }
  if (progress_.phase == ConstructPhase::relax && points == 0) end_relaxing();
  if (progress_.phase == ConstructPhase::drain && progress_.num_placed == points) enter(ConstructPhase::fill);
  const bool full = progress_.num_placed == static_cast<std::int64_t>(cells_);
  const bool filling = progress_.phase == ConstructPhase::fill || progress_.phase == ConstructPhase::exchange;
  if (filling && full) enter(ConstructPhase::done);
}

}  // namespace noiseloom::oracle
