#include "noiseloom/construct/time_strata.h"

#include <algorithm>
#include <deque>
#include <queue>
#include <tuple>

#include "construct/strata_trades.h"
#include "noiseloom/construct/sharpness.h"
#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

// As construction has it: so many picks of a slice at a visit, which others take in at once.
constexpr std::size_t points_per_visit = 2;
// At so many moments of a stratum, and so many times at its end, pixels change slices. Measured on 64x64x16, R with
// gauss 1.0 and box 5 (0.0891 and 0.0765 where slices alone are stratified): 0.1052 0.0950 without that, 0.1017 0.0876
// where neighbours alone are exchanged, at 16 moments; 0.1003 0.0874 where two slices trade pixels as well; 0.0998
// 0.0862 where any number of slices hand them round, at 64 moments. Rounds take the longer to find, the more slices
// there are. Annealing pixels among the slices, two or more slices at a time, from any temperature: nothing.
// Nor do strata that are complete (two pixels exchange two strata, in the one slice and in the other): of half a
// million such exchanges, each the best of the 17 that there are for a pixel, a slice and a stratum, 54 lowered the
// energy.
constexpr int passes_at_end = 4;
std::size_t moments_of_stratum(std::size_t num_strata) { return std::clamp<std::size_t>(1024 / num_strata, 1, 64); }

// Given which a slice alone would be best. Boxes, for which that is 1.1, have 1.6 % less R here with 1 (box 5,
// 64x64x16); gausses and binomials have the least R with what is best for a slice alone, or 0.1 below it, which differ
// by 0.5 %.
double sharpness_of_strata(double of_slice) { return of_slice < 1.15 ? 1 : of_slice; }

class TimeStrata {
 public:
  TimeStrata(const Extents& extents, const FilterSpec& filter, int axis, double sharpness, std::uint64_t seed)
      : state_(extents, filter, axis, sharpness, seed), neighbours_(state_.kernel()) {}

  std::vector<std::vector<std::uint32_t>> make(const std::function<bool()>& goes_on) {
    const std::size_t num_strata = state_.stacks()[0].size();
    const std::size_t of_stratum = state_.cells() / num_strata;
    const std::size_t moments = moments_of_stratum(num_strata);
    for (std::size_t stratum = 0; stratum < num_strata; ++stratum) {
      state_.begin_stratum();
      // Of the last stratum every pixel has one slice left: nothing is to be exchanged.
      const bool exchanges = stratum + 1 < num_strata;
      for (std::size_t begin = 0; begin < of_stratum; begin += points_per_visit) {
        const std::size_t end = std::min(of_stratum, begin + points_per_visit);
        if (!goes_on()) return {};
        for (std::size_t slice = 0; slice < state_.num_slices(); ++slice) {
          visit(slice, stratum * of_stratum, begin, end);
        }
        const auto moment = [&](std::size_t k) { return k * moments / of_stratum; };
        if (exchanges && end < of_stratum && moment(begin) != moment(end)) exchange();
      }
      if (!exchanges) continue;
      for (int pass = 0; pass < passes_at_end; ++pass) exchange();
      order(static_cast<std::uint32_t>(stratum * of_stratum));
    }
    return state_.take_places();
  }

 private:
  void exchange() {
    neighbours_.pass(state_);
    hand_round(state_, moment_++);
  }

  // The places first_place + begin to first_place + end.
  void visit(std::size_t slice, std::size_t first_place, std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t> filled;
    for (std::size_t k = begin; k < end; ++k) {
      const auto place = static_cast<std::uint32_t>(first_place + k);
      if (const auto cell = state_.field(slice).pick(VacView::voids)) {
        state_.fill(slice, *cell, place);
        state_.field(slice).turn_on(*cell);
        filled.push_back(*cell);
      } else {
        state_.act(slice, true, filled);
        filled.clear();
        make_room(slice, place);
      }
    }
    state_.act(slice, true, filled);
  }

  // How a slice came to be asked for a pixel: by whom, and which one of its own the other would have.
  struct Asked {
    std::int32_t by = StrataState::nobody;
    std::uint32_t for_cell = 0;
  };

  // For a slice without an open pixel. Slice after slice asks the others of the stack for pixels that they filled in
  // this stratum and that it lacks, until one is found that has an open pixel to fill instead.
  void make_room(std::size_t slice, std::uint32_t place) {
    constexpr std::uint32_t none = ~std::uint32_t{0};
    std::vector<Asked> asked(state_.num_slices());
    std::deque<std::size_t> queue = {slice};
    asked[slice].by = static_cast<std::int32_t>(slice);
    while (!queue.empty()) {
      const std::size_t asking = queue.front();
      queue.pop_front();
      // Of all pixels that another slice could give, that in the largest void of the asking slice.
      std::vector<std::uint32_t> least(state_.num_slices(), none);
      for (std::uint32_t cell = 0; cell < state_.cells(); ++cell) {
        const std::int32_t holder = state_.holder_beside(slice, cell);
        if (holder == StrataState::nobody || !state_.lacks(asking, cell)) continue;
        const auto h = static_cast<std::size_t>(holder);
        if (asked[h].by != StrataState::nobody || state_.energy(asking, cell) >= least[h]) continue;
        least[h] = state_.energy(asking, cell);
        asked[h].for_cell = cell;
      }
      for (const std::int32_t holder : state_.stack_of(slice)) {
        const auto h = static_cast<std::size_t>(holder);
        if (asked[h].by != StrataState::nobody || least[h] == none) continue;
        asked[h].by = static_cast<std::int32_t>(asking);
        if (const auto open = state_.field(h).pick(VacView::voids)) return hand_on(h, *open, asked, slice, place);
        queue.push_back(h);
      }
    }
    NOISELOOM_CHECK(false);  // of a bipartite graph of equal degrees there is a chain
  }

  // The last slice of a chain fills an open pixel in the place of the one that it gives, and so on to the first.
  void hand_on(std::size_t last, std::uint32_t open, const std::vector<Asked>& asked, std::size_t first,
               std::uint32_t place) {
    std::uint32_t gets = open;
    for (std::size_t slice = last; slice != first; slice = static_cast<std::size_t>(asked[slice].by)) {
      const std::uint32_t gives = asked[slice].for_cell;
      const std::uint32_t of_gives = state_.place(slice, gives);
      state_.empty(slice, gives);
      state_.close(slice, gives);  // the slice that it goes to fills it
      gets == open ? state_.fill_open(slice, gets, of_gives) : state_.fill_closed(slice, gets, of_gives);
      gets = gives;
    }
    state_.fill_closed(first, gets, place);
  }

  // Gives the pixels of this stratum their places anew, each time to the largest void of those that are left.
  void order(std::uint32_t first_place) {
    struct Entry {
      std::uint32_t energy;
      std::uint32_t hash;
      std::uint32_t cell;
      bool operator<(const Entry& o) const {  // the top of a queue is the largest
        return std::tie(energy, hash, cell) > std::tie(o.energy, o.hash, o.cell);
      }
    };
    const auto entry = [&](std::size_t slice, std::uint32_t cell) {
      return Entry{state_.energy(slice, cell), state_.tie(slice, cell), cell};
    };
    std::vector<std::vector<std::uint32_t>> filled(state_.num_slices());
    for (std::size_t stack = 0; stack < state_.stacks().size(); ++stack) {
      for (std::uint32_t cell = 0; cell < state_.cells(); ++cell) {
        filled[static_cast<std::size_t>(state_.holder(stack, cell))].push_back(cell);
      }
    }
    for (std::size_t slice = 0; slice < state_.num_slices(); ++slice) {
      for (const std::uint32_t cell : filled[slice]) state_.field(slice).turn_off(cell);
      state_.act(slice, false, filled[slice]);
    }
    std::vector<std::priority_queue<Entry>> queues(state_.num_slices());
    for (std::size_t slice = 0; slice < state_.num_slices(); ++slice) {
      for (const std::uint32_t cell : filled[slice]) queues[slice].push(entry(slice, cell));
    }
    for (std::size_t k = 0; k < filled[0].size(); ++k) {
      for (std::size_t slice = 0; slice < state_.num_slices(); ++slice) {
        // Energies have risen since they were noted, and more so further down.
        Entry top = queues[slice].top();
        for (queues[slice].pop(); top.energy != state_.energy(slice, top.cell); queues[slice].pop()) {
          queues[slice].push(entry(slice, top.cell));
          top = queues[slice].top();
        }
        state_.set_place(slice, top.cell, first_place + static_cast<std::uint32_t>(k));
        state_.field(slice).turn_on(top.cell);
        state_.act(slice, true, std::span(&top.cell, 1));
      }
    }
  }

  StrataState state_;
  NeighbourExchange neighbours_;
  std::uint32_t moment_ = 0;
};

}  // namespace

std::vector<std::vector<std::uint32_t>> time_strata(const Extents& extents, const FilterSpec& filter, int axis,
                                                    double sharpness, std::uint64_t seed,
                                                    const std::function<bool()>& goes_on) {
  NOISELOOM_CHECK(axis >= 2 && fits_time_strata(extents, axis));
  if (sharpness == 0) {
    sharpness = sharpness_of_strata(best_sharpness(try_sharpness(extents, filter, SampleScale::line, goes_on)));
  }
  return TimeStrata(extents, filter, axis, sharpness, seed).make(goes_on);
}

}  // namespace noiseloom
