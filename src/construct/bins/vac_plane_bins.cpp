#include "construct/bins/vac_plane_bins.h"

#include <algorithm>
#include <bit>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "construct/bins/vac_plane_bins.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "construct/fields/rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace noiseloom::vac_simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Calls visit(k, weight) for the candidates around `from`, whose places are `places`; there may be up to a vector more
// to read.
template <class Visit>
HWY_INLINE void each_around(const std::array<VacPlaneBins::Axis, 2>& axes, const std::uint32_t* weights,
                            const std::uint32_t* places, std::span<const VacPlaneBins::Run> runs,
                            const VacPlaneBins::Coord& from, const Visit& visit) {
  using rows::HWY_NAMESPACE::bits_of;
  using rows::HWY_NAMESPACE::Lanes;
  const Lanes d;
  const hn::RebindToSigned<Lanes> di;
  const auto set = [d](std::int32_t value) HWY_ATTR { return hn::Set(d, static_cast<std::uint32_t>(value)); };
  // The difference from `from`, counted from the lower end of the footprint: in the footprint where it is below its
  // width.
  const auto column = [&](const VacPlaneBins::Axis& axis, auto coordinate) HWY_ATTR {
    const auto c = hn::Add(coordinate, set(axis.lo - from[axis.index]));
    const auto wrapped = hn::IfThenElse(hn::MaskFromVec(hn::BitCast(d, hn::BroadcastSignBit(hn::BitCast(di, c)))),
                                        hn::Add(c, set(axis.size)), c);
    return hn::Min(wrapped, hn::Sub(wrapped, set(axis.size)));
  };
  const auto width0 = set(axes[0].lo + axes[0].hi + 1);
  const auto width1 = set(axes[1].lo + axes[1].hi + 1);
  HWY_ALIGN std::uint32_t at[hn::MaxLanes(d)];
  for (const VacPlaneBins::Run& run : runs) {
    for (std::size_t i = run.begin; i < run.end; i += hn::Lanes(d)) {
      const auto place = hn::LoadU(d, places + i);
      const auto x = column(axes[0], hn::And(place, hn::Set(d, 0xFFFFU)));
      const auto y = column(axes[1], hn::ShiftRight<16>(place));
      const auto mask = hn::And(hn::And(hn::Lt(x, width0), hn::Lt(y, width1)), hn::FirstN(d, run.end - i));
      if (hn::AllFalse(d, mask)) continue;
      hn::Store(hn::Add(hn::Mul(y, width0), x), d, at);
      for (std::uint32_t bits = bits_of(d, mask); bits != 0; bits &= bits - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(bits));
        visit(i + lane, weights[at[lane]]);
      }
    }
  }
}

void RaiseAround(const std::array<VacPlaneBins::Axis, 2>& axes, const std::uint32_t* weights,
                 const std::uint32_t* places, const std::uint32_t* indices, std::span<const VacPlaneBins::Run> runs,
                 const VacPlaneBins::Coord& from, std::uint32_t* energies) {
  each_around(axes, weights, places, runs, from,
              [&](std::size_t k, std::uint32_t weight) HWY_ATTR { energies[indices[k]] += weight; });
}

void FindAround(const std::array<VacPlaneBins::Axis, 2>& axes, const std::uint32_t* weights,
                const std::uint32_t* places, const std::uint32_t* indices, std::span<const VacPlaneBins::Run> runs,
                const VacPlaneBins::Coord& from, std::vector<VacPlaneBins::Hit>& hits) {
  each_around(axes, weights, places, runs, from, [&](std::size_t k, std::uint32_t weight) HWY_ATTR {
    if (weight != 0) hits.push_back({indices[k], weight});
  });
}

}  // namespace noiseloom::vac_simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace noiseloom {
namespace vac_simd {

HWY_EXPORT(RaiseAround);
HWY_EXPORT(FindAround);

// Chosen where the targets' namespaces are in reach by one name, as the build for one target alone asks for.
static auto raise_around() { return HWY_DYNAMIC_DISPATCH(RaiseAround); }
static auto find_around() { return HWY_DYNAMIC_DISPATCH(FindAround); }

}  // namespace vac_simd

static constexpr std::int32_t not_toroidal = 1 << 20;     // more than any difference
static constexpr std::int32_t least_widths[] = {64, 16};  // of tiles, along both axes

bool VacPlaneBins::suit(const VacLayout& layout, const VacGroupKernel& group) {
  if (group.others.size() != 1 || group.edges != VacEdges::pass) return false;
  const std::int64_t width = layout.size[static_cast<std::size_t>(group.axis0)];
  const std::int64_t height = layout.size[static_cast<std::size_t>(group.others[0])];
  constexpr std::int64_t most = 1 << 15;  // coordinates are halves of a word
  // Tiles are gone through for every batch, which has a few thousandths of the pixels.
  constexpr std::int64_t fewest_pixels_in_tile = 256;
  return width <= most && height <= most &&
         std::min<std::int64_t>(width, least_widths[0]) * std::min<std::int64_t>(height, least_widths[1]) >=
             fewest_pixels_in_tile;
}

VacPlaneBins::VacPlaneBins(const VacLayout& layout, const VacGroupKernel& group) {
  const int indices[] = {group.axis0, group.others[0]};
  for (std::size_t i = 0; i < 2; ++i) {
    const auto a = static_cast<std::size_t>(indices[i]);
    const auto size = narrow<std::int32_t>(layout.size[a]);
    axes_[i] = {a, layout.toroidal[a] ? size : not_toroidal, 0, 0, 0, 0};
  }
  for (const VacRow& row : group.rows) {
    axes_[0].lo = std::max(axes_[0].lo, row.lo);
    axes_[0].hi = std::max(axes_[0].hi, row.hi);
    axes_[1].lo = std::max(axes_[1].lo, -row.offset[0]);
    axes_[1].hi = std::max(axes_[1].hi, row.offset[0]);
  }
  // So wide that a footprint meets at most four tiles along an axis. Narrow planes are one tile wide, as few candidates
  // are looked at in vain there.
  constexpr std::int64_t narrow_plane = 128;
  for (std::size_t i = 0; i < 2; ++i) {
    Axis& axis = axes_[i];
    const std::int64_t size = layout.size[axis.index];
    std::int32_t width = std::max(least_widths[i], (axis.lo + axis.hi + 2) / 2);
    if (i == 0 && size <= narrow_plane) width = narrow_plane;
    axis.shift = static_cast<int>(std::bit_width(static_cast<std::uint32_t>(width - 1)));
    axis.num_tiles = static_cast<std::int32_t>((size - 1) >> axis.shift) + 1;
  }
  const std::int64_t width = axes_[0].lo + axes_[0].hi + 1;
  weights_.assign(static_cast<std::size_t>(width * (axes_[1].lo + axes_[1].hi + 1)), 0);
  for (const VacRow& row : group.rows) {
    std::copy_n(group.weights.begin() + static_cast<std::ptrdiff_t>(row.first), row.lo + row.hi + 1,
                weights_.begin() + (row.offset[0] + axes_[1].lo) * width + axes_[0].lo - row.lo);
  }
  std::size_t planes = 1;
  for (int index = 0; index < layout.num_axes; ++index) {
    if (index == indices[0] || index == indices[1]) continue;
    strides_.push_back({static_cast<std::size_t>(index), planes});
    planes *= static_cast<std::size_t>(layout.size[static_cast<std::size_t>(index)]);
  }
  ends_.resize(planes * static_cast<std::size_t>(axes_[0].num_tiles) * static_cast<std::size_t>(axes_[1].num_tiles) +
               1);
}

void VacPlaneBins::assign(std::span<const Coord> at) {
  std::fill(ends_.begin(), ends_.end(), 0U);
  for (const Coord& c : at) ++ends_[tile(c) + 1];
  for (std::size_t i = 1; i < ends_.size(); ++i) ends_[i] += ends_[i - 1];
  places_.resize(at.size() + padding);
  indices_.resize(at.size());
  for (std::size_t i = 0; i < at.size(); ++i) {  // ends_[t] is where tile t begins, until it is filled
    const std::uint32_t k = ends_[tile(at[i])]++;
    places_[k] =
        static_cast<std::uint32_t>(at[i][axes_[0].index]) | (static_cast<std::uint32_t>(at[i][axes_[1].index]) << 16);
    indices_[k] = static_cast<std::uint32_t>(i);
  }
}

// Those that the footprint of coordinate c meets, each once: one or two ranges.
std::size_t VacPlaneBins::tiles_met(const Axis& axis, std::int32_t c, std::array<Tiles, 2>& tiles) {
  const std::int32_t last_tile = axis.num_tiles - 1;
  const std::int32_t first = c - axis.lo;
  const std::int32_t last = c + axis.hi;
  const bool toroidal = axis.size != not_toroidal;
  if (toroidal && (first < 0 || last >= axis.size)) {
    const std::int32_t from = (first < 0 ? first + axis.size : first) >> axis.shift;
    const std::int32_t to = (last >= axis.size ? last - axis.size : last) >> axis.shift;
    if (from > to) {
      tiles = {Tiles{from, last_tile}, Tiles{0, to}};
      return 2;
    }
    tiles[0] = {0, last_tile};  // it comes round to the tile that it began in
    return 1;
  }
  tiles[0] = {std::max(first, 0) >> axis.shift, std::min(last >> axis.shift, last_tile)};
  return 1;
}

// Where in places_ the candidates are that the footprint of a pick at `from` may meet.
std::span<const VacPlaneBins::Run> VacPlaneBins::runs_around(const Coord& from,
                                                             std::array<Run, most_runs>& runs) const {
  const auto width = static_cast<std::size_t>(axes_[0].num_tiles);
  const std::size_t num_tiles = width * static_cast<std::size_t>(axes_[1].num_tiles);
  const std::size_t origin = plane(from) * num_tiles;
  const auto begin_of = [&](std::size_t tile) { return tile == 0 ? 0 : ends_[tile - 1]; };
  // A few are sooner looked at than their tiles.
  constexpr std::uint32_t few = 16;
  const Run whole{begin_of(origin), ends_[origin + num_tiles - 1]};
  if (whole.end - whole.begin <= few) {
    runs[0] = whole;
    return std::span(runs).first(1);
  }
  std::array<Tiles, 2> columns;
  std::array<Tiles, 2> rows;
  const std::size_t num_columns = tiles_met(axes_[0], from[axes_[0].index], columns);
  const std::size_t num_rows = tiles_met(axes_[1], from[axes_[1].index], rows);
  std::size_t num_runs = 0;
  const auto add_run = [&](std::size_t first, std::size_t last) {
    const Run run{begin_of(first), ends_[last]};
    if (run.begin < run.end) runs[num_runs++] = run;
  };
  for (std::size_t r = 0; r < num_rows; ++r) {
    const std::size_t first_row = origin + static_cast<std::size_t>(rows[r].first) * width;
    const std::size_t last_row = origin + static_cast<std::size_t>(rows[r].last) * width;
    if (width == 1) {
      add_run(first_row, last_row);
      continue;
    }
    for (std::size_t row = first_row; row <= last_row; row += width) {
      for (std::size_t c = 0; c < num_columns; ++c) {
        add_run(row + static_cast<std::size_t>(columns[c].first), row + static_cast<std::size_t>(columns[c].last));
      }
    }
  }
  return std::span(runs).first(num_runs);
}

void VacPlaneBins::raise(const Coord& from, std::span<std::uint32_t> energies) const {
  std::array<Run, most_runs> runs;
  vac_simd::raise_around()(axes_, weights_.data(), places_.data(), indices_.data(), runs_around(from, runs), from,
                           energies.data());
}

void VacPlaneBins::find(const Coord& from, std::vector<Hit>& hits) const {
  std::array<Run, most_runs> runs;
  vac_simd::find_around()(axes_, weights_.data(), places_.data(), indices_.data(), runs_around(from, runs), from, hits);
}

}  // namespace noiseloom
#endif
