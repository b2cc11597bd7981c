#include "construct/order/vac_selection.h"

#include <algorithm>
#include <cstring>
#include <numeric>

#include "construct/fields/vac_sources.h"

namespace noiseloom {

VacSelection::VacSelection(const VacSpec& spec, const VacKernel& kernel, const Partition& partition, int rank,
                           VacExchange& exchange, ThreadPool& pool, std::size_t fewest)
    : exchange_(exchange), rank_(rank), fewest_(fewest), rest_(spec, kernel) {
  const VacLayout layout(spec, 0, spec.extents.num_slices());
  const auto cells = static_cast<std::uint64_t>(layout.cells);
  for (int r = 0; r <= partition.num_ranks(); ++r) {
    rank_positions_.push_back(cells * static_cast<std::uint64_t>(partition.begin(r)));
  }
  const Partition split(partition.count(rank), std::clamp(partition.count(rank), 1, pool.num_threads()));
  for (int i = 0; i <= split.num_ranks(); ++i) {
    part_positions_.push_back(rank_positions_[static_cast<std::size_t>(rank)] +
                              cells * static_cast<std::uint64_t>(split.begin(i)));
  }
  work_.emplace(pool, part_positions_.size() - 1);
  // Where a group reaches other slices pixel by pixel, nearly all would wait.
  if (!acts_by_slices(kernel) || (exchange.alone() && part_positions_.size() == 2)) return;
  for (std::size_t i = 1; i < part_positions_.size(); ++i) selectors_.emplace_back(spec, kernel);
}

bool VacSelection::divides(std::size_t num_candidates) const {
  return !selectors_.empty() && num_candidates >= fewest_;
}

void VacSelection::pick_among_own() {
  const auto begin_of = [&](std::uint64_t position) {
    return static_cast<std::size_t>(std::ranges::lower_bound(candidates_, position, {}, &VacCandidate::position) -
                                    candidates_.begin());
  };
  rank_begins_.clear();
  for (const std::uint64_t position : rank_positions_) rank_begins_.push_back(begin_of(position));
  work_->for_each([&](std::size_t i) {
    selectors_[i].begin(view_, candidates_, begin_of(part_positions_[i]), begin_of(part_positions_[i + 1]), limit_);
    selectors_[i].pick();
    for (const VacPick& pick : selectors_[i].picks()) number_[pick.index(view_)] = 0;
  });
  const auto is_picked = [&](std::size_t i) { return number_[i] != none; };
  std::size_t num_waiting = 0;
  for (const VacSelector& selector : selectors_) num_waiting += selector.waiting().size();
  constexpr std::size_t few = 64;  // takes less time than threads wait for each other
  if (num_waiting <= few) {
    for (VacSelector& selector : selectors_) selector.raise_waiting(is_picked);
  } else {
    work_->for_each([&](std::size_t i) { selectors_[i].raise_waiting(is_picked); });
  }
  for (const VacSelector& selector : selectors_) {
    waiting_.insert(waiting_.end(), selector.waiting().begin(), selector.waiting().end());
    add_list(selector.picks());
  }
}

void VacSelection::add_list(std::span<const VacPick> picks) {
  lists_.push_back(picks);
  num_picks_ += picks.size();
}

// Each rank gives two words for each of its candidates, so that no rank needs to be told how many there are: the picks
// in their order, then what waits, then nothing.
void VacSelection::exchange_picks() {
  constexpr std::uint32_t waits = 0x80000000U;
  struct Entry {
    std::uint32_t index;  // among the rank's candidates
    std::uint32_t energy;
  };
  std::vector<int> bytes_of_ranks;
  for (std::size_t r = 0; r + 1 < rank_begins_.size(); ++r) {
    bytes_of_ranks.push_back(narrow<int>((rank_begins_[r + 1] - rank_begins_[r]) * sizeof(Entry)));
  }
  const auto own = static_cast<std::size_t>(rank_);
  const auto entry = [&](const VacPick& pick) {
    return Entry{pick.index(view_) - static_cast<std::uint32_t>(rank_begins_[own]),
                 static_cast<std::uint32_t>(pick.key >> 32)};
  };
  std::vector<VacPick> picks;
  for (const auto& list : lists_) {
    const auto middle = static_cast<std::ptrdiff_t>(picks.size());
    picks.insert(picks.end(), list.begin(), list.end());
    std::inplace_merge(picks.begin(), picks.begin() + middle, picks.end());
  }
  std::vector<Entry> entries(rank_begins_[own + 1] - rank_begins_[own], Entry{none, 0});
  const auto end_of_picks = std::ranges::transform(picks, entries.begin(), entry).out;
  std::ranges::transform(waiting_, end_of_picks, [&](const VacPick& pick) {
    const Entry plain = entry(pick);
    return Entry{plain.index | waits, plain.energy};
  });
  const std::vector<std::byte> all = exchange_.gather(std::as_bytes(std::span<const Entry>(entries)), bytes_of_ranks);

  waiting_.clear();
  std::vector<std::size_t> ends;  // of those of a rank that wait
  picks_of_ranks_.resize(rank_begins_.size() - 1);
  for (std::size_t rank = 0; rank < picks_of_ranks_.size(); ++rank) {
    picks_of_ranks_[rank].clear();
    for (std::size_t n = rank_begins_[rank]; n < rank_begins_[rank + 1]; ++n) {
      Entry got{};
      std::memcpy(&got, all.data() + n * sizeof(Entry), sizeof(Entry));
      if (got.index == none) break;
      const auto index = static_cast<std::uint32_t>(rank_begins_[rank]) + (got.index & ~waits);
      const VacPick pick{VacCandidate{0, got.energy, candidates_[index].hash}.key(),
                         index ^ static_cast<std::uint32_t>(view_)};
      if ((got.index & waits) != 0) {
        waiting_.push_back(pick);
      } else if (rank != own) {
        picks_of_ranks_[rank].push_back(pick);
        number_[index] = 0;
      }
    }
    ends.push_back(waiting_.size());
    if (rank != own) add_list(picks_of_ranks_[rank]);
  }
  const auto is_picked = [&](std::size_t i) { return number_[i] != none; };
  for (std::size_t rank = 0, n = 0; rank < ends.size(); ++rank) {
    for (; n < ends[rank]; ++n) {
      selectors_.front().raise(waiting_[n], rank_begins_[rank], rank_begins_[rank + 1], is_picked);
    }
  }
}

void VacSelection::pick_what_waits() {
  candidates_of_rest_.clear();
  for (const VacPick& pick : waiting_) {
    VacCandidate candidate = candidates_[pick.index(view_)];
    candidate.energy = static_cast<std::uint32_t>(pick.key >> 32);
    if (candidate.key() <= limit_) candidates_of_rest_.push_back(candidate);
  }
  std::erase_if(waiting_, [&](const VacPick& pick) { return pick.key > limit_; });
  rest_.begin(view_, candidates_of_rest_, 0, candidates_of_rest_.size(), limit_);
  rest_.pick();
  picks_of_rest_ = rest_.picks();
  for (VacPick& pick : picks_of_rest_) pick.order = waiting_[pick.index(view_)].order;
  add_list(picks_of_rest_);
}

// The number of a pick is the number of picks that are less: in its own list and in the others. Those of other ranks'
// slices are not found out but where more than `most` are picked.
void VacSelection::number_picks(std::size_t most) {
  if (lists_.size() == 1) {
    for (std::uint32_t i = 0; i < lists_[0].size(); ++i) number_[lists_[0][i].index(view_)] = i;
    return;
  }
  const std::size_t num_pieces = part_positions_.size() - 1;
  work_->for_each([&](std::size_t piece) {
    std::vector<std::uint32_t> numbers;
    std::vector<std::uint32_t> less_of_other;
    for (std::size_t own = 0; own < lists_.size(); ++own) {
      const bool is_wanted = own < selectors_.size() || own + 1 == lists_.size() || num_picks_ > most;
      if (own % num_pieces != piece || !is_wanted) continue;
      const std::span<const VacPick> list = lists_[own];
      numbers.resize(list.size());
      std::iota(numbers.begin(), numbers.end(), 0U);
      for (std::size_t other = 0; other < lists_.size(); ++other) {
        const std::span<const VacPick> theirs = lists_[other];
        if (other == own || theirs.empty()) continue;
        // Both are gone through together, without branches that would be taken at random.
        less_of_other.assign(list.size(), static_cast<std::uint32_t>(theirs.size()));
        std::uint32_t less = 0;
        std::size_t i = 0;
        while (i < list.size() && less < theirs.size()) {
          const bool next_of_theirs = theirs[less] < list[i];
          less_of_other[i] = less;
          less += next_of_theirs ? 1 : 0;
          i += next_of_theirs ? 0 : 1;
        }
        if (i < list.size()) less_of_other[i] = less;
        for (i = 0; i < list.size(); ++i) numbers[i] += less_of_other[i];
      }
      for (std::size_t i = 0; i < list.size(); ++i) number_[list[i].index(view_)] = numbers[i];
    }
  });
}

void VacSelection::take(VacView view, std::span<const VacCandidate> candidates, std::uint64_t limit, std::size_t most,
                        VacPortion& picks) {
  view_ = view;
  limit_ = limit;
  candidates_ = candidates;
  waiting_.clear();
  lists_.clear();
  num_picks_ = 0;
  number_.assign(candidates.size(), none);
  if (divides(candidates.size())) {
    pick_among_own();
    if (!exchange_.alone()) exchange_picks();
    pick_what_waits();
  } else {
    rest_.begin(view, candidates, 0, candidates.size(), limit);
    rest_.pick();
    add_list(rest_.picks());
  }
  number_picks(most);

  // Without branches, which would be taken at random: what is not picked is overwritten by the next.
  picks.positions.resize(candidates.size());
  picks.numbers.resize(candidates.size());
  std::size_t count = 0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    picks.positions[count] = candidates[i].position;
    picks.numbers[count] = number_[i];
    count += number_[i] != none ? 1 : 0;
  }
  picks.positions.resize(count);
  picks.numbers.resize(count);
}

}  // namespace noiseloom
