#include "noiseloom/construct/lattice.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

// What each part of a search may take: a second or two.
constexpr double most_terms = 5e8;

// A phase is a fraction of 2^64, which additions wrap around.
using Phase = std::uint64_t;

// h * d / size mod 1; 1 / size is rounded down, by less than any phase differs from another.
Phase phase_of(std::int64_t cycles, std::int64_t offset, std::int64_t size) {
  const std::int64_t part = cycles * offset % size;
  return static_cast<Phase>(part < 0 ? part + size : part) * (~Phase{0} / static_cast<Phase>(size));
}
bool is_zero(Phase phase) { return phase + (Phase{1} << 40) < Phase{1} << 41; }
double fraction(Phase phase) { return static_cast<double>(phase >> 11) * 0x1p-53; }

constexpr double bernoulli_2_of_zero = 1.0 / 6;
double bernoulli_2(Phase phase) {
  const double u = fraction(phase);
  return u * u - u + bernoulli_2_of_zero;
}

struct Candidate {
  std::vector<std::int64_t> cycles;
  double energy = 0;
};

bool less(const Candidate& a, const Candidate& b) {
  return a.energy != b.energy ? a.energy < b.energy : a.cycles < b.cycles;
}

// Phases of the pixels of a slice in whole numbers: parts of `turn`.
struct PlanePhases {
  PlanePhases(const std::vector<std::int64_t>& cycles, const Extents& extents)
      : turn(std::lcm(extents.width(), extents.height())),
        step_x(cycles[0] * (turn / extents.width()) % turn),
        step_y(cycles[1] * (turn / extents.height()) % turn) {}
  // How many of them are different.
  std::int64_t count() const { return turn / std::gcd(std::gcd(step_x, step_y), turn); }
  std::int64_t turn;
  std::int64_t step_x;
  std::int64_t step_y;
};

// Calls visit(cell, phase) for the pixels of a slice.
template <class Visit>
void each_phase(const PlanePhases& phases, const Extents& extents, const Visit& visit) {
  std::uint32_t cell = 0;
  std::int64_t of_row = 0;
  for (std::int64_t y = 0; y < extents.height(); ++y) {
    std::int64_t phase = of_row;
    for (std::int64_t x = 0; x < extents.width(); ++x) {
      visit(cell++, phase);
      phase = (phase + phases.step_x) % phases.turn;
    }
    of_row = (of_row + phases.step_y) % phases.turn;
  }
}

// Where nothing is known of the order of pixels of equal phase, those are the third of an L-th part of a turn apart in
// the mean; others as their phases are. `equal`: the weights of the taps between pixels of equal phase.
double of_unknown_order(double equal, std::int64_t num_phases) {
  return -equal / (6 * static_cast<double>(num_phases));
}

// The best over x and y, by the taps within a slice. A lattice and its mirror image in the origin are one. Where there
// are too many, evenly chosen ones along x are tried, and along y, too, where taps are so many that even those are.
std::vector<Candidate> best_of_plane(const Footprint& overlap, std::size_t count) {
  const Extents& extents = overlap.extents();
  const std::int64_t width = extents.width();
  const std::int64_t height = extents.height();
  const std::span<const PlaneTap> taps = overlap.slices()[0].taps;
  const double terms_of_row = static_cast<double>(height) * static_cast<double>(taps.size());
  const auto stride_y = std::min(static_cast<std::int64_t>(terms_of_row / most_terms) + 1, height);
  const double terms = static_cast<double>(width / 2 + 1) * terms_of_row / static_cast<double>(stride_y);
  const auto stride_x = std::min(static_cast<std::int64_t>(terms / most_terms) + 1, width);
  const std::int64_t num_rows = (height - 1) / stride_y + 1;
  std::vector<Candidate> best;
  std::vector<double> energies(static_cast<std::size_t>(num_rows));
  std::vector<double> equal(static_cast<std::size_t>(num_rows));
  for (std::int64_t a = stride_x / 2; a <= width / 2; a += stride_x) {
    std::fill(energies.begin(), energies.end(), overlap.weight_zero() * bernoulli_2_of_zero);
    std::fill(equal.begin(), equal.end(), 0.0);
    for (const PlaneTap& tap : taps) {
      Phase phase = phase_of(a, tap.dx, width);
      const Phase step = phase_of(stride_y, tap.dy, height);
      for (std::size_t b = 0; b < energies.size(); ++b) {
        energies[b] += tap.weight * bernoulli_2(phase);
        equal[b] += is_zero(phase) ? tap.weight : 0;
        phase += step;
      }
    }
    for (std::size_t i = 0; i < energies.size(); ++i) {
      Candidate candidate{{a, static_cast<std::int64_t>(i) * stride_y}, energies[i]};
      if (best.size() == count && energies[i] - std::max(equal[i], 0.0) > best.back().energy) continue;
      candidate.energy += of_unknown_order(equal[i], PlanePhases(candidate.cycles, extents).count());
      if (best.size() == count && !less(candidate, best.back())) continue;
      if (best.size() == count) best.pop_back();
      best.insert(std::ranges::upper_bound(best, candidate, less), std::move(candidate));
    }
  }
  return best;
}

// Phases of the offsets along an axis, from -reach to reach.
std::vector<Phase> phases_along(std::int64_t cycles, std::int64_t size, std::int32_t reach) {
  std::vector<Phase> phases;
  for (std::int32_t offset = -reach; offset <= reach; ++offset) phases.push_back(phase_of(cycles, offset, size));
  return phases;
}

// Calls visit(phase by `cycles`, phase by `between` along x and y, weight) for all taps but that of zero.
template <class Visit>
void each_tap(const Footprint& overlap, const std::vector<std::int64_t>& cycles,
              const std::vector<std::int64_t>& between, const Visit& visit) {
  const Extents& extents = overlap.extents();
  const std::int32_t reach_x = overlap.reach(0);
  const std::int32_t reach_y = overlap.reach(1);
  const std::vector<Phase> x = phases_along(cycles[0], extents.width(), reach_x);
  const std::vector<Phase> y = phases_along(cycles[1], extents.height(), reach_y);
  const std::vector<Phase> between_x = phases_along(between[0], extents.width(), reach_x);
  const std::vector<Phase> between_y = phases_along(between[1], extents.height(), reach_y);
  for (const SliceTaps& slice : overlap.slices()) {
    Phase of_slice = 0;
    for (int axis = 2; axis < extents.num_axes(); ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      of_slice += phase_of(cycles[a], slice.offset[a - 2], extents.size(axis));
    }
    for (const PlaneTap& tap : slice.taps) {
      const auto at_x = static_cast<std::size_t>(tap.dx + reach_x);
      const auto at_y = static_cast<std::size_t>(tap.dy + reach_y);
      visit(of_slice + x[at_x] + y[at_y], between_x[at_x] + between_y[at_y], tap.weight);
    }
  }
}

double energy_of(const Footprint& overlap, const std::vector<std::int64_t>& cycles) {
  double sum = overlap.weight_zero() * bernoulli_2_of_zero;
  double equal = 0;
  each_tap(overlap, cycles, cycles, [&](Phase phase, Phase, double weight) {
    sum += weight * bernoulli_2(phase);
    equal += is_zero(phase) ? weight : 0;
  });
  return sum + of_unknown_order(equal, PlanePhases(cycles, overlap.extents()).count());
}

// The mean distance of two samples of which one is `ahead` of the other by that part of a turn, for those whose second
// phase lies in a range of it: `past(f)` is the share of that range above 1 - f.
template <class Past>
double mean_distance(double ahead, double num_phases, const Past& past) {
  const double in_parts = ahead * num_phases;
  const double whole = std::floor(in_parts);
  const double beginning_anew = (whole + past(in_parts - whole)) / num_phases;
  return (1 - beginning_anew) * ahead + beginning_anew * (1 - ahead);
}

double energy_of(const Footprint& overlap, const std::vector<std::int64_t>& cycles,
                 const std::vector<std::int64_t>& between) {
  const auto num_phases = static_cast<double>(PlanePhases(cycles, overlap.extents()).count());
  const auto part_of_turn = [](double value) { return value - std::floor(value); };
  double sum = overlap.weight_zero() * bernoulli_2_of_zero;
  each_tap(overlap, cycles, between, [&](Phase phase, Phase other, double weight) {
    const double t = fraction(phase);
    const double u = is_zero(other) ? 0 : fraction(other);
    double distance = (1 - u) * mean_distance(part_of_turn(t + u / num_phases), num_phases,
                                              [&](double f) { return std::max(0.0, f - u) / (1 - u); });
    if (u > 0) {
      distance += u * mean_distance(part_of_turn(t - (1 - u) / num_phases), num_phases,
                                    [&](double f) { return std::min(f, u) / u; });
    }
    sum += weight * (bernoulli_2_of_zero - distance / 2);
  });
  return sum;
}

// Gives the candidate cycles along the slice axes, the best for each while those along the next are none. Where there
// are too many, evenly chosen ones are tried.
void extend(const Footprint& overlap, Candidate& candidate) {
  const Extents& extents = overlap.extents();
  candidate.cycles.resize(static_cast<std::size_t>(extents.num_axes()), 0);
  candidate.energy = energy_of(overlap, candidate.cycles);
  for (int axis = 2; axis < extents.num_axes(); ++axis) {
    const double terms = static_cast<double>(extents.size(axis)) * static_cast<double>(overlap.num_taps());
    const auto stride = static_cast<std::int64_t>(terms / most_terms) + 1;
    Candidate trial = candidate;
    for (std::int64_t c = stride; c < extents.size(axis); c += stride) {
      trial.cycles[static_cast<std::size_t>(axis)] = c;
      trial.energy = energy_of(overlap, trial.cycles);
      if (trial.energy < candidate.energy) candidate = trial;
    }
  }
}

std::size_t count_within(double wanted, double least, double most) {
  return static_cast<std::size_t>(std::clamp(wanted, least, most));
}

// Of the lattices over x and y those that tell pixels of equal phase apart.
std::vector<const Candidate*> that_separate(const std::vector<Candidate>& plane,
                                            const std::vector<std::int64_t>& cycles, const Extents& extents) {
  std::vector<std::uint32_t> equal_to_first;
  each_phase(PlanePhases(cycles, extents), extents, [&](std::uint32_t cell, std::int64_t phase) {
    if (phase == 0 && cell != 0) equal_to_first.push_back(cell);
  });
  std::vector<const Candidate*> result;
  for (const Candidate& other : plane) {
    const PlanePhases phases(other.cycles, extents);
    const bool separates = std::ranges::none_of(equal_to_first, [&](std::uint32_t cell) {
      const std::int64_t x = cell % extents.width();
      const std::int64_t y = cell / extents.width();
      return (phases.step_x * x % phases.turn + phases.step_y * y % phases.turn) % phases.turn == 0;
    });
    if (separates) result.push_back(&other);
  }
  return result;
}

}  // namespace

Lattice find_lattice(const Footprint& overlap) {
  if (overlap.slices()[0].taps.empty()) {
    throw UserError("optimizer.start.pattern",
                    "a lattice follows from how pixels of a slice act on each other, and by this filter none do");
  }
  const Extents& extents = overlap.extents();
  const auto num_taps = static_cast<double>(overlap.num_taps() + 1);
  double trials = 1;
  for (int axis = 2; axis < extents.num_axes(); ++axis) trials += static_cast<double>(extents.size(axis)) - 1;
  constexpr double most_kept = 256;
  std::vector<Candidate> plane = best_of_plane(overlap, static_cast<std::size_t>(most_kept));
  std::vector<Candidate> best(
      plane.begin(), plane.begin() + static_cast<std::ptrdiff_t>(std::min(
                                         plane.size(), count_within(most_terms / (trials * num_taps), 1, most_kept))));
  for (Candidate& candidate : best) extend(overlap, candidate);
  std::ranges::sort(best, less);

  // Some that tell the pixels of a row, a column or a diagonal apart, should none of the best.
  for (const auto& [a, b] : {std::pair(1, 0), std::pair(0, 1), std::pair(1, 1)}) plane.push_back({{a, b}});
  constexpr std::size_t most_firsts = 4;
  const std::size_t most_pairs = count_within(most_terms / num_taps, most_firsts, most_firsts * most_kept);
  const double of_noise = overlap.weight_zero() * bernoulli_2_of_zero;
  Lattice found{best.front().cycles, plane.back().cycles, best.front().energy / of_noise};
  std::size_t num_firsts = 0;
  for (const Candidate& first : best) {
    // A lattice with few phases leaves more pixels for equal than another has phases.
    const PlanePhases phases(first.cycles, extents);
    if (extents.cells_per_slice() / phases.count() > phases.turn) continue;
    const std::vector<const Candidate*> others = that_separate(plane, first.cycles, extents);
    if (others.empty()) continue;
    for (std::size_t k = 0; k < std::min(others.size(), most_pairs / most_firsts); ++k) {
      const double error = energy_of(overlap, first.cycles, others[k]->cycles) / of_noise;
      if ((num_firsts == 0 && k == 0) || error < found.relative_error) found = {first.cycles, others[k]->cycles, error};
    }
    if (++num_firsts == most_firsts) break;
  }
  return found;
}

std::vector<std::uint32_t> lattice_places(const Lattice& lattice, const Extents& extents) {
  // Phases of both in one word: each is below the number of pixels, which is at most 2^32.
  struct Pixel {
    std::uint64_t phases;
    std::uint32_t cell;
  };
  std::vector<Pixel> pixels(static_cast<std::size_t>(extents.cells_per_slice()));
  const PlanePhases first(lattice.cycles, extents);
  const PlanePhases second(lattice.between, extents);
  each_phase(first, extents, [&](std::uint32_t cell, std::int64_t phase) {
    pixels[cell] = {static_cast<std::uint64_t>(phase) * static_cast<std::uint64_t>(second.turn), cell};
  });
  each_phase(second, extents,
             [&](std::uint32_t cell, std::int64_t phase) { pixels[cell].phases += static_cast<std::uint64_t>(phase); });
  std::ranges::sort(pixels, [](const Pixel& a, const Pixel& b) {
    return a.phases != b.phases ? a.phases < b.phases : a.cell < b.cell;
  });
  std::vector<std::uint32_t> places(pixels.size());
  for (std::uint32_t place = 0; place < pixels.size(); ++place) places[pixels[place].cell] = place;
  return places;
}

std::uint32_t places_ahead(const Lattice& lattice, const Extents& extents, SliceIndex slice) {
  const Extents::SliceCoord at = extents.slice_coord(slice);
  Phase phase = 0;
  for (int axis = 2; axis < extents.num_axes(); ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    phase += phase_of(lattice.cycles[a], at[a - 2], extents.size(axis));
  }
  const auto cells = static_cast<std::uint64_t>(extents.cells_per_slice());
  const std::uint64_t ahead = ((phase >> 32) * cells + (std::uint64_t{1} << 31)) >> 32;
  return static_cast<std::uint32_t>(ahead % cells);
}

}  // namespace noiseloom
