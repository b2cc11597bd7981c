#include "noiseloom/construct/void_and_cluster.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "construct/order/vac_candidates.h"
#include "construct/order/vac_selection.h"
#include "construct/order/vac_start.h"
#include "construct/order/vac_swapper.h"
#include "construct/order/vac_windows.h"
#include "noiseloom/core/random.h"

namespace noiseloom {

void check_vac_spec(const VacSpec& spec) {
  std::vector<Fault> faults;
  const auto fault = [&](std::string text) { faults.push_back({"void and cluster", std::move(text)}); };
  if (spec.extents.num_axes() < 2) fault("the texture has no axes");
  if (spec.groups.empty()) fault("groups is empty: at least one group of axes is needed");
  for (std::size_t g = 0; g < spec.groups.size(); ++g) {
    const VacGroup& group = spec.groups[g];
    const std::string name = "groups[" + std::to_string(g) + "]";
    if (group.axes.empty()) fault(name + ".axes is empty");
    for (std::size_t i = 0; i < group.axes.size(); ++i) {
      const int axis = group.axes[i];
      if (axis < 0 || axis >= spec.extents.num_axes()) {
        fault(name + ".axes: there is no axis " + std::to_string(axis));
      }
      if (std::count(group.axes.begin(), group.axes.end(), axis) > 1) {
        fault(name + ".axes: axis " + std::to_string(axis) + " occurs more than once");
      }
    }
    for (const int axis : group.box_axes) {
      if (std::find(group.axes.begin(), group.axes.end(), axis) == group.axes.end()) {
        fault(name + ".box: axis " + std::to_string(axis) + " is none of the group's");
      }
    }
    if (!group.box_axes.empty() && group.box_size < 1) {
      fault(name + ".box_size = " + std::to_string(group.box_size) + ": must be at least 1");
    }
    for (const int axis : group.tile_axes) {
      if (std::find(group.axes.begin(), group.axes.end(), axis) == group.axes.end()) {
        fault(name + ".tiles: axis " + std::to_string(axis) + " is none of the group's");
      }
      if (axis < 2) fault(name + ".tiles: axis " + std::to_string(axis) + " is no slice axis");
      if (std::find(group.box_axes.begin(), group.box_axes.end(), axis) != group.box_axes.end()) {
        fault(name + ".tiles: axis " + std::to_string(axis) + " is a box axis too");
      }
    }
    if (!group.tile_axes.empty() && !(std::count(group.axes.begin(), group.axes.end(), 0) == 1 &&
                                      std::count(group.axes.begin(), group.axes.end(), 1) == 1)) {
      fault(name + ".tiles: the group must have x and y, whose edges the tiles share");
    }
    if (!(group.tail >= 0 && group.tail <= 1)) {
      fault(name + ".tail = " + std::to_string(group.tail) + ": must be between 0 and 1");
    }
    if (!(group.tail_power >= 0.5 && group.tail_power <= 16)) {
      fault(name + ".tail_power = " + std::to_string(group.tail_power) + ": must be between 0.5 and 16");
    }
    if (!(group.weight > 0 && group.weight <= 1)) {
      fault(name + ".weight = " + std::to_string(group.weight) + ": must be above 0 and at most 1");
    }
    if (!(group.sigma_px > 0 && group.sigma_px <= 1000)) {
      fault(name + ".sigma = " + std::to_string(group.sigma_px) + ": must be above 0 and at most 1000 pixels");
    }
  }
  if (!spec.toroidal.empty() && spec.toroidal.size() != static_cast<std::size_t>(spec.extents.num_axes())) {
    fault("toroidal has " + std::to_string(spec.toroidal.size()) + " values: must have one per axis, or none");
  }
  if (!(spec.density >= 0 && spec.density <= 0.5)) {
    fault("density = " + std::to_string(spec.density) + ": must be between 0 and 0.5");
  }
  throw_if_any(std::move(faults));
}

VacDivision vac_division(const VacSpec& spec, int ranks, int threads) {
  const std::int32_t slices = spec.extents.num_slices();
  const auto sizes = VacWindows::sizes(VacLayout(spec, 0, slices), VacKernel(spec), threads);
  if (sizes) return {sizes->bands, true};
  return {static_cast<int>(std::min(std::int64_t{ranks} * threads, std::int64_t{slices})), false};
}

VacTieHash::VacTieHash(std::uint64_t seed) {
  const RandomBlock block = random_block(seed, Purpose::tie, 0, 0, 0);
  key0_ = block[0];
  key1_ = block[1];
}

struct VoidAndCluster::Impl {
  Impl(const VacSpec& spec_in, const Communicator& communicator_in, ThreadPool& pool)
      : communicator(communicator_in),
        spec(spec_in),
        partition(spec.extents.num_slices(), communicator.size()),
        begin(partition.begin(communicator.rank())),
        end(partition.end(communicator.rank())),
        kernel(spec),
        hash(spec.seed),
        exchange(communicator),
        slices(spec, kernel, begin, end, pool),
        by_windows(exchange.sum(slices.windows() != nullptr ? 1 : 0) > 0),
        search(slices, exchange, hash),
        order(spec.extents, begin, end) {
    if (!by_windows) selection.emplace(spec, kernel, partition, communicator.rank().value(), exchange, pool);
  }

  void start() {
    order = VacOrder(spec.extents, begin, end);
    vac_turn_on_start(spec, exchange, order);
    progress = {.num_start_points = vac_num_start_points(spec)};
    enter_phase();
  }

  void restore(const VacProgress& from, const std::function<std::vector<std::byte>(SliceIndex)>& bytes) {
    communicator.together([&] {
      for (const SliceIndex slice : Distribution(partition, communicator.rank()).own_slices())
        order.set_bytes(slice, bytes(slice));
    });
    const OrderCensus census = order.census();
    std::int64_t num[] = {census.num_placed(), census.num_on()};
    communicator.sum(num);
    const bool filling = from.phase == VacPhase::fill || from.phase == VacPhase::done;
    const std::int64_t num_on = filling ? 0 : from.num_start_points - from.num_placed;
    if (num[0] != from.num_placed || num[1] != num_on || from.num_start_points != vac_num_start_points(spec) ||
        (filling && from.num_placed < from.num_start_points) || (from.phase == VacPhase::swap && from.num_placed > 0)) {
      throw SharedUserError("", "void and cluster: the order has " + std::to_string(num[0]) + " ranked pixels and " +
                                    std::to_string(num[1]) + " that are on, which is not what its progress says");
    }
    progress = from;
    enter_phase();
  }

  // Brings the fields to what progress and order say.
  void enter_phase() {
    swapper.reset();
    batch = {};
    batch_of_windows = {};
    placed_before_batch = progress.num_placed;
    num_in_batch = 0;
    if (progress.phase == VacPhase::done) return;
    slices.clear();
    if (progress.phase != VacPhase::fill) {
      if (progress.num_start_points > 0) turn_on_where([&](std::uint64_t p) { return order.is_on(p); });
    } else if (progress.num_placed > 0) {
      turn_on_where([&](std::uint64_t p) { return order.has_place(p); });
    }
    if (progress.phase == VacPhase::swap) {
      swapper.emplace(slices, exchange, hash);
    } else {
      enter_picking();
    }
  }

  void enter_picking() {
    swapper.reset();
    if (slices.windows() != nullptr) slices.windows()->restart();
    search.refresh_bounds(progress.phase == VacPhase::fill ? VacView::voids : VacView::clusters);
  }

  // The pixels that are on travel as one bit for each pixel, and only so many at once that their positions take little
  // memory.
  template <class IsOn>
  void turn_on_where(const IsOn& is_on) {
    constexpr std::uint64_t chunk = std::uint64_t{1} << 20;
    const auto cells = static_cast<std::uint64_t>(spec.extents.cells_per_slice());
    const auto num_cells = static_cast<std::uint64_t>(spec.extents.num_cells());
    std::vector<std::uint64_t> positions;
    std::vector<std::byte> bits;
    for (std::uint64_t from = 0; from < num_cells; from += chunk) {
      const std::uint64_t to = std::min(from + chunk, num_cells);
      const auto first = std::clamp(order.begin(), from, to);
      const auto last = std::clamp(order.end(), from, to);
      bits.assign((last - first + 7) / 8, std::byte{0});
      for (std::uint64_t p = first; p < last; ++p) {
        if (is_on(p)) bits[(p - first) / 8] |= std::byte{1} << ((p - first) % 8);
      }
      const std::vector<std::byte> all = exchange.gather(std::span<const std::byte>(bits));
      positions.clear();
      std::size_t block = 0;
      for (int rank = 0; rank < partition.num_ranks(); ++rank) {
        const auto rank_first = std::clamp(cells * static_cast<std::uint64_t>(partition.begin(rank)), from, to);
        const auto rank_last = std::clamp(cells * static_cast<std::uint64_t>(partition.end(rank)), from, to);
        for (std::uint64_t p = rank_first; p < rank_last; ++p) {
          const std::uint64_t bit = p - rank_first;
          if ((all[block + bit / 8] >> (bit % 8) & std::byte{1}) != std::byte{0}) positions.push_back(p);
        }
        block += (rank_last - rank_first + 7) / 8;
      }
      slices.turn_on(positions);
    }
  }

  // One swap, or the end of the phase.
  void swap() {
    const auto swap = swapper->next();
    if (!swap) {
      progress.phase = VacPhase::drain;
      enter_picking();
      return;
    }
    if (order.has(swap->from)) order.set_off(swap->from);
    if (order.has(swap->to)) order.set_on(swap->to);
    ++progress.num_swaps;
  }

  // Up to `max_picks` picks of drain or fill; returns how many.
  std::int64_t pick(std::int64_t max_picks) {
    const bool filling = progress.phase == VacPhase::fill;
    const VacView view = filling ? VacView::voids : VacView::clusters;
    const auto most = static_cast<std::size_t>(std::min(max_picks, batch_limit));
    if (by_windows) return pick_by_windows(view, most);
    if (batch.positions.empty()) {
      const std::uint64_t limit = search.find(view, open_fraction(), candidates);

      selection->take(view, candidates, limit, most, batch);
      placed_before_batch = progress.num_placed;
    }
    const bool is_last = batch.positions.size() <= most;
    VacPortion picks = is_last ? std::exchange(batch, {}) : first_of_batch(most);
    const auto turned = [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) set_place(picks.positions[i], picks.numbers[i]);
    };
    const auto then = is_last ? search.scan_ahead(view, open_fraction()) : std::nullopt;
    slices.turn_batch(filling, picks, turned, is_last, then ? &*then : nullptr);
    const auto count = static_cast<std::int64_t>(picks.positions.size());
    progress.num_placed += count;
    return count;
  }

  // The same where one rank goes through windows of the only slice. The field is as far as the whole batch.
  std::int64_t pick_by_windows(VacView view, std::size_t most) {
    if (placed_before_batch + num_in_batch == progress.num_placed) {
      if (slices.windows() != nullptr) batch_of_windows = slices.windows()->take(view);
      num_in_batch = exchange.sum(static_cast<std::int64_t>(batch_of_windows.size()));
      placed_before_batch = progress.num_placed;
    }
    const std::int64_t first = progress.num_placed - placed_before_batch;
    const std::int64_t count = std::min(static_cast<std::int64_t>(most), num_in_batch - first);
    if (!batch_of_windows.empty()) {
      for (std::int64_t i = first; i < first + count; ++i) set_place(batch_of_windows[static_cast<std::size_t>(i)], i);
    }
    progress.num_placed += count;
    return count;
  }

  void set_place(std::uint64_t position, std::int64_t number_in_batch) {
    const std::int64_t placed = placed_before_batch + number_in_batch;
    const auto place = progress.phase == VacPhase::fill ? placed : progress.num_start_points - 1 - placed;
    order.set_place(position, static_cast<std::uint64_t>(place));
  }

  // Takes the next `count` picks out of the batch.
  VacPortion first_of_batch(std::size_t count) {
    const auto behind = static_cast<std::size_t>(progress.num_placed - placed_before_batch) + count;
    VacPortion first;
    VacPortion rest;
    for (std::size_t i = 0; i < batch.positions.size(); ++i) {
      VacPortion& to = batch.numbers[i] < behind ? first : rest;
      to.positions.push_back(batch.positions[i]);
      to.numbers.push_back(batch.numbers[i]);
    }
    batch = std::move(rest);
    return first;
  }

  void advance(std::int64_t max_picks) {
    while (max_picks > 0 && progress.phase != VacPhase::done) {
      if (progress.phase == VacPhase::swap) {
        if (progress.num_start_points > 0) {
          swap();
          --max_picks;
        } else {
          progress.phase = VacPhase::drain;
        }
      } else if (progress.phase == VacPhase::drain && progress.num_placed == progress.num_start_points) {
        progress.phase = VacPhase::fill;
        enter_phase();
      } else if (progress.num_placed == spec.extents.num_cells()) {
        progress.phase = VacPhase::done;
      } else {
        max_picks -= pick(max_picks);
      }
    }
    if (progress.num_placed == spec.extents.num_cells()) progress.phase = VacPhase::done;
  }

  // The share of the leaves that a batch may open: more picks a batch, but more candidates that are raised and not
  // picked. Planes along slice axes want large batches, whose picks share the lines that they write to.
  double open_fraction() const {
    const bool has_far_plane = std::any_of(kernel.groups().begin(), kernel.groups().end(),
                                           [](const auto& group) { return group.axis0 != 0 && !group.others.empty(); });
    return has_far_plane ? 0.4 : 0.25;
  }

  const Communicator& communicator;
  VacSpec spec;
  Partition partition;
  std::int32_t begin;
  std::int32_t end;
  VacKernel kernel;
  VacTieHash hash;
  VacExchange exchange;
  VacSlices slices;
  bool by_windows;
  VacSearch search;
  std::optional<VacSelection> selection;
  VacOrder order;
  VacProgress progress;
  std::int64_t batch_limit = std::numeric_limits<std::int64_t>::max();
  std::optional<VacSwapper> swapper;  // swap
  std::vector<VacCandidate> candidates;
  VacPortion batch;  // the picks that are left of it
  std::int64_t placed_before_batch = 0;
  // By windows: all of it, on the rank that has them, and how many they are.
  std::span<const std::uint64_t> batch_of_windows;
  std::int64_t num_in_batch = 0;
};

namespace {

const VacSpec& checked(const VacSpec& spec) {
  check_vac_spec(spec);
  return spec;
}

}  // namespace

VoidAndCluster::VoidAndCluster(const VacSpec& spec, const Communicator& communicator, ThreadPool& pool)
    : impl_(std::make_unique<Impl>(checked(spec), communicator, pool)) {}
VoidAndCluster::~VoidAndCluster() = default;

void VoidAndCluster::start() { impl_->start(); }

void VoidAndCluster::restore(const VacProgress& progress,
                             const std::function<std::vector<std::byte>(SliceIndex)>& order) {
  impl_->restore(progress, order);
}

void VoidAndCluster::limit_batches(std::int64_t max_picks) { impl_->batch_limit = max_picks; }
void VoidAndCluster::advance(std::int64_t max_picks) { impl_->advance(max_picks); }
const VacProgress& VoidAndCluster::progress() const { return impl_->progress; }
const Partition& VoidAndCluster::partition() const { return impl_->partition; }
OrderCodec VoidAndCluster::codec() const { return impl_->order.codec(); }
std::vector<std::byte> VoidAndCluster::order(SliceIndex slice) const { return impl_->order.bytes(slice); }
std::int64_t VoidAndCluster::collectives() const { return impl_->exchange.collectives(); }
std::int64_t VoidAndCluster::bytes_sent() const { return impl_->exchange.bytes(); }

}  // namespace noiseloom
