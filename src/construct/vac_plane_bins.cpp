#include "construct/vac_plane_bins.h"

#include <algorithm>
#include <bit>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "construct/vac_plane_bins.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "construct/rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace noiseloom::vac_simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The candidates' places are `places` and what they are called `indices`; there may be up to a vector more to read.
void RaiseAround(const std::array<VacPlaneBins::Axis, 2>& axes, const std::uint32_t* weights,
                 const std::uint32_t* places, const std::uint32_t* indices, std::size_t count,
                 const VacPlaneBins::Coord& from, std::uint32_t* energies) {
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
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto place = hn::LoadU(d, places + i);
    const auto x = column(axes[0], hn::And(place, hn::Set(d, 0xFFFFU)));
    const auto y = column(axes[1], hn::ShiftRight<16>(place));
    const auto mask = hn::And(hn::And(hn::Lt(x, width0), hn::Lt(y, width1)), hn::FirstN(d, count - i));
    hn::Store(hn::Add(hn::Mul(y, width0), x), d, at);
    for (std::uint32_t bits = bits_of(d, mask); bits != 0; bits &= bits - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(bits));
      energies[indices[i + lane]] += weights[at[lane]];
    }
  }
}

}  // namespace noiseloom::vac_simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace noiseloom {
namespace vac_simd {

HWY_EXPORT(RaiseAround);

// Chosen where the targets' namespaces are in reach by one name, as the build for one target alone asks for.
static auto raise_around() { return HWY_DYNAMIC_DISPATCH(RaiseAround); }

}  // namespace vac_simd

bool VacPlaneBins::suit(const VacLayout& layout, const VacGroupKernel& group) {
  constexpr std::int64_t most_pixels = 128 * 128;
  if (group.others.size() != 1 || group.edges != VacEdges::pass) return false;
  return layout.size[static_cast<std::size_t>(group.axis0)] * layout.size[static_cast<std::size_t>(group.others[0])] <=
         most_pixels;
}

VacPlaneBins::VacPlaneBins(const VacLayout& layout, const VacGroupKernel& group) {
  const int indices[] = {group.axis0, group.others[0]};
  for (std::size_t i = 0; i < 2; ++i) {
    const auto a = static_cast<std::size_t>(indices[i]);
    const auto size = narrow<std::int32_t>(layout.size[a]);
    axes_[i] = {a, layout.toroidal[a] ? size : 1 << 20, 0, 0};
  }
  for (const VacRow& row : group.rows) {
    axes_[0].lo = std::max(axes_[0].lo, row.lo);
    axes_[0].hi = std::max(axes_[0].hi, row.hi);
    axes_[1].lo = std::max(axes_[1].lo, -row.offset[0]);
    axes_[1].hi = std::max(axes_[1].hi, row.offset[0]);
  }
  const std::int32_t width = axes_[0].lo + axes_[0].hi + 1;
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
  ends_.resize(planes + 1);
}

void VacPlaneBins::assign(std::span<const Coord> at) {
  std::fill(ends_.begin(), ends_.end(), 0U);
  for (const Coord& c : at) ++ends_[plane(c) + 1];
  for (std::size_t i = 1; i < ends_.size(); ++i) ends_[i] += ends_[i - 1];
  places_.resize(at.size() + padding);
  indices_.resize(at.size());
  for (std::size_t i = 0; i < at.size(); ++i) {  // ends_[p] is where plane p begins, until it is filled
    const std::uint32_t k = ends_[plane(at[i])]++;
    places_[k] =
        static_cast<std::uint32_t>(at[i][axes_[0].index]) | (static_cast<std::uint32_t>(at[i][axes_[1].index]) << 16);
    indices_[k] = static_cast<std::uint32_t>(i);
  }
}

void VacPlaneBins::raise(const Coord& from, std::span<std::uint32_t> energies) const {
  const std::size_t p = plane(from);
  const std::size_t begin = p == 0 ? 0 : ends_[p - 1];
  vac_simd::raise_around()(axes_, weights_.data(), places_.data() + begin, indices_.data() + begin, ends_[p] - begin,
                           from, energies.data());
}

}  // namespace noiseloom
#endif
