#include "noiseloom/construct/slice_construction.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "construct/course.h"
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

// A slice that this rank owns, or that acts on one that it owns. What it did in its last two visits is kept until all
// others have taken it in.
struct HeldSlice {
  std::vector<std::uint32_t> places;  // [y][x], as SliceConstruction::places
  Changes changes[2];                 // by the parity of the round
};

}  // namespace

struct SliceConstruction::Impl {
  Impl(const Footprint& overlap, const FilterSpec& filter, SampleScale scale, const ConstructSpec& spec_in,
       std::uint64_t seed_in, const Communicator& communicator_in, ThreadPool& pool_in)
      : extents(overlap.extents()),
        spec(spec_in),
        seed(seed_in),
        cells(extents.cells_per_slice()),
        course(cells, scale),
        communicator(communicator_in),
        pool(pool_in),
        kernel(extents, filter, spec.sharpness, energy_bits(retiring())),
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
      own.emplace_back(kernel, hash, static_cast<std::uint64_t>(cells) * static_cast<std::uint64_t>(slice), retiring());
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

  // On a circle, pixels that have their place are on or off for good.
  Retiring retiring() const { return course.is_circular() ? Retiring::yes : Retiring::no; }

  // Brings the energies of all own slices to what is on.
  void compute_energies() {
    std::vector<std::vector<std::uint32_t>> on(held.size());
    pool.for_each(std::ssize(held), [&](std::int64_t index, int) {
      const auto k = static_cast<std::size_t>(index);
      const std::vector<std::uint32_t>& places = held[k].places;
      for (std::uint32_t cell = 0; cell < places.size(); ++cell) {
        if (Course::is_on(progress, places[cell])) on[k].push_back(cell);
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
      if (progress.phase == ConstructPhase::exchange) retire_placed(held_slice(slice).places, field);
    });
    watch();
  }
  static void retire_placed(const std::vector<std::uint32_t>& places, PlaneField& field) {
    for (std::uint32_t cell = 0; cell < places.size(); ++cell) {
      if (places[cell] < pixel_is_on) field.retire(cell);
    }
  }
  void watch() {
    for (PlaneField& field : fields) field.watch(turns_on(), turns_off());
  }
  bool turns_on() const { return progress.phase != ConstructPhase::drain; }
  bool turns_off() const { return progress.phase != ConstructPhase::spread && progress.phase != ConstructPhase::fill; }
  std::span<const SliceStamp> other_slices() const { return std::span(kernel.stamps()).subspan(1); }

  void enter(ConstructPhase phase) {
    progress.phase = phase;
    progress.rounds = 0;
    if (done()) return;
    course.is_circular() ? watch() : compute_energies();  // on a circle what is on stays on
  }

  void start() {
    progress = course.start(num_start_points(spec.density, cells));
    const std::int64_t num_drawn = course.is_circular() ? 0 : progress.num_start_points;
    const std::vector<SliceIndex> slices = indices();
    pool.for_each(std::ssize(slices), [&](std::int64_t index, int) {
      const auto k = static_cast<std::size_t>(index);
      std::vector<std::uint32_t>& places = held[k].places;
      std::fill(places.begin(), places.end(), pixel_is_off);
      for (const std::uint32_t cell : start_pattern(seed, slices[k], cells, num_drawn)) places[cell] = pixel_is_on;
    });
    compute_energies();
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
    if (progress.phase == ConstructPhase::exchange) return exchange_pixels(field, changes);
    for (std::int64_t left = course.picks_of_visit(progress); left > 0; --left) {
      std::uint32_t from = no_cell;
      if (turns_off()) {
        from = field.pick(VacView::clusters).value();
        field.turn_off(from);
        if (!relaxing) changes.off.push_back(from);
      }
      if (!turns_on()) continue;
      const std::uint32_t to = field.pick(VacView::voids).value();
      field.turn_on(to);
      if (from == to) return;  // no swap is left
      changes.on.push_back(to);
      if (relaxing) changes.off.push_back(from);
    }
  }

  // Where the number of pixels is odd, nothing is left to be turned off in the last step.
  void exchange_pixels(PlaneField& field, Changes& changes) const {
    for (std::int64_t left = course.picks_of_visit(progress); left > 0; --left) {
      if (const auto from = field.pick(VacView::clusters)) {
        field.retire(*from);
        field.turn_off(*from);
        changes.off.push_back(*from);
      }
      const std::uint32_t to = field.pick(VacView::voids).value();
      field.retire(to);
      field.turn_on(to);
      changes.on.push_back(to);
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
      course.carry_out(progress, moved.changes[parity()], moved.places);
    });
    std::vector<SliceSwaps> told;
    for (const SliceIndex slice : own) {
      const Changes& changes = held_slice(slice).changes[parity()];
      const std::size_t picks = std::max(changes.on.size(), changes.off.size());
      const bool relaxing = progress.phase == ConstructPhase::relax;
      if (relaxing) num_swaps += std::ssize(changes.on);
      picks_done += std::ssize(changes.on) + (relaxing ? 0 : std::ssize(changes.off));
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
      course.carry_out(progress, changes, moved.places);
    });
  }

  void advance() {
    if (done()) return;
    num_swaps = 0;
    for (const std::vector<SliceIndex>& moving : classes) move(moving);
    ++total_rounds;
    ++progress.rounds;
    if (progress.phase == ConstructPhase::relax) {
      communicator.sum(std::span(&num_swaps, 1));
      progress.num_swaps += num_swaps;
      if (num_swaps == 0 || progress.rounds >= course.most_rounds_of_relax(progress)) end_relaxing();
    } else {
      progress.num_placed = course.num_placed_after(progress);
    }
    skip_ended_phases();
  }

  void end_relaxing() { enter(course.is_circular() ? ConstructPhase::exchange : ConstructPhase::drain); }
  void skip_ended_phases() {
    const std::int64_t points = progress.num_start_points;
    if (progress.phase == ConstructPhase::spread && course.num_on(progress) == points) enter(ConstructPhase::relax);
    if (progress.phase == ConstructPhase::relax && points == 0) end_relaxing();
    if (progress.phase == ConstructPhase::drain && progress.num_placed == points) enter(ConstructPhase::fill);
    const bool filling = progress.phase == ConstructPhase::fill || progress.phase == ConstructPhase::exchange;
    if (filling && progress.num_placed == cells) enter(ConstructPhase::done);
  }

  const Extents extents;
  const ConstructSpec spec;
  const std::uint64_t seed;
  const std::int64_t cells;
  const Course course;
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

SliceConstruction::SliceConstruction(const Footprint& overlap, const FilterSpec& filter, SampleScale scale,
                                     const ConstructSpec& spec, std::uint64_t seed, const Communicator& communicator,
                                     ThreadPool& pool)
    : impl_(std::make_unique<Impl>(overlap, filter, scale, spec, seed, communicator, pool)) {}
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
std::int64_t SliceConstruction::points_per_visit() const { return impl_->course.points_per_visit(); }
std::int64_t SliceConstruction::picks_done() const { return impl_->picks_done; }
std::int64_t SliceConstruction::bytes_sent() const { return impl_->exchange.bytes_sent(); }
std::int64_t SliceConstruction::messages_sent() const { return impl_->exchange.messages_sent(); }

double SliceConstruction::fraction() const { return impl_->course.fraction(impl_->progress); }

}  // namespace noiseloom
