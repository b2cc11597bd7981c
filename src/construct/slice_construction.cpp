#include "noiseloom/construct/slice_construction.h"

#include <algorithm>
#include <numeric>
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

// A visit picks this share of a slice. Finer visits gain little: R of 128x128x64, gauss 1.3435 x ema, is higher by ... at
constexpr std::int64_t cells_per_point = 1024;

// What relaxing may take at most, in picks for each point of the start pattern. About 0.4 are usual.
constexpr std::int64_t most_swaps_per_point = 4;

// In a message, where a pick turns nothing off or nothing on.
constexpr std::uint32_t no_cell = 0xFFFFFFFFU;

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
    const RandomBlock block =
        random_block(seed, Purpose::slice_pattern, static_cast<std::uint32_t>(slice), 0, draw);
    const std::uint64_t bits = (std::uint64_t{block[0]} << 32) | block[1];
    const auto cell = static_cast<std::uint32_t>(
        (static_cast<unsigned __int128>(bits) * static_cast<std::uint64_t>(cells)) >> 64);
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

// A slice that this rank holds. What it did in its last two visits is kept until all others have taken it in.
struct HeldSlice {
  Changes changes[2];  // by the parity of the round
};

}  // namespace

struct SliceConstruction::Impl {
  Impl(const Extents& extents_in, const FilterSpec& filter, const ConstructSpec& spec_in, std::uint64_t seed_in,
       const Communicator& communicator_in, ThreadPool& pool_in)
      : extents(extents_in),
        spec(spec_in),
        seed(seed_in),
        cells(extents.cells_per_slice()),
        points(std::max<std::int64_t>(1, cells / cells_per_point)),
        communicator(communicator_in),
        pool(pool_in),
        kernel(extents, filter, spec.sharpness),
        hash(seed),
        classes(colour_classes(Footprint(extents, filter))),
        partition(extents.num_slices(), communicator.size()),
        begin(partition.begin(communicator.rank())),
        end(partition.end(communicator.rank())),
        halo(extents, slice_offsets(kernel), partition, communicator.rank()),
        exchange(communicator, halo, partition),
        class_of(static_cast<std::size_t>(extents.num_slices())),
        held_at(static_cast<std::size_t>(extents.num_slices()), -1) {
    for (std::size_t c = 0; c < classes.size(); ++c) {
      for (const SliceIndex slice : classes[c]) class_of[static_cast<std::size_t>(slice)] = static_cast<std::int32_t>(c);
    }
    for (const SliceIndex slice : indices()) {
      held_at[static_cast<std::size_t>(slice)] = static_cast<std::int32_t>(held.size());
      held.emplace_back();
    }
    places.resize(static_cast<std::size_t>(end - begin));
    for (SliceIndex slice = begin; slice < end; ++slice) {
      fields.emplace_back(kernel, hash, static_cast<std::uint64_t>(cells) * static_cast<std::uint64_t>(slice));
      places[own_index(slice)].resize(static_cast<std::size_t>(cells));
    }
  }

  std::vector<SliceIndex> indices() const {
    std::vector<SliceIndex> slices(static_cast<std::size_t>(end - begin));
    std::iota(slices.begin(), slices.end(), begin);
    slices.insert(slices.end(), halo.needed().begin(), halo.needed().end());
    return slices;
  }
  bool owns(SliceIndex slice) const { return slice >= begin && slice < end; }
  std::size_t own_index(SliceIndex slice) const { return static_cast<std::size_t>(slice - begin); }
  HeldSlice& held_slice(SliceIndex slice) {
    return held[static_cast<std::size_t>(held_at[static_cast<std::size_t>(slice)])];
  }
  const Extents::SliceCoord opposite(const Extents::SliceCoord& offset) const {
    Extents::SliceCoord result{};
    std::transform(offset.begin(), offset.end(), result.begin(), [](std::int32_t d) { return -d; });
    return result;
  }

  // Brings the energies of all own slices to what is on; `on_of` gives the cells of any held slice.
  void compute_energies(const std::function<std::vector<std::uint32_t>(SliceIndex)>& on_of) {
    std::vector<std::vector<std::uint32_t>> on(held.size());
    const std::vector<SliceIndex> slices = indices();
    pool.for_each(std::ssize(slices), [&](std::int64_t index, int) {
      const auto k = static_cast<std::size_t>(index);
      on[k] = on_of(slices[k]);
    });
    pool.for_each(end - begin, [&](std::int64_t index, int) {
      const auto k = static_cast<std::size_t>(index);
      PlaneField& field = fields[k];
      field.clear();
      field.watch(false, false);
      for (const std::uint32_t cell : on[k]) field.turn_on(cell);
      for (std::size_t s = 1; s < kernel.stamps().size(); ++s) {
        const SliceStamp& stamp = kernel.stamps()[s];
        const SliceIndex from = extents.slice_at(begin + static_cast<SliceIndex>(index), opposite(stamp.offset));
        field.act(stamp, true, on[static_cast<std::size_t>(held_at[static_cast<std::size_t>(from)])]);
      }
    });
    for (HeldSlice& slice : held) slice = {};
  }

  void enter(ConstructPhase phase) {
    progress.phase = phase;
    progress.rounds = 0;
    watch();
  }
  void watch() {
    const bool relaxing = progress.phase == ConstructPhase::relax;
    for (PlaneField& field : fields) {
      field.watch(relaxing || progress.phase == ConstructPhase::fill,
                  relaxing || progress.phase == ConstructPhase::drain);
    }
  }

  void start() {
    progress = {.num_start_points = num_start_points(spec.density, cells)};
    for (SliceIndex slice = begin; slice < end; ++slice) {
      std::vector<std::uint32_t>& own = places[own_index(slice)];
      std::fill(own.begin(), own.end(), pixel_is_off);
      for (const std::uint32_t cell : start_pattern(seed, slice, cells, progress.num_start_points)) {
        own[cell] = pixel_is_on;
      }
    }
    compute_energies(
        [&](SliceIndex slice) { return start_pattern(seed, slice, cells, progress.num_start_points); });
    enter(ConstructPhase::relax);
    skip_ended_phases();
  }

  void restore(const ConstructProgress& from,
               const std::function<std::vector<std::uint32_t>(SliceIndex)>& places_of) {
    progress = from;
    for (SliceIndex slice = begin; slice < end; ++slice) places[own_index(slice)] = places_of(slice);
    const bool filling = progress.phase == ConstructPhase::fill;
    if (!done()) {
      compute_energies([&](SliceIndex slice) {
        const std::vector<std::uint32_t> entries = places_of(slice);
        std::vector<std::uint32_t> on;
        for (std::uint32_t cell = 0; cell < entries.size(); ++cell) {
          if (filling ? entries[cell] < pixel_is_on : entries[cell] == pixel_is_on) on.push_back(cell);
        }
        return on;
      });
    }
    watch();
  }
  bool done() const { return progress.phase == ConstructPhase::done; }

  // What others did since this slice was visited last: in this round if their class has moved in it, else in the one
  // before, which is what they did last.
  void take_in(SliceIndex slice) {
    PlaneField& field = fields[own_index(slice)];
    const std::int32_t own_class = class_of[static_cast<std::size_t>(slice)];
    for (std::size_t s = 1; s < kernel.stamps().size(); ++s) {
      const SliceStamp& stamp = kernel.stamps()[s];
      const SliceIndex from = extents.slice_at(slice, opposite(stamp.offset));
      const bool moved = class_of[static_cast<std::size_t>(from)] < own_class;
      const Changes& changes = held_slice(from).changes[(total_rounds + (moved ? 0 : 1)) % 2];
      field.act(stamp, false, changes.off);
      field.act(stamp, true, changes.on);
    }
  }

  void visit(SliceIndex slice, Changes& changes) {
    take_in(slice);
    PlaneField& field = fields[own_index(slice)];
    std::vector<std::uint32_t>& own = places[own_index(slice)];
    changes.off.clear();
    changes.on.clear();
    std::int64_t place = progress.num_placed;
    for (std::int64_t k = 0; k < points; ++k) {
      if (progress.phase == ConstructPhase::relax) {
        const std::uint32_t from = field.pick(VacView::clusters).value();
        field.turn_off(from);
        const std::uint32_t to = field.pick(VacView::voids).value();
        field.turn_on(to);
        if (from == to) return;
        changes.off.push_back(from);
        changes.on.push_back(to);
        own[from] = pixel_is_off;
        own[to] = pixel_is_on;
      } else if (progress.phase == ConstructPhase::drain) {
        if (place == progress.num_start_points) return;
        const std::uint32_t cell = field.pick(VacView::clusters).value();
        field.turn_off(cell);
        changes.off.push_back(cell);
        own[cell] = static_cast<std::uint32_t>(progress.num_start_points - 1 - place);
        ++place;
      } else {
        if (place == cells) return;
        const std::uint32_t cell = field.pick(VacView::voids).value();
        field.turn_on(cell);
        changes.on.push_back(cell);
        own[cell] = static_cast<std::uint32_t>(place);
        ++place;
      }
    }
  }

  void move(const std::vector<SliceIndex>& moving) {
    std::vector<SliceIndex> own;
    std::copy_if(moving.begin(), moving.end(), std::back_inserter(own), [&](SliceIndex slice) { return owns(slice); });
    const auto parity = static_cast<std::size_t>(total_rounds % 2);
    pool.for_each(std::ssize(own), [&](std::int64_t index, int) {
      const SliceIndex slice = own[static_cast<std::size_t>(index)];
      visit(slice, held_slice(slice).changes[parity]);
    });
    std::vector<SliceSwaps> told;
    for (const SliceIndex slice : own) {
      const Changes& changes = held_slice(slice).changes[parity];
      num_swaps += progress.phase == ConstructPhase::relax ? std::ssize(changes.on) : 0;
      picks_done += static_cast<std::int64_t>(std::max(changes.on.size(), changes.off.size()));
      SliceSwaps& message = told.emplace_back();
      message.slice = slice;
      for (std::size_t k = 0; k < std::max(changes.on.size(), changes.off.size()); ++k) {
        message.swaps.push_back({k < changes.off.size() ? changes.off[k] : no_cell,
                                 k < changes.on.size() ? changes.on[k] : no_cell});
      }
    }
    exchange.begin(moving, told);
    exchange.wait([&](SliceIndex slice, std::span<const Swap> swaps) {
      Changes& changes = held_slice(slice).changes[parity];
      changes = {};
      for (const Swap& swap : swaps) {
        if (swap.a != no_cell) changes.off.push_back(swap.a);
        if (swap.b != no_cell) changes.on.push_back(swap.b);
      }
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
        if (num_swaps == 0 || progress.rounds == most_rounds) enter(ConstructPhase::drain);
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
    if (progress.phase == ConstructPhase::drain && progress.num_placed == progress.num_start_points) begin_filling();
    if (progress.phase == ConstructPhase::fill && progress.num_placed == cells) enter(ConstructPhase::done);
  }

  // The pattern is what has a place now; of other ranks' slices their last changes tell nothing, so it travels.
  void begin_filling() {
    share_pattern();
    enter(ConstructPhase::fill);
  }
  void share_pattern();

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
  Partition partition;
  SliceIndex begin;
  SliceIndex end;
  HaloPlan halo;
  HaloExchange exchange;
  std::vector<std::int32_t> class_of;  // of every slice
  std::vector<std::int32_t> held_at;   // where a slice stands in `held`, or -1
  std::vector<HeldSlice> held;
  std::vector<PlaneField> fields;                  // of own slices
  std::vector<std::vector<std::uint32_t>> places;  // of own slices
  ConstructProgress progress;
  std::int64_t total_rounds = 0;  // since it was made: its parity says which changes are new
  std::int64_t num_swaps = 0;     // of the present round
  std::int64_t picks_done = 0;
};

// Every rank tells the pattern of its slices in the way in which it tells picks, all slices at once.
void SliceConstruction::Impl::share_pattern() {
  const auto pattern_of = [&](SliceIndex slice) {
    std::vector<std::uint32_t> on;
    const std::vector<std::uint32_t>& own = places[own_index(slice)];
    for (std::uint32_t cell = 0; cell < own.size(); ++cell) {
      if (own[cell] < pixel_is_on) on.push_back(cell);
    }
    return on;
  };
  std::vector<SliceIndex> all(static_cast<std::size_t>(extents.num_slices()));
  std::iota(all.begin(), all.end(), 0);
  std::vector<SliceSwaps> told;
  for (SliceIndex slice = begin; slice < end; ++slice) {
    SliceSwaps& message = told.emplace_back();
    message.slice = slice;
    for (const std::uint32_t cell : pattern_of(slice)) message.swaps.push_back({no_cell, cell});
  }
  std::vector<std::vector<std::uint32_t>> heard(held.size());
  exchange.begin(all, told);
  exchange.wait([&](SliceIndex slice, std::span<const Swap> swaps) {
    auto& cells_on = heard[static_cast<std::size_t>(held_at[static_cast<std::size_t>(slice)])];
    for (const Swap& swap : swaps) cells_on.push_back(swap.b);
  });
  compute_energies([&](SliceIndex slice) {
    return owns(slice) ? pattern_of(slice)
                       : std::move(heard[static_cast<std::size_t>(held_at[static_cast<std::size_t>(slice)])]);
  });
}

SliceConstruction::SliceConstruction(const Extents& extents, const FilterSpec& filter, const ConstructSpec& spec,
                                     std::uint64_t seed, const Communicator& communicator, ThreadPool& pool)
    : impl_(std::make_unique<Impl>(extents, filter, spec, seed, communicator, pool)) {}
SliceConstruction::~SliceConstruction() = default;

void SliceConstruction::start() { impl_->start(); }
void SliceConstruction::restore(const ConstructProgress& progress,
                                const std::function<std::vector<std::uint32_t>(SliceIndex)>& places) {
  impl_->restore(progress, places);
}
std::vector<SliceIndex> SliceConstruction::slices_held() const { return impl_->indices(); }
void SliceConstruction::advance() { impl_->advance(); }
const ConstructProgress& SliceConstruction::progress() const { return impl_->progress; }
const Partition& SliceConstruction::partition() const { return impl_->partition; }
const std::vector<std::uint32_t>& SliceConstruction::places(SliceIndex slice) const {
  NOISELOOM_CHECK(impl_->owns(slice));
  return impl_->places[impl_->own_index(slice)];
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

bool is_sound(const ConstructProgress& progress, std::span<const std::uint32_t> places) {
  const auto cells = std::ssize(places);
  std::int64_t first = 0;  // the places that are given: first, ..., last - 1
  std::int64_t last = progress.num_placed;
  std::int64_t on = 0;
  switch (progress.phase) {
    case ConstructPhase::relax:
      on = progress.num_start_points;
      last = 0;
      break;
    case ConstructPhase::drain:
      last = progress.num_start_points;
      first = last - progress.num_placed;
      on = first;
      break;
    case ConstructPhase::fill:
      break;
    case ConstructPhase::done:
      last = cells;
      break;
  }
  if (first < 0 || first > last || last > cells || on < 0) return false;
  std::vector<bool> seen(places.size());
  std::int64_t found = 0;
  for (const std::uint32_t entry : places) {
    if (entry == pixel_is_on) --on;
    if (entry >= pixel_is_on) continue;
    if (static_cast<std::int64_t>(entry) < first || static_cast<std::int64_t>(entry) >= last || seen[entry]) return false;
    seen[entry] = true;
    ++found;
  }
  return on == 0 && found == last - first;
}

}  // namespace noiseloom
