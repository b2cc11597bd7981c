// Candidates in the bins of several groups.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "construct/bins/vac_bins.h"
#include "construct/bins/vac_plane_bins.h"

namespace noiseloom {

class VacGroupBins {
 public:
  using Coord = VacBins::Coord;
  using Hit = VacPlaneBins::Hit;
  enum class Groups { all, none, in_slices, across_slices };
  VacGroupBins(const VacLayout& layout, const VacKernel& kernel, Groups groups);

  // Replaces all candidates. They must stay where they are until the next call.
  void assign(std::span<const Coord> at);
  // Adds the weights of a pick at `from` to the energies of the candidates in its footprint.
  void raise(const Coord& from, std::span<std::uint32_t> energies) const;
  // Appends those whose weight is not zero, once for each group.
  void find(const Coord& from, std::vector<Hit>& hits) const;

 private:
  std::vector<VacPlaneBins> plane_bins_;  // of the groups that they suit
  std::vector<VacBins> bins_;             // of the other groups
};

}  // namespace noiseloom
