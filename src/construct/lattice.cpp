#include "noiseloom/construct/lattice.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "noiseloom/core/error.h"
#include "noiseloom/core/random.h"

namespace noiseloom {
namespace {

// What each part of a search may take: a second or two. A term of a pair of lattices is ten of one.
constexpr double most_terms = 5e8;
constexpr double most_terms_of_pairs = 5e7;

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
  // How many of them are different, each of as many pixels.
  std::int64_t count() const { return turn / std::gcd(std::gcd(step_x, step_y), turn); }
  std::int64_t turn;
  std::int64_t step_x;
  std::int64_t step_y;
};

// How many different pairs of phases the pixels of a slice have by two lattices, each of as many pixels: the order of
// the group that the steps (a.step_x, b.step_x) and (a.step_y, b.step_y) generate modulo the turn.
std::int64_t count_of_pairs(const PlanePhases& a, const PlanePhases& b) {
  const auto whole = [](std::int64_t value) { return static_cast<std::uint64_t>(value); };
  const std::uint64_t turn = whole(a.turn);
  const std::uint64_t common =
      std::gcd(std::gcd(whole(a.step_x), whole(a.step_y)), std::gcd(std::gcd(whole(b.step_x), whole(b.step_y)), turn));
  const std::uint64_t products[] = {whole(a.step_x) / common * (whole(b.step_y) / common) % turn,
                                    whole(a.step_y) / common * (whole(b.step_x) / common) % turn};
  const std::uint64_t determinant = (products[0] + turn - products[1]) % turn;
  return static_cast<std::int64_t>(turn / common * (turn / std::gcd(common * determinant % turn, turn)));
}

// Where nothing is known of the order of pixels of equal phase, those are the third of an L-th part of a turn apart in
// the mean; others as their phases are. `equal`: the weights of the taps between pixels of equal phase.
double of_unknown_order(double equal, std::int64_t num_phases) {
  return -equal / (6 * static_cast<double>(num_phases));
}

// So that about `terms` / stride are within what a search may take. Odd, so that it meets all remainders of two's
// powers, which sizes mostly are.
std::int64_t odd_stride(double terms, std::int64_t size) {
  return std::min(static_cast<std::int64_t>(terms / most_terms) + 1, size) | 1;
}

// The best over x and y, by the taps within a slice. A lattice and its mirror image in the origin are one. Where there
// are too many, evenly chosen ones along x are tried, and along y, too, where taps are so many that even those are.
std::vector<Candidate> best_of_plane(const Footprint& overlap, std::size_t count,
                                     const std::function<bool()>& goes_on) {
  const Extents& extents = overlap.extents();
  const std::int64_t width = extents.width();
  const std::int64_t height = extents.height();
  const std::span<const PlaneTap> taps = overlap.slices()[0].taps;
  const double terms_of_row = static_cast<double>(height) * static_cast<double>(taps.size());
  const auto stride_y = odd_stride(terms_of_row, height);
  const double terms = static_cast<double>(width / 2 + 1) * terms_of_row / static_cast<double>(stride_y);
  const auto stride_x = odd_stride(terms, width);
  const std::int64_t num_rows = (height - 1) / stride_y + 1;
  std::vector<Candidate> best;
  std::vector<double> energies(static_cast<std::size_t>(num_rows));
  std::vector<double> equal(static_cast<std::size_t>(num_rows));
  for (std::int64_t a = stride_x / 2; a <= width / 2 && goes_on(); a += stride_x) {
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
      if (best.size() == count && energies[i] - std::max(equal[i], 0.0) > best.back().energy) continue;
      Candidate candidate{{a, static_cast<std::int64_t>(i) * stride_y}, energies[i]};
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

// What two lattices make of a tap: how far ahead it is by the first, and by the second.
struct TapPhases {
  Phase first;
  Phase between;
  bool stays_at_pixel;  // of another slice
  double weight;
};

// Calls visit(TapPhases) for all taps but that of zero.
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
      visit(TapPhases{of_slice + x[at_x] + y[at_y], between_x[at_x] + between_y[at_y], tap.dx == 0 && tap.dy == 0,
                      tap.weight});
    }
  }
}

double energy_of(const Footprint& overlap, const std::vector<std::int64_t>& cycles) {
  double sum = overlap.weight_zero() * bernoulli_2_of_zero;
  double equal = 0;
  each_tap(overlap, cycles, cycles, [&](const TapPhases& tap) {
    sum += tap.weight * bernoulli_2(tap.first);
    equal += is_zero(tap.first) && !tap.stays_at_pixel ? tap.weight : 0;
  });
  return sum + of_unknown_order(equal, PlanePhases(cycles, overlap.extents()).count());
}

// Into how many places, evenly apart, the beginnings of slices divide what is between two phases of a slice.
double num_leads(const Extents& extents, const std::vector<std::int64_t>& cycles, std::int64_t num_phases) {
  std::int64_t result = 1;
  for (int axis = 2; axis < extents.num_axes(); ++axis) {
    const std::int64_t size = extents.size(axis);
    const std::int64_t step = cycles[static_cast<std::size_t>(axis)] % size * (num_phases % size) % size;
    result = std::lcm(result, size / std::gcd(size, step));
  }
  return static_cast<double>(result);
}

// A range of what is between two phases, and what of it begins anew where the turn ends there. All arcs of a circle,
// which slices turn by num_leads() even steps; in units of those steps, whole ones meet alike wherever they are.
class Range {
 public:
  // That share `length` of the whole which is its beginning or its end.
  Range(double length, bool at_end, double leads) : length_(length * leads), at_end_(at_end), leads_(leads) {
    whole_ = std::floor(length_);
    rest_ = length_ - whole_;
  }
  // The share of it that meets the last `part` of the whole, in the mean over slices.
  double share(double part) const {
    const double in_steps = part * leads_;
    const double whole = std::floor(in_steps);
    const double rest = in_steps - whole;
    const double met = at_end_ ? std::min(rest_, rest) : std::max(0.0, rest_ + rest - 1);
    return (whole_ * in_steps + rest_ * whole + met) / (leads_ * length_);
  }

 private:
  double length_;
  bool at_end_;
  double leads_;
  double whole_;
  double rest_;
};

// The mean distance of two samples of which one is `ahead` of the other by that part of a turn, for those whose second
// phase lies in `range`.
double mean_distance(double ahead, double num_phases, const Range& range) {
  const double in_parts = ahead * num_phases;
  const double whole = std::floor(in_parts);
  const double beginning_anew = (whole + range.share(in_parts - whole)) / num_phases;
  return (1 - beginning_anew) * ahead + beginning_anew * (1 - ahead);
}

// By the equation of lattice.h, and how doubtful that is: where pixels are left that both lattices have at the same
// phases, their order, that of memory, adds to what samples are apart or takes from it, so that lattices would be
// chosen for what the equation does not see. With a third of this some were, with 0.6 of it none of 150 filters; the
// more, the more good ones are not.
struct PairEnergy {
  double energy;
  double doubt;
};
PairEnergy energy_of(const Footprint& overlap, const std::vector<std::int64_t>& cycles,
                     const std::vector<std::int64_t>& between) {
  const Extents& extents = overlap.extents();
  const PlanePhases first(cycles, extents);
  const auto num_phases = static_cast<double>(first.count());
  const std::int64_t num_pairs = count_of_pairs(first, PlanePhases(between, extents));
  const double of_equal = 1 / (3 * static_cast<double>(num_pairs));
  double all = 0;
  const double leads = num_leads(extents, cycles, first.count());
  const auto part_of_turn = [](double value) { return value - std::floor(value); };
  double sum = overlap.weight_zero() * bernoulli_2_of_zero;
  each_tap(overlap, cycles, between, [&](const TapPhases& tap) {
    const double t = is_zero(tap.first) ? 0 : fraction(tap.first);
    const double u = is_zero(tap.between) ? 0 : fraction(tap.between);
    double distance = (1 - u) * mean_distance(part_of_turn(t + u / num_phases), num_phases, Range(1 - u, false, leads));
    if (u > 0) {
      distance += u * mean_distance(part_of_turn(t - (1 - u) / num_phases), num_phases, Range(u, true, leads));
    }
    if (t == 0 && u == 0 && !tap.stays_at_pixel) distance = of_equal;
    all += std::abs(tap.weight);
    sum += tap.weight * (bernoulli_2_of_zero - distance / 2);
  });
  return {sum, num_pairs == extents.cells_per_slice() ? 0 : all * of_equal / 3};
}

// Gives the candidate cycles along the slice axes, the best for each while those along the next are none. Where there
// are too many, evenly chosen ones are tried.
void extend(const Footprint& overlap, Candidate& candidate, const std::function<bool()>& goes_on) {
  const Extents& extents = overlap.extents();
  candidate.cycles.resize(static_cast<std::size_t>(extents.num_axes()), 0);
  candidate.energy = energy_of(overlap, candidate.cycles);
  for (int axis = 2; axis < extents.num_axes(); ++axis) {
    const double terms = static_cast<double>(extents.size(axis)) * static_cast<double>(overlap.num_taps());
    const std::int64_t stride = odd_stride(terms, extents.size(axis));
    Candidate trial = candidate;
    for (std::int64_t c = stride; c < extents.size(axis) && goes_on(); c += stride) {
      trial.cycles[static_cast<std::size_t>(axis)] = c;
      trial.energy = energy_of(overlap, trial.cycles);
      if (trial.energy < candidate.energy) candidate = trial;
    }
  }
}

std::size_t count_within(double wanted, double least, double most) {
  return static_cast<std::size_t>(std::clamp(wanted, least, most));
}

}  // namespace

std::optional<Lattice> find_lattice(const Footprint& overlap, const std::function<bool()>& goes_on) {
  NOISELOOM_CHECK(!overlap.slices()[0].taps.empty());
  const Extents& extents = overlap.extents();
  const auto num_taps = static_cast<double>(overlap.num_taps() + 1);
  double trials = 1;
  for (int axis = 2; axis < extents.num_axes(); ++axis) trials += static_cast<double>(extents.size(axis)) - 1;
  constexpr double most_kept = 256;
  std::vector<Candidate> plane = best_of_plane(overlap, static_cast<std::size_t>(most_kept), goes_on);
  std::vector<Candidate> best(
      plane.begin(), plane.begin() + static_cast<std::ptrdiff_t>(std::min(
                                         plane.size(), count_within(most_terms / (trials * num_taps), 1, most_kept))));
  for (Candidate& candidate : best) extend(overlap, candidate, goes_on);
  std::ranges::sort(best, less);

  // Some that tell the pixels of a row, a column or a diagonal apart, should none of the best.
  const std::int64_t one_x = 1 % extents.width();
  const std::int64_t one_y = 1 % extents.height();
  for (const auto& [a, b] :
       {std::pair(one_x, std::int64_t{0}), std::pair(std::int64_t{0}, one_y), std::pair(one_x, one_y)}) {
    plane.insert(plane.begin(), Candidate{{a, b}});
  }
  const double most_pairs = most_terms_of_pairs / num_taps;
  const std::size_t num_firsts = std::min(best.size(), count_within(most_pairs / 64, 8, most_kept));
  const std::size_t num_others =
      std::min(plane.size(), count_within(most_pairs / static_cast<double>(num_firsts), 8, most_kept));
  const double of_noise = overlap.weight_zero() * bernoulli_2_of_zero;
  std::optional<Lattice> found;
  double least = 0;
  for (std::size_t i = 0; i < num_firsts; ++i) {
    for (std::size_t k = 0; k < num_others; ++k) {
      if (!goes_on()) return std::nullopt;
      const auto [energy, doubt] = energy_of(overlap, best[i].cycles, plane[k].cycles);
      if (found && energy + doubt >= least) continue;
      least = energy + doubt;
      found = Lattice{best[i].cycles, plane[k].cycles, energy / of_noise};
    }
  }
  return found;
}

std::vector<std::uint32_t> lattice_places(const Lattice& lattice, const Extents& extents, std::uint64_t seed) {
  // Each phase and each pair of phases has as many pixels, so that places follow without sorting.
  const PlanePhases first(lattice.cycles, extents);
  const PlanePhases second(lattice.between, extents);
  const auto num_phases = static_cast<std::uint64_t>(first.count());
  const auto num_pairs = static_cast<std::uint64_t>(count_of_pairs(first, second));
  const auto turn = static_cast<std::uint64_t>(first.turn);
  const auto cells = static_cast<std::uint64_t>(extents.cells_per_slice());
  const std::uint64_t pairs_of_phase = num_pairs / num_phases;
  const std::uint64_t apart = turn / num_phases;
  const RandomBlock random = random_block(seed, Purpose::lattice_shift, 0, 0, 0);
  const std::int64_t shift_x = to_below(random[0], static_cast<std::uint64_t>(extents.width()));
  const std::int64_t shift_y = to_below(random[1], static_cast<std::uint64_t>(extents.height()));
  const auto phase_at = [turn](const PlanePhases& phases, std::int64_t x, std::int64_t y) {  // at most 2^32 by 2^32
    const std::uint64_t along_x = static_cast<std::uint64_t>(phases.step_x) * static_cast<std::uint64_t>(x) % turn;
    const std::uint64_t along_y = static_cast<std::uint64_t>(phases.step_y) * static_cast<std::uint64_t>(y) % turn;
    return static_cast<std::int64_t>((along_x + along_y) % turn);
  };
  std::vector<std::uint32_t> taken(num_pairs);  // of the places of each pair
  std::vector<std::uint32_t> places(cells);
  std::size_t cell = 0;
  for (std::int64_t y = 0; y < extents.height(); ++y) {
    std::int64_t phase = phase_at(first, shift_x, (y + shift_y) % extents.height());
    std::int64_t other = phase_at(second, shift_x, (y + shift_y) % extents.height());
    for (std::int64_t x = 0; x < extents.width(); ++x) {
      const std::uint64_t pair = static_cast<std::uint64_t>(phase) / apart * pairs_of_phase +
                                 static_cast<std::uint64_t>(other) * pairs_of_phase / turn;
      places[cell++] = static_cast<std::uint32_t>(pair * (cells / num_pairs) + taken[pair]++);
      phase = (phase + first.step_x) % first.turn;
      other = (other + second.step_x) % second.turn;
    }
  }
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
