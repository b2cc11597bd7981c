#include "noiseloom/construct/time_strata.h"

#include <algorithm>
#include <deque>
#include <queue>
#include <tuple>

#include "construct/plane_field.h"
#include "construct/stamp_kernel.h"
#include "noiseloom/construct/sharpness.h"
#include "noiseloom/construct/slice_construction.h"
#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

constexpr std::int32_t nobody = -1;
constexpr std::uint32_t energy_mask = (std::uint32_t{1} << energy_bits(Retiring::yes)) - 1;

// As construction has it: so many picks of a slice at a visit, which others take in at once.
constexpr std::size_t points_per_visit = 8;
// Measured on 64x64x16, R with gauss 1.0 and box 5: 0.1052 0.0950 without any exchange, 0.1029 0.0922 with exchanges
// at the end of every stratum, 0.1017 0.0891 with those at sixteen moments of it too (and 0.0891 0.0765 where slices
// alone are stratified).
constexpr std::size_t moments_of_stratum = 16;
constexpr int passes_at_end = 4;
// Pixels further apart have less to exchange (5: 0.1 % less R, twice the time).
constexpr std::int32_t exchange_reach = 3;

struct Neighbour {
  std::int32_t dx;
  std::int32_t dy;
  std::int64_t weight;
};

std::vector<Neighbour> neighbours_of(const StampKernel& kernel) {
  std::vector<Neighbour> neighbours;
  for (std::int32_t dy = -exchange_reach; dy <= exchange_reach; ++dy) {
    for (std::int32_t dx = -exchange_reach; dx <= exchange_reach; ++dx) {
      if (dx != 0 || dy != 0) neighbours.push_back({dx, dy, 0});
    }
  }
  for (Neighbour& neighbour : neighbours) {
    for (const StampRow& row : kernel.stamps()[0].rows) {
      if (row.dy != neighbour.dy || neighbour.dx < -row.lo || neighbour.dx > row.hi) continue;
      const std::uint32_t weight = kernel.weights()[row.first + static_cast<std::size_t>(neighbour.dx + row.lo)];
      neighbour.weight = static_cast<std::int32_t>(weight);
    }
  }
  return neighbours;
}

std::int32_t wrapped(std::int64_t at, std::int64_t size) {
  return static_cast<std::int32_t>((at % size + size) % size);
}

class TimeStrata {
 public:
  TimeStrata(const Extents& extents, const FilterSpec& filter, int axis, double sharpness, std::uint64_t seed)
      : extents_(extents),
        cells_(narrow<std::uint32_t>(extents.cells_per_slice())),
        kernel_(extents, filter, sharpness, energy_bits(Retiring::yes)),
        hash_(seed),
        neighbours_(neighbours_of(kernel_)),
        places_(static_cast<std::size_t>(extents.num_slices()), std::vector<std::uint32_t>(cells_, pixel_is_off)),
        stack_of_(places_.size()) {
    for (SliceIndex slice = 0; slice < extents.num_slices(); ++slice) {
      const auto s = static_cast<std::size_t>(slice);
      fields_.emplace_back(kernel_, hash_, first_position(s), Retiring::yes);
      fields_.back().clear();
      fields_.back().watch(true, false);
      Extents::SliceCoord first = extents.slice_coord(slice);
      first[static_cast<std::size_t>(axis - 2)] = 0;
      const auto of_first = static_cast<std::size_t>(extents.slice_index(first));
      if (of_first == s) stacks_.emplace_back();
      stack_of_[s] = of_first == s ? stacks_.size() - 1 : stack_of_[of_first];
      stacks_[stack_of_[s]].push_back(static_cast<std::int32_t>(slice));
    }
    filled_in_.resize(stacks_.size() * cells_);
  }

  std::vector<std::vector<std::uint32_t>> make() {
    const std::size_t num_strata = stacks_[0].size();
    const std::size_t of_stratum = cells_ / num_strata;
    for (std::size_t stratum = 0; stratum < num_strata; ++stratum) {
      std::fill(filled_in_.begin(), filled_in_.end(), nobody);
      for (PlaneField& field : fields_) field.open_all();
      // Of the last stratum every pixel has one slice left: nothing is to be exchanged.
      const bool exchanges = stratum + 1 < num_strata;
      for (std::size_t begin = 0; begin < of_stratum; begin += points_per_visit) {
        const std::size_t end = std::min(of_stratum, begin + points_per_visit);
        for (std::size_t slice = 0; slice < fields_.size(); ++slice) visit(slice, stratum * of_stratum, begin, end);
        const auto moment = [&](std::size_t k) { return k * moments_of_stratum / of_stratum; };
        if (exchanges && end < of_stratum && moment(begin) != moment(end)) exchange_all();
      }
      if (!exchanges) continue;
      for (int pass = 0; pass < passes_at_end; ++pass) exchange_all();
      order(static_cast<std::uint32_t>(stratum * of_stratum));
    }
    return std::move(places_);
  }

 private:
  std::uint64_t first_position(std::size_t slice) const { return std::uint64_t{cells_} * slice; }
  std::int32_t& filled_in(std::size_t slice, std::uint32_t cell) {
    return filled_in_[stack_of_[slice] * cells_ + cell];
  }
  const std::vector<std::int32_t>& stack(std::size_t slice) const { return stacks_[stack_of_[slice]]; }
  bool lacks(std::size_t slice, std::uint32_t cell) const { return places_[slice][cell] == pixel_is_off; }
  std::uint32_t energy(std::size_t slice, std::uint32_t cell) const { return fields_[slice].word(cell) & energy_mask; }

  // What is turned on (off) in a slice, as the others see it.
  void act(std::size_t slice, bool on, std::span<const std::uint32_t> cells) {
    for (const SliceStamp& stamp : std::span(kernel_.stamps()).subspan(1)) {
      const SliceIndex to = extents_.slice_at(static_cast<SliceIndex>(slice), stamp.offset);
      fields_[static_cast<std::size_t>(to)].act(stamp, on, cells);
    }
  }
  void act(std::size_t slice, bool on, std::uint32_t cell) { act(slice, on, std::span(&cell, 1)); }
  template <class Do>
  void for_others_that_lack(std::size_t slice, std::uint32_t cell, const Do& change) {
    for (const std::int32_t other : stack(slice)) {
      const auto o = static_cast<std::size_t>(other);
      if (o != slice && lacks(o, cell)) change(fields_[o]);
    }
  }

  // The places first_place + begin to first_place + end.
  void visit(std::size_t slice, std::size_t first_place, std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t> filled;
    for (std::size_t k = begin; k < end; ++k) {
      const auto place = static_cast<std::uint32_t>(first_place + k);
      if (const auto cell = fields_[slice].pick(VacView::voids)) {
        fill(slice, *cell, place);
        fields_[slice].turn_on(*cell);
        filled.push_back(*cell);
      } else {
        act(slice, true, filled);
        filled.clear();
        make_room(slice, place);
      }
    }
    act(slice, true, filled);
  }

  // A pixel that is open, and so is closed in the other slices of the stack; whoever calls turns it on.
  void fill(std::size_t slice, std::uint32_t cell, std::uint32_t place) {
    places_[slice][cell] = place;
    filled_in(slice, cell) = static_cast<std::int32_t>(slice);
    for_others_that_lack(slice, cell, [cell](PlaneField& field) { field.close(cell); });
  }

  // How a slice came to be asked for a pixel: by whom, and which one of its own the other would have.
  struct Asked {
    std::int32_t by = nobody;
    std::uint32_t for_cell = 0;
  };

  // For a slice without an open pixel. Slice after slice asks the others of the stack for pixels that they filled in
  // this stratum and that it lacks, until one is found that has an open pixel to fill instead.
  void make_room(std::size_t slice, std::uint32_t place) {
    constexpr std::uint32_t none = ~std::uint32_t{0};
    std::vector<Asked> asked(fields_.size());
    std::deque<std::size_t> queue = {slice};
    asked[slice].by = static_cast<std::int32_t>(slice);
    while (!queue.empty()) {
      const std::size_t asking = queue.front();
      queue.pop_front();
      // Of all pixels that another slice could give, that in the largest void of the asking slice.
      std::vector<std::uint32_t> least(fields_.size(), none);
      for (std::uint32_t cell = 0; cell < cells_; ++cell) {
        const std::int32_t holder = filled_in(slice, cell);
        if (holder == nobody || !lacks(asking, cell)) continue;
        const auto h = static_cast<std::size_t>(holder);
        if (asked[h].by != nobody || energy(asking, cell) >= least[h]) continue;
        least[h] = energy(asking, cell);
        asked[h].for_cell = cell;
      }
      for (const std::int32_t holder : stack(slice)) {
        const auto h = static_cast<std::size_t>(holder);
        if (asked[h].by != nobody || least[h] == none) continue;
        asked[h].by = static_cast<std::int32_t>(asking);
        if (const auto open = fields_[h].pick(VacView::voids)) return hand_on(h, *open, asked, slice, place);
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
      const std::uint32_t of_gives = places_[slice][gives];
      empty(slice, gives);
      fields_[slice].close(gives);  // the slice that it goes to fills it
      gets == open ? fill_open(slice, gets, of_gives) : fill_closed(slice, gets, of_gives);
      gets = gives;
    }
    fill_closed(first, gets, place);
  }

  void empty(std::size_t slice, std::uint32_t cell) {
    places_[slice][cell] = pixel_is_off;
    fields_[slice].turn_off(cell);
    act(slice, false, cell);
  }
  void fill_open(std::size_t slice, std::uint32_t cell, std::uint32_t place) {
    fill(slice, cell, place);
    fields_[slice].turn_on(cell);
    act(slice, true, cell);
  }
  // A pixel that another slice of the stack had filled, so that all others have it closed already.
  void fill_closed(std::size_t slice, std::uint32_t cell, std::uint32_t place) {
    places_[slice][cell] = place;
    filled_in(slice, cell) = static_cast<std::int32_t>(slice);
    fields_[slice].open(cell);
    fields_[slice].turn_on(cell);
    act(slice, true, cell);
  }

  // Every pixel of this stratum may change its slice with a neighbour where that lowers the energies of both slices
  // together, or leave it for a neighbour that no slice has filled yet. (How the two slices act on each other is left
  // out of the sum.)
  void exchange_all() {
    for (std::size_t stack = 0; stack < stacks_.size(); ++stack) {
      for (std::uint32_t cell = 0; cell < cells_; ++cell) {
        if (filled_in_[stack * cells_ + cell] != nobody) exchange(stack, cell);
      }
    }
  }
  void exchange(std::size_t stack, std::uint32_t p) {
    const std::int32_t* const holders = filled_in_.data() + stack * cells_;
    const auto t = static_cast<std::size_t>(holders[p]);
    const std::int64_t width = extents_.width();
    const std::int64_t x = p % width;
    const std::int64_t y = p / width;
    std::int64_t least = 0;
    std::uint32_t q = p;
    for (const Neighbour& near : neighbours_) {
      const auto other =
          static_cast<std::uint32_t>(wrapped(y + near.dy, extents_.height()) * width + wrapped(x + near.dx, width));
      if (other == p || !lacks(t, other)) continue;
      std::int64_t change = std::int64_t{energy(t, other)} - energy(t, p) - near.weight;
      if (holders[other] != nobody) {
        const auto u = static_cast<std::size_t>(holders[other]);
        if (!lacks(u, p)) continue;
        change += std::int64_t{energy(u, p)} - energy(u, other) - near.weight;
      }
      if (change >= least) continue;
      least = change;
      q = other;
    }
    if (q == p) return;
    const std::int32_t holder = holders[q];
    const std::uint32_t place = places_[t][p];
    empty(t, p);
    if (holder == nobody) {
      filled_in(t, p) = nobody;
      for_others_that_lack(t, p, [p](PlaneField& field) { field.reopen(p); });
      return fill_open(t, q, place);
    }
    const auto u = static_cast<std::size_t>(holder);
    const std::uint32_t place_of_q = places_[u][q];
    fields_[t].close(p);
    empty(u, q);
    fields_[u].close(q);
    fill_closed(t, q, place);
    fill_closed(u, p, place_of_q);
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
      return Entry{energy(slice, cell), hash_(first_position(slice) + cell), cell};
    };
    std::vector<std::vector<std::uint32_t>> filled(fields_.size());
    for (std::size_t stack = 0; stack < stacks_.size(); ++stack) {
      for (std::uint32_t cell = 0; cell < cells_; ++cell) {
        filled[static_cast<std::size_t>(filled_in_[stack * cells_ + cell])].push_back(cell);
      }
    }
    for (std::size_t slice = 0; slice < fields_.size(); ++slice) {
      for (const std::uint32_t cell : filled[slice]) fields_[slice].turn_off(cell);
      act(slice, false, filled[slice]);
    }
    std::vector<std::priority_queue<Entry>> queues(fields_.size());
    for (std::size_t slice = 0; slice < fields_.size(); ++slice) {
      for (const std::uint32_t cell : filled[slice]) queues[slice].push(entry(slice, cell));
    }
    for (std::size_t k = 0; k < filled[0].size(); ++k) {
      for (std::size_t slice = 0; slice < fields_.size(); ++slice) {
        // Energies have risen since they were noted, and more so further down.
        Entry top = queues[slice].top();
        for (queues[slice].pop(); top.energy != energy(slice, top.cell); queues[slice].pop()) {
          queues[slice].push(entry(slice, top.cell));
          top = queues[slice].top();
        }
        places_[slice][top.cell] = first_place + static_cast<std::uint32_t>(k);
        fields_[slice].turn_on(top.cell);
        act(slice, true, top.cell);
      }
    }
  }

  const Extents extents_;
  const std::uint32_t cells_;
  StampKernel kernel_;
  VacTieHash hash_;
  std::vector<Neighbour> neighbours_;
  std::vector<PlaneField> fields_;
  std::vector<std::vector<std::uint32_t>> places_;
  std::vector<std::vector<std::int32_t>> stacks_;  // slices that differ in the axis alone
  std::vector<std::size_t> stack_of_;
  std::vector<std::int32_t> filled_in_;  // of a stack and cell: the slice that filled it in this stratum
};

}  // namespace

std::vector<std::vector<std::uint32_t>> time_strata(const Extents& extents, const FilterSpec& filter, int axis,
                                                    double sharpness, std::uint64_t seed) {
  NOISELOOM_CHECK(axis >= 2 && fits_time_strata(extents, axis));
  if (sharpness == 0) sharpness = best_sharpness(try_sharpness(extents, filter));
  return TimeStrata(extents, filter, axis, sharpness, seed).make();
}

}  // namespace noiseloom
