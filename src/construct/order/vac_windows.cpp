#include "construct/order/vac_windows.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <utility>

#include "construct/fields/vac_field_simd.h"

namespace noiseloom {
namespace {

std::int64_t reach_of(const VacKernel& kernel) {
  std::int64_t reach = 0;
  for (const VacGroupKernel& group : kernel.groups()) reach = std::max<std::int64_t>(reach, group.reach_y);
  return reach;
}

// Windows and bands end where leaves do.
std::int64_t row_step(const VacLayout& layout) {
  return VacLayout::leaf_cells / std::gcd(VacLayout::leaf_cells, layout.size[0]);
}

// For the selector of a window.
VacSpec spec_of_rows(const VacSpec& spec, std::int64_t rows) {
  VacSpec result = spec;
  result.extents = Extents({spec.extents.size(0), rows});
  result.toroidal = {spec.toroidal.empty() || spec.toroidal[0], false};
  return result;
}

constexpr std::uint64_t key_of_all(std::uint32_t energy) { return (std::uint64_t{energy} << 32) | 0xFFFFFFFFU; }
constexpr std::uint32_t energy_of(std::uint64_t key) { return static_cast<std::uint32_t>(key >> 32); }

// What an eighth as many keep to, after low_bound(): where there was no batch before, the first one is taken to have
// begun there. (The least of all says nothing, where the pixels that are on are scattered by chance.)
std::uint32_t lower_than_low(std::vector<std::uint32_t>& sample) {
  const auto lower = sample.begin() + static_cast<std::ptrdiff_t>(sample.size() / 48);
  std::nth_element(sample.begin(), lower, sample.end());
  return *lower;
}

}  // namespace

std::optional<VacWindows::Sizes> VacWindows::sizes(const VacLayout& layout, const VacKernel& kernel, int num_threads) {
  const bool of_plane = std::ranges::all_of(kernel.groups(), [](const auto& group) { return group.is_of_plane(); });
  const std::int64_t height = layout.size[1];
  const std::int64_t step = row_step(layout);
  // What a window leaves over at its end grows with the picks that a footprint meets in a batch: about as many rows as
  // footprints reach to one side for each. So windows are as high as many footprints, and lower ones have fewer picks.
  constexpr std::int64_t usual_reaches = 16;
  constexpr std::int64_t fewest_reaches = 8;
  constexpr std::int64_t picks_in_footprint = 4;
  const std::int64_t reach = reach_of(kernel) + 1;
  const auto whole_leaves = [step](std::int64_t rows) { return (rows + step - 1) / step * step; };
  const std::int64_t bands = std::min<std::int64_t>(num_threads, height / whole_leaves(fewest_reaches * reach));
  constexpr std::int64_t fewest_cells = std::int64_t{1} << 17;
  constexpr std::int64_t fewest_of_one_band = std::int64_t{1} << 22;
  constexpr std::int64_t most_cells = std::int64_t{1} << 32;  // with keys that are all different
  if (layout.num_slices != 1 || !of_plane || layout.cells < (bands > 1 ? fewest_cells : fewest_of_one_band) ||
      layout.cells > most_cells || bands < 1) {
    return std::nullopt;
  }
  constexpr std::int64_t window_cells = std::int64_t{1} << 19;  // half of a second cache of 1 MiB, and the third
  const std::int64_t wanted_rows =
      std::max(whole_leaves(usual_reaches * reach), window_cells / layout.size[0] / step * step);
  const std::int64_t rows = std::min(wanted_rows, height / bands / step * step);
  std::int64_t taps = 1;
  for (const VacGroupKernel& group : kernel.groups()) {
    taps = std::max<std::int64_t>(taps, std::ranges::count_if(group.weights, [](auto weight) { return weight != 0; }));
  }
  const std::int64_t picks = picks_in_footprint * layout.cells / taps;
  return Sizes{static_cast<int>(bands), rows,
               std::max<std::int64_t>(picks * std::min(rows, usual_reaches * reach) / (usual_reaches * reach), 1)};
}

VacWindows::VacWindows(const VacSpec& spec, const VacKernel& kernel, const Sizes& sizes, VacField& field,
                       ThreadPool& pool)
    : kernel_(kernel),
      field_(field),
      layout_(field.layout()),
      hash_(spec.seed),
      reach_(reach_of(kernel)),
      reach_of_vectors_(reach_ + (std::int64_t{VacGroupKernel::padding} + layout_.size[0] - 1) / layout_.size[0]),
      row_step_(row_step(layout_)),
      window_rows_((sizes.rows + row_step_ - 1) / row_step_ * row_step_),
      wanted_picks_(sizes.picks),
      rest_(spec, kernel),
      work_(pool, static_cast<std::size_t>(sizes.bands)) {
  const VacSpec window = spec_of_rows(spec, window_rows_ + 2 * row_step_);
  for (int i = 0; i < sizes.bands; ++i) {
    band_rows_.push_back(leaf_begin(layout_.size[1] * i / sizes.bands));
    workers_.emplace_back(window, kernel);
  }
  band_rows_.push_back(layout_.size[1]);
}

// The last row up to `row` that a leaf begins with.
std::int64_t VacWindows::leaf_begin(std::int64_t row) const {
  if (row < 0) return leaf_begin(row + layout_.size[1]) - layout_.size[1];
  return row / row_step_ * row_step_;
}

// The first row from `row` on that leaves end before.
std::int64_t VacWindows::leaf_end(std::int64_t row) const {
  if (row < 0) return leaf_end(row + layout_.size[1]) - layout_.size[1];
  return std::min((row + row_step_ - 1) / row_step_ * row_step_, layout_.size[1]);
}

// Calls visit(first leaf, end of leaves, what position in `rows` minus position is) for one or two runs of leaves.
template <class Visit>
void VacWindows::each_run(const Rows& rows, const Visit& visit) const {
  const std::int64_t height = layout_.size[1];
  const std::int64_t width = layout_.size[0];
  const auto run = [&](std::int64_t begin, std::int64_t end, std::int64_t shift) {
    if (begin >= end) return;
    visit(begin * width / VacLayout::leaf_cells, (end * width + VacLayout::leaf_cells - 1) / VacLayout::leaf_cells,
          shift * width);
  };
  run(std::max<std::int64_t>(rows.begin + height, 0), rows.begin < 0 ? height : 0, -rows.begin - height);
  run(std::max<std::int64_t>(rows.begin, 0), rows.end, -rows.begin);
}

// A bound that a sixth of the leaves keep to, of those that have a pixel left and a bound of at least `least`.
std::optional<std::uint32_t> VacWindows::low_bound(const Rows& rows, std::uint32_t least, std::size_t num_samples,
                                                   std::vector<std::uint32_t>& sample) const {
  const std::span<const std::uint32_t> bounds = field_.bounds();
  const std::int64_t num_leaves = rows.size() * layout_.size[0] / VacLayout::leaf_cells;
  sample.clear();
  for (std::int64_t stride = std::max<std::int64_t>(num_leaves / static_cast<std::int64_t>(num_samples), 1) | 1;;
       stride = 1) {
    each_run(rows, [&](std::int64_t first, std::int64_t last, std::int64_t) {
      for (std::int64_t leaf = first; leaf < last; leaf += stride) {
        const std::uint32_t bound = bounds[static_cast<std::size_t>(leaf)];
        if (bound >= least && bound < vac_flag) sample.push_back(bound);
      }
    });
    if (!sample.empty() || stride == 1) break;
  }
  if (sample.empty()) return std::nullopt;
  const auto low = sample.begin() + static_cast<std::ptrdiff_t>(sample.size() / 6);
  std::nth_element(sample.begin(), low, sample.end());
  return *low;
}

// Finds all candidates of the rows with a key up to the limit that is returned, which is past `after`.
std::uint64_t VacWindows::find(const Rows& rows, std::uint64_t after, Worker& worker) {
  constexpr std::size_t num_samples = 256;
  const std::uint32_t least = after == 0 ? 0 : energy_of(after) + 1;
  const std::uint32_t energy = std::min(limit_, low_bound(rows, least, num_samples, worker.sample).value_or(limit_));
  auto most =
      static_cast<std::size_t>(std::max<std::int64_t>(rows.size() * layout_.size[0] / VacLayout::leaf_cells, 4096));
  for (std::uint64_t limit = key_of_all(energy);;) {
    worker.found.clear();
    bool found_all = true;
    each_run(rows, [&](std::int64_t first, std::int64_t last, std::int64_t shift) {
      const VacScan asked{view_, hash_, limit, most, shift};
      found_all = found_all && vac_simd::scan_leaves(layout_, 0, first, last, field_.words(), nullptr, asked,
                                                     field_.bounds().data(), worker.found);
    });
    if (found_all) return limit;
    give_back(rows, worker.found);
    const auto quarter = worker.found.begin() + static_cast<std::ptrdiff_t>(worker.found.size() / 4);
    std::nth_element(worker.found.begin(), quarter, worker.found.end(),
                     [](const VacCandidate& a, const VacCandidate& b) { return a.key() < b.key(); });
    if (quarter->key() > after) {
      limit = quarter->key();
    } else {
      most *= 2;  // there are as many that wait
    }
  }
}

// Takes up again into the bounds what was not picked of what was found.
void VacWindows::give_back(const Rows& rows, std::span<const VacCandidate> found) {
  const std::span<std::uint32_t> bounds = field_.bounds();
  for (const VacCandidate& candidate : found) {
    const std::uint64_t position = position_of(rows, candidate.position);
    const std::uint32_t value = field_.words()[position] ^ static_cast<std::uint32_t>(view_);
    std::uint32_t& bound = bounds[position / VacLayout::leaf_cells];
    if (value < vac_flag) bound = std::min(bound, value);
  }
}

std::uint64_t VacWindows::position_of(const Rows& rows, std::uint64_t position_in_rows) const {
  const std::int64_t position = static_cast<std::int64_t>(position_in_rows) + rows.begin * layout_.size[0];
  return static_cast<std::uint64_t>(position < 0 ? position + layout_.cells : position);
}

void VacWindows::turn(std::span<const std::uint64_t> positions, bool on) {
  std::uint32_t* const words = field_.words();
  for (const std::uint64_t position : positions) words[position] ^= vac_flag;
  for (const VacGroupKernel& group : kernel_.groups()) vac_simd::add_rows(layout_, group, words, on, positions);
}

// Picks all that it can up to limit_. Rows of its own that something waits in are left out of the window that is
// returned, with all between them and the nearer end.
VacWindows::Window VacWindows::pick_in(Window window, Worker& worker) {
  const std::int64_t width = layout_.size[0];
  const std::int64_t middle = (window.own.begin + window.own.end) / 2;
  const bool is_part = window.seen.size() > window.own.size();
  for (std::uint64_t limit = 0; limit < key_of_all(limit_) && window.own.size() > 0;) {
    limit = find(window.seen, limit, worker);
    const auto first_of_row = [&](std::int64_t row) {
      const auto position = static_cast<std::uint64_t>((row - window.seen.begin) * width);
      return static_cast<std::size_t>(std::ranges::lower_bound(worker.found, position, {}, &VacCandidate::position) -
                                      worker.found.begin());
    };
    worker.selector.begin(view_, worker.found, first_of_row(window.own.begin), first_of_row(window.own.end), limit);
    worker.selector.pick();
    worker.is_picked.assign(worker.found.size(), false);
    for (const VacPick& pick : worker.selector.picks()) {
      const std::uint32_t i = pick.index(view_);
      worker.is_picked[i] = true;
      worker.picks.push_back({pick.key, position_of(window.seen, worker.found[i].position)});
    }
    worker.positions.clear();
    for (std::size_t i = 0; i < worker.found.size(); ++i) {  // row by row, so that neighbours share lines
      if (worker.is_picked[i]) worker.positions.push_back(position_of(window.seen, worker.found[i].position));
    }
    turn(worker.positions, view_ == VacView::voids);
    give_back(window.seen, worker.found);
    if (!is_part) continue;
    for (const VacPick& pick : worker.selector.waiting()) {
      const auto position = static_cast<std::int64_t>(worker.found[pick.index(view_)].position);
      const std::int64_t row = window.seen.begin + position / width;
      if (row >= middle) {
        window.own.end = std::min(window.own.end, row);
      } else {
        window.own.begin = std::max(window.own.begin, row + 1);
      }
    }
    window.seen.begin = std::max(window.seen.begin, leaf_begin(window.own.begin - reach_));
    window.seen.end = std::min(window.seen.end, leaf_end(window.own.end + reach_));
  }
  return window;
}

// Goes through a band window by window; each begins where the one before left rows over.
void VacWindows::pick_in_band(std::size_t band) {
  const Rows rows{band_rows_[band], band_rows_[band + 1]};
  const bool toroidal = layout_.toroidal[1];
  const bool is_first_open = rows.begin == 0 && !toroidal;
  const bool is_last_open = rows.end == layout_.size[1] && !toroidal;
  for (std::int64_t begin = rows.begin + (is_first_open ? 0 : reach_);;) {
    Window window;
    window.seen.begin = std::max(rows.begin, leaf_begin(std::max<std::int64_t>(begin - reach_, 0)));
    window.seen.end = std::min(rows.end, window.seen.begin + window_rows_);
    const bool is_last = window.seen.end == rows.end;
    window.own = {begin, window.seen.end - (is_last && is_last_open ? 0 : reach_of_vectors_)};
    if (window.own.size() <= 0) return;
    const std::int64_t left_over = pick_in(window, workers_[band]).own.end;
    if (is_last) return;
    begin = std::max(left_over, begin + 1);
  }
}

// What bands left over where they meet. Windows end in the middle of bands at the latest, and so are apart.
void VacWindows::pick_around_begin_of(std::size_t band) {
  const bool is_first = band == 0;
  if (is_first && !layout_.toroidal[1]) return;
  const auto middle_of = [&](std::size_t i) { return leaf_begin((band_rows_[i] + band_rows_[i + 1]) / 2); };
  const std::int64_t half = window_rows_ / 2;
  const std::int64_t begin = band_rows_[band];
  const std::int64_t before = is_first ? middle_of(workers_.size() - 1) - layout_.size[1] : middle_of(band - 1);
  const Rows seen{std::max(before, leaf_end(begin - half)), std::min(middle_of(band), leaf_begin(begin + half))};
  const Rows own{seen.begin + reach_, seen.end - reach_of_vectors_};
  if (own.size() > 0) pick_in({seen, own}, workers_[band]);
}

void VacWindows::restart() {
  is_fresh_ = true;
  limit_ = 0;
  step_ = 0;
}

std::span<const std::uint64_t> VacWindows::take(VacView view) {
  view_ = view;
  picks_.clear();
  while (picks_.empty()) {
    const Rows all{0, layout_.size[1]};
    constexpr std::size_t num_samples = 1024;
    const auto low = low_bound(all, 0, num_samples, rest_.sample);
    if (!low) break;
    const std::uint32_t from = std::exchange(is_fresh_, false) ? lower_than_low(rest_.sample) : limit_;
    constexpr std::uint64_t most_limit = vac_flag - 1;
    limit_ = std::max(*low, static_cast<std::uint32_t>(std::min(std::uint64_t{from} + step_, most_limit)));
    work_.for_each([&](std::size_t band) { pick_in_band(band); });
    work_.for_each([&](std::size_t band) { pick_around_begin_of(band); });
    pick_in({all, all}, rest_);
    const auto append = [&](Worker& worker) {
      picks_.insert(picks_.end(), worker.picks.begin(), worker.picks.end());
      worker.picks.clear();
    };
    std::ranges::for_each(workers_, append);
    num_left_over_ = rest_.picks.size();
    append(rest_);
    // Energies rise evenly with the number of picks but at the beginning, so that the next step is as the last one was.
    const double growth =
        std::clamp(static_cast<double>(wanted_picks_) / static_cast<double>(picks_.size() + 1), 1.0 / 16, 2.0);
    const double step = static_cast<double>(std::max(limit_ - from, 1U)) * growth;
    step_ = static_cast<std::uint32_t>(std::clamp(step, 1.0, static_cast<double>(most_limit)));
  }
  sort_picks();
  return positions_;
}

// By buckets of equal width in key, which keep about one each.
void VacWindows::sort_picks() {
  const std::size_t num = picks_.size();
  positions_.resize(num);
  if (num == 0) return;
  const auto [least, most] = std::ranges::minmax(picks_, {}, &Pick::key);
  const int shift =
      std::max(0, static_cast<int>(std::bit_width(most.key - least.key)) - static_cast<int>(std::bit_width(num)));
  const auto bucket = [&, least = least.key](const Pick& pick) {
    return static_cast<std::size_t>((pick.key - least) >> shift);
  };
  buckets_.assign(bucket(most) + 2, 0);
  for (const Pick& pick : picks_) ++buckets_[bucket(pick) + 1];
  std::partial_sum(buckets_.begin(), buckets_.end(), buckets_.begin());
  sorted_.resize(num);
  // buckets_[b] is where bucket b begins, until it is filled: then where it ends.
  for (const Pick& pick : picks_) sorted_[buckets_[bucket(pick)]++] = pick;
  std::size_t begin = 0;
  for (const std::size_t end : buckets_) {
    const auto first = sorted_.begin() + static_cast<std::ptrdiff_t>(begin);
    if (end - begin > 1) std::ranges::sort(first, sorted_.begin() + static_cast<std::ptrdiff_t>(end), {}, &Pick::key);
    begin = end;
  }
  std::ranges::transform(sorted_, positions_.begin(), &Pick::position);
}

void VacWindows::turn_on(std::span<const std::uint64_t> positions) {
  const std::int64_t width = layout_.size[0];
  const auto in_rows = [&](std::int64_t begin, std::int64_t end) {
    const auto first = std::ranges::lower_bound(positions, static_cast<std::uint64_t>(begin * width));
    const auto last = std::ranges::lower_bound(first, positions.end(), static_cast<std::uint64_t>(end * width));
    return std::span(first, last);
  };
  work_.for_each([&](std::size_t band) {
    turn(in_rows(band_rows_[band] + reach_, band_rows_[band + 1] - reach_of_vectors_), true);
  });
  work_.for_each([&](std::size_t band) {
    const std::int64_t begin = band_rows_[band];
    turn(in_rows(std::max<std::int64_t>(begin - reach_of_vectors_, 0), begin + reach_), true);
    if (band == 0) turn(in_rows(layout_.size[1] - reach_of_vectors_, layout_.size[1]), true);
  });
}

}  // namespace noiseloom
