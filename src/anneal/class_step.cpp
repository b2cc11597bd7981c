// One step: the slices of one colour class move at the same time.
#include <algorithm>
#include <numeric>
#include <utility>

#include "anneal/swap_optimizer_impl.h"
#include "noiseloom/anneal/cooling.h"

namespace noiseloom {

void SwapOptimizer::Impl::begin_sweep(double seconds) {
  if (optimizer.stop.time_s > 0) state.elapsed_s = communicator.broadcast(seconds);
  prepare_movers();
  const Heat heat = this->heat();
  state.temperature = state.mean_magnitude * temperature(heat);
  own_accepted = own_candidates = 0;
}

// In units of mean_magnitude.
double SwapOptimizer::Impl::temperature(const Heat& heat) const {
  const auto at = [](const TemperatureRange& range, double fraction) {
    return temperature_at(range.start, range.end, fraction);
  };
  const TemperatureRange whole = temperature_range(optimizer, energy_footprint, state.join);
  if (heat.cold) return at(cold_range(), heat.fraction);
  const bool colder = state.join > 0 && state.join < 1 &&
                      ends_colder(source.distance(), source.channels(), energy_footprint.couples_slices());
  if (!colder) return at(whole, heat.fraction);
  return at(joined_range(whole, state.join), (heat.fraction - state.join) / (1 - state.join));
}

SwapOptimizer::Impl::Heat SwapOptimizer::Impl::heat() const {
  const double fraction = moment().fraction;
  if (state.is_cold != 0) return {true, fraction};
  const double share = cooling_share(optimizer, energy_footprint.couples_slices());
  if (fraction < share) {
    const double exponent = cooling_exponent(optimizer, energy_footprint, movers.use_sieve(), state.join);
    return {false, joined_fraction(state.join, cooled(fraction / share, exponent))};
  }
  return {share < 1, share < 1 ? (fraction - share) / (1 - share) : 1};
}

// In the cold partners draw nearer than they do before it, and the other slices are seen as sharply as can be.
void SwapOptimizer::Impl::prepare_movers() {
  const Heat heat = this->heat();
  movers.prepare(heat.cold ? cold_step_fraction(heat.fraction) : heat.fraction, heat.cold ? 1 : heat.fraction);
}

VisitResult SwapOptimizer::Impl::visit(SliceIndex slice, int tile, int worker) {
  const auto sweep = narrow<std::uint32_t>(state.sweep);
  const Visit visit{slice,
                    sweep,
                    problem.seed,
                    schedule.iterations_before(state.sweep + 1) - schedule.iterations_before(state.sweep),
                    tile,
                    tiles.num_tiles(),
                    tiles.corner(problem.seed, slice, sweep, tile)};
  const double heat = optimizer.method == Method::fast ? state.fraction : state.temperature;
  return movers.visit(visit, heat, slices.field(slice), slices.permutation(slice), slices.fields(), worker);
}

bool SwapOptimizer::Impl::depends_on_others_swaps(SliceIndex slice) const {
  return std::any_of(energy_footprint.slices().begin(), energy_footprint.slices().end(), [&](const SliceTaps& taps) {
    return slices.is_behind(problem.extents.slice_at(slice, taps.offset));
  });
}

// Slices that wait for messages go last, so that the messages travel while the others move.
void SwapOptimizer::Impl::move(const std::vector<SliceIndex>& moving) {
  std::vector<SliceSwaps> own;
  for (const SliceIndex slice : moving) {
    if (slices.owns(slice)) own.push_back({slice, {}});
  }
  const std::int64_t num_tiles = tiles.num_tiles();
  std::vector<VisitResult> results(own.size() * static_cast<std::size_t>(num_tiles));
  std::vector<std::size_t> order(own.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto first_waiting = std::stable_partition(
      order.begin(), order.end(), [&](std::size_t k) { return !depends_on_others_swaps(own[k].slice); });
  const auto visit_all = [&](auto begin, auto end) {
    pool.for_each((end - begin) * num_tiles, [&](std::int64_t index, int worker) {
      const auto k = static_cast<std::int64_t>(*(begin + index / num_tiles));
      const std::int64_t tile = index % num_tiles;
      VisitResult& result = results[static_cast<std::size_t>(k * num_tiles + tile)];
      const SliceIndex slice = own[static_cast<std::size_t>(k)].slice;
      result = visit(slice, static_cast<int>(tile), worker);
      if (members_are_coupled) return;
      slices.carry_out(slice, result.swaps);  // while it is in the cache: nobody else looks there
      if (!slices.is_copied(slice)) movers.recycle(std::exchange(result.swaps, {}), worker);
    });
  };
  visit_all(order.begin(), first_waiting);
  slices.hear();
  visit_all(first_waiting, order.end());
  publish(own, results);
  slices.tell(moving, std::move(own));
}

// Carries out what is not yet, and lists what others are to hear of. The tiles of a slice have no cell in common.
void SwapOptimizer::Impl::publish(std::vector<SliceSwaps>& moved, std::vector<VisitResult>& results) {
  const auto num_tiles = static_cast<std::size_t>(tiles.num_tiles());
  if (members_are_coupled) {
    pool.for_each(std::ssize(results), [&](std::int64_t index, int) {
      const auto unit = static_cast<std::size_t>(index);
      slices.carry_out(moved[unit / num_tiles].slice, results[unit].swaps);
    });
  }
  for (std::size_t unit = 0; unit < results.size(); ++unit) {
    VisitResult& result = results[unit];
    std::vector<Swap>& swaps = moved[unit / num_tiles].swaps;
    if (swaps.empty()) swaps.swap(result.swaps);
    swaps.insert(swaps.end(), result.swaps.begin(), result.swaps.end());
    own_accepted += result.num_swaps;
    own_candidates += result.candidates;
  }
}

}  // namespace noiseloom
