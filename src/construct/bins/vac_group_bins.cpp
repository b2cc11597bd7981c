#include "construct/bins/vac_group_bins.h"

namespace noiseloom {

VacGroupBins::VacGroupBins(const VacLayout& layout, const VacKernel& kernel, Groups groups) {
  for (const VacGroupKernel& group : kernel.groups()) {
    if (groups == Groups::none) continue;
    if (groups != Groups::all && group.stays_in_slice() != (groups == Groups::in_slices)) continue;
    if (VacPlaneBins::suit(layout, group)) {
      plane_bins_.emplace_back(layout, group);
    } else {
      bins_.emplace_back(layout, group);
    }
  }
}

void VacGroupBins::assign(std::span<const Coord> at) {
  for (VacPlaneBins& bins : plane_bins_) bins.assign(at);
  for (VacBins& bins : bins_) bins.assign(at);
}

void VacGroupBins::raise(const Coord& from, std::span<std::uint32_t> energies) const {
  for (const VacPlaneBins& bins : plane_bins_) bins.raise(from, energies);
  for (const VacBins& bins : bins_) {
    bins.visit(from, [&](std::uint32_t i, std::uint32_t weight) { energies[i] += weight; });
  }
}

void VacGroupBins::find(const Coord& from, std::vector<Hit>& hits) const {
  for (const VacPlaneBins& bins : plane_bins_) bins.find(from, hits);
  for (const VacBins& bins : bins_) {
    bins.visit(from, [&](std::uint32_t i, std::uint32_t weight) {
      if (weight != 0) hits.push_back({i, weight});
    });
  }
}

}  // namespace noiseloom
