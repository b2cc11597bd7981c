#include "construct/strata_trades.h"

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

namespace noiseloom {
namespace {

// Pixels further apart have less to exchange (5: 0.1 % less R, twice the time).
constexpr std::int32_t exchange_reach = 3;
// Slices that hand pixels round together: of more, these are drawn anew each time.
constexpr std::size_t most_at_once = 16;

std::int64_t wrapped(std::int64_t at, std::int64_t size) { return (at % size + size) % size; }

}  // namespace

NeighbourExchange::NeighbourExchange(const StampKernel& kernel) {
  for (std::int32_t dy = -exchange_reach; dy <= exchange_reach; ++dy) {
    for (std::int32_t dx = -exchange_reach; dx <= exchange_reach; ++dx) {
      if (dx != 0 || dy != 0) neighbours_.push_back({dx, dy, 0});
    }
  }
  for (Neighbour& neighbour : neighbours_) {
    for (const StampRow& row : kernel.stamps()[0].rows) {
      if (row.dy != neighbour.dy || neighbour.dx < -row.lo || neighbour.dx > row.hi) continue;
      const std::uint32_t weight = kernel.weights()[row.first + static_cast<std::size_t>(neighbour.dx + row.lo)];
      neighbour.weight = static_cast<std::int32_t>(weight);
    }
  }
}

void NeighbourExchange::pass(StrataState& state) const {
  for (std::size_t stack = 0; stack < state.stacks().size(); ++stack) {
    for (std::uint32_t cell = 0; cell < state.cells(); ++cell) {
      if (state.holder(stack, cell) != StrataState::nobody) exchange(state, stack, cell);
    }
  }
}

void NeighbourExchange::exchange(StrataState& state, std::size_t stack, std::uint32_t p) const {
  const auto t = static_cast<std::size_t>(state.holder(stack, p));
  const std::int64_t width = state.extents().width();
  const std::int64_t height = state.extents().height();
  std::array<std::int64_t, 2 * exchange_reach + 1> columns;
  std::array<std::int64_t, 2 * exchange_reach + 1> rows;  // where they begin
  for (std::int32_t d = -exchange_reach; d <= exchange_reach; ++d) {
    const auto i = static_cast<std::size_t>(d + exchange_reach);
    columns[i] = wrapped(p % width + d, width);
    rows[i] = wrapped(p / width + d, height) * width;
  }
  const std::int64_t of_p = state.energy(t, p);
  const auto energy = [&](std::size_t slice, std::uint32_t cell) { return std::int64_t{state.energy(slice, cell)}; };
  std::int64_t least = 0;
  std::uint32_t q = p;
  for (const Neighbour& near : neighbours_) {
    const auto other = static_cast<std::uint32_t>(rows[static_cast<std::size_t>(near.dy + exchange_reach)] +
                                                  columns[static_cast<std::size_t>(near.dx + exchange_reach)]);
    if (other == p || !state.lacks(t, other)) continue;
    std::int64_t change = energy(t, other) - of_p - near.weight;
    if (const std::int32_t holder = state.holder(stack, other); holder != StrataState::nobody) {
      const auto u = static_cast<std::size_t>(holder);
      if (!state.lacks(u, p)) continue;
      change += energy(u, p) - energy(u, other) - near.weight;
    }
    if (change >= least) continue;
    least = change;
    q = other;
  }
  if (q == p) return;
  const std::int32_t holder = state.holder(stack, q);
  const std::uint32_t place = state.place(t, p);
  state.empty(t, p);
  if (holder == StrataState::nobody) {
    state.free(t, p);
    return state.fill_open(t, q, place);
  }
  const auto u = static_cast<std::size_t>(holder);
  const std::uint32_t place_of_q = state.place(u, q);
  state.close(t, p);
  state.empty(u, q);
  state.close(u, q);
  state.fill_closed(t, q, place);
  state.fill_closed(u, p, place_of_q);
}

namespace {

// The rounds of some slices of a stack: a graph, in which the weight from one slice to another is what it costs least
// that the other has a pixel of it. A round that lowers the energies is a cycle of negative weight.
class Rounds {
 public:
  Rounds(StrataState& state, std::span<const std::size_t> slices, const std::vector<std::vector<std::uint32_t>>& held)
      : state_(state), slices_(slices), size_(slices.size()), offers_(size_ * size_) {
    for (const std::size_t slice : slices) held_.push_back(held[slice]);
    for (std::size_t from = 0; from < size_; ++from) {
      for (std::size_t to = 0; to < size_; ++to) look(from, to);
    }
  }

  void hand_round() {
    while (const auto round = find()) {
      if (carry_out(*round)) {
        for (const std::size_t i : *round) look_around(i);
      } else {  // pixels that act on each other gain less than the sum of offers
        offers_[(*round)[0] * size_ + (*round)[1]].cost = never;
      }
    }
  }

 private:
  struct Offer {
    std::int64_t cost = 0;
    std::size_t at = 0;  // in what the slice holds
  };
  static constexpr std::int64_t never = std::int64_t{1} << 40;  // more than all offers of a round can save
  using Round = std::vector<std::size_t>;                       // each gives to the next, the last one to the first

  std::size_t slice(std::size_t i) const { return slices_[i]; }

  void look(std::size_t from, std::size_t to) {
    if (from == to) return;
    Offer best{never, 0};
    for (std::size_t at = 0; at < held_[from].size(); ++at) {
      const std::uint32_t cell = held_[from][at];
      const std::int64_t cost = state_.cost_of_handing(cell, slice(from), slice(to));
      if (cost < best.cost) best = {cost, at};
    }
    offers_[from * size_ + to] = best;
  }
  void look_around(std::size_t i) {
    for (std::size_t other = 0; other < size_; ++other) {
      look(i, other);
      look(other, i);
    }
  }

  // A cycle of negative weight, where there is one (Bellman and Ford).
  std::optional<Round> find() const {
    std::vector<std::int64_t> distance(size_, 0);
    std::vector<std::size_t> before(size_, 0);
    std::size_t changed = 0;  // size_: nothing
    for (std::size_t k = 0; k < size_ && changed < size_; ++k) {
      changed = size_;
      for (std::size_t from = 0; from < size_; ++from) {
        for (std::size_t to = 0; to < size_; ++to) {
          if (from == to || distance[from] + offers_[from * size_ + to].cost >= distance[to]) continue;
          distance[to] = distance[from] + offers_[from * size_ + to].cost;
          before[to] = from;
          changed = to;
        }
      }
    }
    if (changed == size_) return std::nullopt;
    std::size_t at = changed;
    for (std::size_t k = 0; k < size_; ++k) at = before[at];  // on the cycle by then
    Round round = {at};
    for (std::size_t i = before[at]; i != at; i = before[i]) round.push_back(i);
    std::reverse(round.begin(), round.end());
    return round;
  }

  // Whether it was worth it; else all is as it was. Pixels are taken out and put in one after the other, so that how
  // they act on each other counts.
  bool carry_out(const Round& round) {
    const std::size_t n = round.size();
    std::vector<std::size_t> at(n);
    std::vector<std::uint32_t> cells(n);
    std::vector<std::uint32_t> places(n);
    std::int64_t change = 0;
    for (std::size_t k = 0; k < n; ++k) {
      at[k] = offers_[round[k] * size_ + round[(k + 1) % n]].at;
      cells[k] = held_[round[k]][at[k]];
      places[k] = state_.place(slice(round[k]), cells[k]);
      change -= take(round[k], cells[k]);
    }
    const auto cell_of = [&](std::size_t k, bool given) { return cells[given ? (k + n - 1) % n : k]; };
    for (std::size_t k = 0; k < n; ++k) change += give(round[k], cell_of(k, true), places[k]);
    const bool better = change < 0;
    for (std::size_t k = 0; k < n && !better; ++k) take(round[k], cell_of(k, true));
    for (std::size_t k = 0; k < n && !better; ++k) give(round[k], cell_of(k, false), places[k]);
    for (std::size_t k = 0; k < n; ++k) held_[round[k]][at[k]] = cell_of(k, better);
    return better;
  }
  // Both return the energy that goes (comes) with it.
  std::int64_t take(std::size_t i, std::uint32_t cell) {
    const std::int64_t energy = state_.energy(slice(i), cell);
    state_.empty(slice(i), cell);
    state_.close(slice(i), cell);
    return energy;
  }
  std::int64_t give(std::size_t i, std::uint32_t cell, std::uint32_t place) {
    const std::int64_t energy = state_.energy(slice(i), cell);
    state_.fill_closed(slice(i), cell, place);
    return energy;
  }

  StrataState& state_;
  std::span<const std::size_t> slices_;
  std::size_t size_;
  std::vector<std::vector<std::uint32_t>> held_;
  std::vector<Offer> offers_;
};

}  // namespace

void hand_round(StrataState& state, std::uint32_t moment) {
  std::vector<std::vector<std::uint32_t>> held(state.num_slices());
  for (std::size_t stack = 0; stack < state.stacks().size(); ++stack) {
    for (std::uint32_t cell = 0; cell < state.cells(); ++cell) {
      const std::int32_t holder = state.holder(stack, cell);
      if (holder != StrataState::nobody) held[static_cast<std::size_t>(holder)].push_back(cell);
    }
  }
  for (const std::vector<std::int32_t>& stack : state.stacks()) {
    std::vector<std::size_t> slices(stack.begin(), stack.end());
    if (slices.size() > most_at_once) {
      const auto tie = [&](std::size_t slice) { return state.tie_at(moment, slice); };
      std::sort(slices.begin(), slices.end(), [&](std::size_t a, std::size_t b) { return tie(a) < tie(b); });
    }
    for (std::size_t begin = 0; begin < slices.size(); begin += most_at_once) {
      Rounds(state, std::span(slices).subspan(begin, std::min(most_at_once, slices.size() - begin)), held).hand_round();
    }
  }
}

}  // namespace noiseloom
