#include "noiseloom/optimize/void_and_cluster.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "noiseloom/core/random.h"
#include "optimize/vac_candidates.h"
#include "optimize/vac_order.h"
#include "optimize/vac_selector.h"
#include "optimize/vac_swapper.h"

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

VacTieHash::VacTieHash(std::uint64_t seed) {
  const RandomBlock block = random_block(seed, Purpose::tie, 0, 0, 0);
  key0_ = block[0];
  key1_ = block[1];
}

std::vector<std::uint64_t> vac_start_pattern(const VacSpec& spec) {
  const auto num_cells = static_cast<std::uint64_t>(spec.extents.num_cells());
  const auto num_points = static_cast<std::size_t>(spec.density * static_cast<double>(num_cells));
  std::vector<bool> on(num_cells);
  std::vector<std::uint64_t> points;
  points.reserve(num_points);
  for (std::uint64_t draw = 0; points.size() < num_points; ++draw) {
    const RandomBlock block = random_block(spec.seed, Purpose::start_pattern, 0, 0, draw);
    const std::uint64_t bits = (std::uint64_t{block[0]} << 32) | block[1];
    const auto position = static_cast<std::uint64_t>((static_cast<unsigned __int128>(bits) * num_cells) >> 64);
    if (on[position]) continue;  // drawn before: a pixel is turned on once
    on[position] = true;
    points.push_back(position);
  }
  std::sort(points.begin(), points.end());
  return points;
}

struct VoidAndCluster::Impl {
  Impl(const VacSpec& spec_in, const Communicator& communicator_in)
      : communicator(communicator_in),
        spec(spec_in),
        partition(spec.extents.num_slices(), communicator.size()),
        kernel(spec),
        hash(spec.seed),
        field(spec, kernel, 0, spec.extents.num_slices()),
        selector(spec, kernel),
        swapper(field, hash),
        order(spec.extents, 0, spec.extents.num_slices()) {}

  // Ascending.
  template <class IsOn>
  std::vector<std::uint64_t> positions_where(const IsOn& is_on) const {
    std::vector<std::uint64_t> positions;
    for (std::uint64_t p = order.begin(); p < order.end(); ++p) {
      if (is_on(p)) positions.push_back(p);
    }
    return positions;
  }

  // Brings the field to what the state says.
  void enter_phase() {
    field.clear();
    if (state.phase == VacPhase::fill) {
      field.turn_on(positions_where([&](std::uint64_t p) { return order.has_rank(p); }));
      field.refresh_bounds(VacView::voids);
      return;
    }
    if (state.phase == VacPhase::done) return;
    field.turn_on(positions_where([&](std::uint64_t p) { return order.is_on(p); }));
    field.refresh_bounds(VacView::clusters);
  }

  void swap() {
    const auto swap = swapper.next();
    if (!swap) {
      state.phase = VacPhase::drain;
      field.refresh_bounds(VacView::clusters);
      return;
    }
    order.set_off(swap->from);
    order.set_on(swap->to);
    ++state.num_swaps;
  }

  // Up to `max_picks` picks of drain or fill; returns how many.
  std::int64_t pick(std::int64_t max_picks) {
    const bool filling = state.phase == VacPhase::fill;
    const VacView view = filling ? VacView::voids : VacView::clusters;
    const std::uint64_t limit = vac_find_candidates(field, view, hash, open_fraction(), max_candidates(), candidates);
    selector.select(view, candidates, limit, static_cast<std::size_t>(max_picks), picks);
    for (const std::uint32_t i : picks) {
      const auto rank = filling ? state.num_ranked : state.num_start_points - 1 - state.num_ranked;
      order.set_rank(candidates[i].position, static_cast<std::uint64_t>(rank));
      ++state.num_ranked;
    }
    picked.clear();
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (selector.picked(i)) {
        picked.push_back(candidates[i].position);
      } else {
        field.lower_bound_to(candidates[i].position, selector.energy(i));
      }
    }
    if (filling) {
      field.turn_on(picked);
    } else {
      field.turn_off(picked);
    }
    return static_cast<std::int64_t>(picks.size());
  }

  void advance(std::int64_t max_picks) {
    while (max_picks > 0 && state.phase != VacPhase::done) {
      if (state.phase == VacPhase::swap) {
        if (state.num_start_points > 0) {
          swap();
          --max_picks;
        } else {
          state.phase = VacPhase::drain;
        }
      } else if (state.phase == VacPhase::drain && state.num_ranked == state.num_start_points) {
        state.phase = VacPhase::fill;
        enter_phase();
      } else if (state.num_ranked == spec.extents.num_cells()) {
        state.phase = VacPhase::done;
      } else {
        max_picks -= pick(max_picks);
      }
    }
    if (state.num_ranked == spec.extents.num_cells()) state.phase = VacPhase::done;
  }

  std::size_t max_candidates() const { return std::max<std::size_t>(4096, field.bounds().size()); }

  // The share of the leaves that a batch may open: more picks a batch, but more candidates that are raised and not
  // picked. Planes along slice axes want large batches, whose picks share the lines that they write to.
  double open_fraction() const {
    const bool has_far_plane = std::any_of(kernel.groups().begin(), kernel.groups().end(),
                                           [](const auto& group) { return group.axis0 != 0 && !group.others.empty(); });
    return has_far_plane ? 0.4 : 0.1;
  }

  const Communicator& communicator;
  VacSpec spec;
  Partition partition;
  VacKernel kernel;
  VacTieHash hash;
  VacField field;
  VacSelector selector;
  VacSwapper swapper;
  VacProgress state;
  VacOrder order;
  std::vector<VacCandidate> candidates;
  std::vector<std::uint32_t> picks;
  std::vector<std::uint64_t> picked;
};

namespace {

const VacSpec& checked(const VacSpec& spec) {
  check_vac_spec(spec);
  return spec;
}

}  // namespace

VoidAndCluster::VoidAndCluster(const VacSpec& spec, const Communicator& communicator, ThreadPool&)
    : impl_(std::make_unique<Impl>(checked(spec), communicator)) {}
VoidAndCluster::~VoidAndCluster() = default;

void VoidAndCluster::start() {
  const auto points = vac_start_pattern(impl_->spec);
  impl_->state = {.num_start_points = static_cast<std::int64_t>(points.size())};
  for (std::uint64_t p = impl_->order.begin(); p < impl_->order.end(); ++p) impl_->order.set_off(p);
  for (const std::uint64_t position : points) impl_->order.set_on(position);
  impl_->enter_phase();
}

void VoidAndCluster::restore(const VacProgress& progress,
                             const std::function<std::vector<std::byte>(SliceIndex)>& order) {
  const int rank = impl_->communicator.rank();
  std::vector<std::byte> own;
  for (SliceIndex slice = impl_->partition.begin(rank); slice < impl_->partition.end(rank); ++slice) {
    const auto bytes = order(slice);
    own.insert(own.end(), bytes.begin(), bytes.end());
  }
  const auto all = impl_->communicator.gather_all(own);
  const std::size_t slice_bytes = all.size() / static_cast<std::size_t>(impl_->partition.num_slices());
  for (SliceIndex slice = 0; slice < impl_->partition.num_slices(); ++slice) {
    impl_->order.set_bytes(slice, std::span(all).subspan(static_cast<std::size_t>(slice) * slice_bytes, slice_bytes));
  }
  impl_->state = progress;
  impl_->enter_phase();
}

void VoidAndCluster::advance(std::int64_t max_picks) { impl_->advance(max_picks); }
const VacProgress& VoidAndCluster::progress() const { return impl_->state; }
const Partition& VoidAndCluster::partition() const { return impl_->partition; }
bool VoidAndCluster::wide() const { return impl_->order.wide(); }
std::vector<std::byte> VoidAndCluster::order(SliceIndex slice) const { return impl_->order.bytes(slice); }
std::int64_t VoidAndCluster::collectives() const { return 0; }
std::int64_t VoidAndCluster::bytes_sent() const { return 0; }

}  // namespace noiseloom
