#include "noiseloom/construct/slice_construction.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "construct/plane_field.h"
#include "construct/stamp_kernel.h"
#include "noiseloom/core/decimal.h"
#include "noiseloom/core/random.h"
#include "noiseloom/dist/halo_exchange.h"
#include "noiseloom/dist/halo_plan.h"
#include "noiseloom/problem/colour_classes.h"
#include "noiseloom/problem/footprint.h"

namespace noiseloom {
namespace {

// A visit picks one cell in so many. Of 64x64x32, gauss 1.3435 x ema, sharpness 1.4, R is 0.0466 with 256, 0.0462 with
// 1024 and with 4096, which takes a third more time (construct_bench).
constexpr std::int64_t cells_per_point = 1024;

// What relaxing may take at most, in picks for each point of the start pattern. About 0.4 are usual.
constexpr std::int64_t most_swaps_per_point = 4;

// In a message, where a pick turns nothing off or nothing on.
constexpr std::uint32_t no_cell = 0xFFFFFFFFU;

// Not of the overlap: weights may reach fewer slices, as they are cut, and others, where groups of a sum cancel.
std::vector<Extents::SliceCoord> slice_offsets(const StampKernel& kernel) {
  std::vector<Extents::SliceCoord> offsets;
  for (const SliceStamp& stamp : kernel.stamps()) offsets.push_back(stamp.offset);
  return offsets;
}

std::int64_t num_start_points(double density, std::int64_t cells) { return decimal_of(density).floor_of_times(cells); }

// Distinct cells of a slice, uniformly random.
std::vector<std::uint32_t> start_pattern(std::uint64_t seed, SliceIndex slice, std::int64_t cells, std::int64_t count) {
  std::vector<bool> on(static_cast<std::size_t>(cells));
  std::vector<std::uint32_t> pattern;
  for (std::uint64_t draw = 0; std::ssize(pattern) < count; ++draw) {
    const RandomBlock block = random_block(seed, Purpose::slice_pattern, static_cast<std::uint32_t>(slice), 0, draw);
    const std::uint64_t bits = (std::uint64_t{block[0]} << 32) | block[1];
    const auto cell =
        static_cast<std::uint32_t>((static_cast<unsigned __int128>(bits) * static_cast<std::uint64_t>(cells)) >> 64);
    if (on[cell]) continue;  // drawn before
    on[cell] = true;
    pattern.push_back(cell);
  }
  return pattern;
}

// What the picks of one visit did.
struct Changes {
  std::vector<std::uint32_t> off;
  std::vector<std::uint32_t> on;
};

// A slice that this rank owns, or that acts on one that it owns. What it did in its last two visits is kept until all
// others have taken it in.
struct HeldSlice {
  std::vector<std::uint32_t> places;  // [y][x], as SliceConstruction::places
  Changes changes[2];                 // by the parity of the round
};

}  // namespace

struct SliceConstruction::Impl {
  Impl(const Footprint& overlap, const FilterSpec& filter, const ConstructSpec& spec_in, std::uint64_t seed_in,
       const Communicator& communicator_in, ThreadPool& pool_in)
      : extents(overlap.extents()),
        spec(spec_in),
        seed(seed_in),
        cells(extents.cells_per_slice()),
        points(std::max<std::int64_t>(1, cells / cells_per_point)),
        communicator(communicator_in),
        pool(pool_in),
        kernel(extents, filter, spec.sharpness),
        hash(seed),
        classes(colour_classes(overlap)),
        distribution(extents.num_slices(), communicator.size(), communicator.rank()),
        halo(extents, slice_offsets(kernel), distribution),
        exchange(communicator, halo, distribution),
        class_of(static_cast<std::size_t>(extents.num_slices())),
        held_at(static_cast<std::size_t>(extents.num_slices()), -1) {
    for (std::size_t c = 0; c < classes.size(); ++c) {
      for (const SliceIndex slice : classes[c])
        class_of[static_cast<std::size_t>(slice)] = static_cast<std::int32_t>(c);
    }
    for (const SliceIndex slice : indices()) {
      held_at[static_cast<std::size_t>(slice)] = static_cast<std::int32_t>(held.size());
      held.emplace_back().places.resize(static_cast<std::size_t>(cells));
    }
    std::vector<PlaneField> own;
    for (const SliceIndex slice : distribution.own_slices()) {
      own.emplace_back(kernel, hash, static_cast<std::uint64_t>(cells) * static_cast<std::uint64_t>(slice));
    }
    fields = IndexedVector<LocalSlice, PlaneField>(std::move(own));
  }

  std::vector<SliceIndex> indices() const {
    const IndexRange<SliceIndex> own = distribution.own_slices();
    std::vector<SliceIndex> slices(own.begin(), own.end());
    slices.insert(slices.end(), halo.needed().begin(), halo.needed().end());
    return slices;
  }
  std::size_t held_index(SliceIndex slice) const {
    return static_cast<std::size_t>(held_at[static_cast<std::size_t>(slice)]);
  }
  HeldSlice& held_slice(SliceIndex slice) { return held[held_index(slice)]; }
  static Extents::SliceCoord opposite(const Extents::SliceCoord& offset) {
    Extents::SliceCoord result{};
    std::transform(offset.begin(), offset.end(), result.begin(), [](std::int32_t d) { return -d; });
    return result;
  }

  // Brings the energies of all own slices to what is on: the pixels without a place that are marked so, or (filling)
  // those that have a place.
  void compute_energies() {
    std::vector<std::vector<std::uint32_t>> on(held.size());
    const bool filling = progress.phase == ConstructPhase::fill;
    pool.for_each(std::ssize(held), [&](std::int64_t index, int) {
      const auto k = static_cast<std::size_t>(index);
      const std::vector<std::uint32_t>& places = held[k].places;
      for (std::uint32_t cell = 0; cell < places.size(); ++cell) {
        if (filling ? places[cell] < pixel_is_on : places[cell] == pixel_is_on) on[k].push_back(cell);
      }
      held[k].changes[0] = held[k].changes[1] = {};
    });
    pool.for_each(distribution.num_own(), [&](std::int64_t index, int) {
      const LocalSlice local(index);
      const SliceIndex slice = distribution.global_slice_from_local(local);
      PlaneField& field = fields[local];
      field.clear();
      field.watch(false, false);
      for (const std::uint32_t cell : on[held_index(slice)]) field.turn_on(cell);
      for (const SliceStamp& stamp : other_slices()) {
        const SliceIndex from = extents.slice_at(slice, opposite(stamp.offset));
        field.act(stamp, true, on[held_index(from)]);
      }
    });
    for (PlaneField& field : fields) {
      const bool relaxing = progress.phase == ConstructPhase::relax;
      field.watch(relaxing || filling, relaxing || progress.phase == ConstructPhase::drain);
    }
  }
  std::span<const SliceStamp> other_slices() const { return std::span(kernel.stamps()).subspan(1); }

  void enter(ConstructPhase phase) {
    progress.phase = phase;
    progress.rounds = 0;
    if (!done()) compute_energies();
  }

  void start() {
    progress = {.num_start_points = num_start_points(spec.density, cells)};
    const std::vector<SliceIndex> slices = indices();
    pool.for_each(std::ssize(slices), [&](std::int64_t index, int) {
      const auto k = static_cast<std::size_t>(index);
      std::vector<std::uint32_t>& places = held[k].places;
      std::fill(places.begin(), places.end(), pixel_is_off);
      for (const std::uint32_t cell : start_pattern(seed, slices[k], cells, progress.num_start_points)) {
        places[cell] = pixel_is_on;
      }
    });
    enter(ConstructPhase::relax);
    skip_ended_phases();
  }

  void restore(const ConstructProgress& from, const std::function<std::vector<std::uint32_t>(SliceIndex)>& places_of) {
    progress = from;
    communicator.together([&] {
      for (const SliceIndex slice : indices()) held_slice(slice).places = places_of(slice);
    });
    if (!done()) compute_energies();
  }
  bool done() const { return progress.phase == ConstructPhase::done; }

  // What others did since this slice was visited last: in this round if their class has moved in it, else in the one
  // before, which is what they did last.
  void take_in(SliceIndex slice, PlaneField& field) {
    const std::int32_t own_class = class_of[static_cast<std::size_t>(slice)];
    for (const SliceStamp& stamp : other_slices()) {
      const SliceIndex from = extents.slice_at(slice, opposite(stamp.offset));
      const bool moved = class_of[static_cast<std::size_t>(from)] < own_class;
      const Changes& changes = held_slice(from).changes[moved ? parity() : 1 - parity()];
      field.act(stamp, false, changes.off);
      field.act(stamp, true, changes.on);
    }
  }
  std::size_t parity() const { return static_cast<std::size_t>(total_rounds % 2); }

  // Picks in one slice, whose places follow from them (carry_out).
  void visit(SliceIndex slice, Changes& changes) {
    PlaneField& field = fields[distribution.local_slice_from_global(slice)];
    take_in(slice, field);
    changes.off.clear();
    changes.on.clear();
    const bool relaxing = progress.phase == ConstructPhase::relax;
    for (std::int64_t left = picks_of_visit(); left > 0; --left) {
      std::uint32_t from = no_cell;
      if (progress.phase != ConstructPhase::fill) {
        from = field.pick(VacView::clusters).value();
        field.turn_off(from);
        if (!relaxing) changes.off.push_back(from);
      }
      if (progress.phase == ConstructPhase::drain) continue;
      const std::uint32_t to = field.pick(VacView::voids).value();
      field.turn_on(to);
      if (from == to) return;  // no swap is left
      changes.on.push_back(to);
      if (relaxing) changes.off.push_back(from);
    }
  }

  std::int64_t picks_of_visit() const {
    if (progress.phase == ConstructPhase::relax) return points;
    const std::int64_t all = progress.phase == ConstructPhase::drain ? progress.num_start_points : cells;
    return std::min(points, all - progress.num_placed);
  }

  // What a visit did to the places of its slice, here or at its owner. A pixel that is swapped on may be swapped off
  // again in the same visit, so swaps go one by one.
  void carry_out(const Changes& changes, std::vector<std::uint32_t>& places) const {
    const bool relaxing = progress.phase == ConstructPhase::relax;
    auto place = static_cast<std::uint32_t>(progress.num_placed);
    for (std::size_t k = 0; k < std::max(changes.off.size(), changes.on.size()); ++k) {
      if (relaxing) {
        places[changes.off[k]] = pixel_is_off;
        places[changes.on[k]] = pixel_is_on;
      } else if (progress.phase == ConstructPhase::drain) {
        places[changes.off[k]] = static_cast<std::uint32_t>(progress.num_start_points) - 1 - place++;
      } else {
        places[changes.on[k]] = place++;
      }
    }
  }

  void move(const std::vector<SliceIndex>& moving) {
    std::vector<SliceIndex> own;
    std::copy_if(moving.begin(), moving.end(), std::back_inserter(own),
                 [&](SliceIndex slice) { return distribution.owns(slice); });
    pool.for_each(std::ssize(own), [&](std::int64_t index, int) {
      const SliceIndex slice = own[static_cast<std::size_t>(index)];
      HeldSlice& moved = held_slice(slice);
      visit(slice, moved.changes[parity()]);
      carry_out(moved.changes[parity()], moved.places);
    });
    std::vector<SliceSwaps> told;
    for (const SliceIndex slice : own) {
      const Changes& changes = held_slice(slice).changes[parity()];
      const std::size_t picks = std::max(changes.on.size(), changes.off.size());
      if (progress.phase == ConstructPhase::relax) num_swaps += static_cast<std::int64_t>(picks);
      picks_done += static_cast<std::int64_t>(picks);
      SliceSwaps& message = told.emplace_back();
      message.slice = slice;
      if (halo.listeners(slice).empty()) continue;
      for (std::size_t k = 0; k < picks; ++k) {
        message.swaps.push_back(
            {k < changes.off.size() ? changes.off[k] : no_cell, k < changes.on.size() ? changes.on[k] : no_cell});
      }
    }
    exchange.begin(moving, told);
    exchange.wait([&](SliceIndex slice, std::span<const Swap> swaps) {
      HeldSlice& moved = held_slice(slice);
      Changes& changes = moved.changes[parity()];
      changes = {};
      for (const Swap& swap : swaps) {
        if (swap.a != no_cell) changes.off.push_back(swap.a);
        if (swap.b != no_cell) changes.on.push_back(swap.b);
      }
      carry_out(changes, moved.places);
    });
  }

  void advance() {
    if (done()) return;
    num_swaps = 0;
    for (const std::vector<SliceIndex>& moving : classes) move(moving);
    ++total_rounds;
    ++progress.rounds;
    switch (progress.phase) {
      case ConstructPhase::relax: {
        communicator.sum(std::span(&num_swaps, 1));
        progress.num_swaps += num_swaps;
        const std::int64_t most_rounds = most_swaps_per_point * progress.num_start_points / points + 1;
        if (num_swaps == 0 || progress.rounds >= most_rounds) enter(ConstructPhase::drain);
        break;
      }
      case ConstructPhase::drain:
        progress.num_placed = std::min(progress.num_placed + points, progress.num_start_points);
        break;
      default:
        progress.num_placed = std::min(progress.num_placed + points, cells);
    }
    skip_ended_phases();
  }

  void skip_ended_phases() {
    if (progress.phase == ConstructPhase::relax && progress.num_start_points == 0) enter(ConstructPhase::drain);
    if (progress.phase == ConstructPhase::drain && progress.num_placed == progress.num_start_points) {
      enter(ConstructPhase::fill);
    }
    if (progress.phase == ConstructPhase::fill && progress.num_placed == cells) enter(ConstructPhase::done);
  }

  const Extents extents;
  const ConstructSpec spec;
  const std::uint64_t seed;
  const std::int64_t cells;
  const std::int64_t points;
  const Communicator& communicator;
  ThreadPool& pool;
  StampKernel kernel;
  VacTieHash hash;
  std::vector<std::vector<SliceIndex>> classes;
  Distribution distribution;
  HaloPlan halo;
  HaloExchange exchange;
  std::vector<std::int32_t> class_of;  // of every slice
  std::vector<std::int32_t> held_at;   // where a slice stands in `held`, or -1
  std::vector<HeldSlice> held;
  IndexedVector<LocalSlice, PlaneField> fields;
  ConstructProgress progress;
  std::int64_t total_rounds = 0;  // since it was made: its parity says which changes are new
  std::int64_t num_swaps = 0;     // of the present round
  std::int64_t picks_done = 0;
};

SliceConstruction::SliceConstruction(const Footprint& overlap, const FilterSpec& filter, const ConstructSpec& spec,
                                     std::uint64_t seed, const Communicator& communicator, ThreadPool& pool)
    : impl_(std::make_unique<Impl>(overlap, filter, spec, seed, communicator, pool)) {}
SliceConstruction::~SliceConstruction() = default;

void SliceConstruction::start() { impl_->start(); }
void SliceConstruction::restore(const ConstructProgress& progress,
                                const std::function<std::vector<std::uint32_t>(SliceIndex)>& places) {
  impl_->restore(progress, places);
}
std::vector<SliceIndex> SliceConstruction::slices_held() const { return impl_->indices(); }
void SliceConstruction::advance() { impl_->advance(); }
const ConstructProgress& SliceConstruction::progress() const { return impl_->progress; }
const Distribution& SliceConstruction::distribution() const { return impl_->distribution; }
const std::vector<std::uint32_t>& SliceConstruction::places(SliceIndex slice) const {
  const std::int32_t at = impl_->held_at[static_cast<std::size_t>(slice)];
  NOISELOOM_CHECK(at >= 0);
  return impl_->held[static_cast<std::size_t>(at)].places;
}
bool SliceConstruction::couples_slices() const { return impl_->kernel.stamps().size() > 1; }
std::int64_t SliceConstruction::num_classes() const { return std::ssize(impl_->classes); }
std::int64_t SliceConstruction::points_per_visit() const { return impl_->points; }
std::int64_t SliceConstruction::picks_done() const { return impl_->picks_done; }
std::int64_t SliceConstruction::bytes_sent() const { return impl_->exchange.bytes_sent(); }
std::int64_t SliceConstruction::messages_sent() const { return impl_->exchange.messages_sent(); }

double SliceConstruction::fraction() const {
  const ConstructProgress& now = impl_->progress;
  const auto points = static_cast<double>(now.num_start_points);
  const double relax = 0.5 * points;  // in picks
  const double all = relax + 2 * points + (static_cast<double>(impl_->cells) - points);
  double done = 0;
  switch (now.phase) {
    case ConstructPhase::relax:
      done = std::min(relax, static_cast<double>(now.rounds * impl_->points));
      break;
    case ConstructPhase::drain:
      done = relax + static_cast<double>(now.num_placed);
      break;
    case ConstructPhase::fill:
      done = relax + points + static_cast<double>(now.num_placed);
      break;
    case ConstructPhase::done:
      return 1;
  }
  return done / all;
}

}  // namespace noiseloom
