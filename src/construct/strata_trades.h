// Which slice of a stack has which pixel of the present stratum, made better.
#pragma once

#include "construct/strata_state.h"

namespace noiseloom {

// Pixels this near are exchanged, whatever else happens to them.
class NeighbourExchange {
 public:
  explicit NeighbourExchange(const StampKernel& kernel);
  // Every pixel of this stratum may change its slice with a neighbour where that lowers the energies of both slices
  // together, or leave it for a neighbour that no slice has filled yet. (How the two slices act on each other is left
  // out of the sum.)
  void pass(StrataState& state) const;

 private:
  struct Neighbour {
    std::int32_t dx;
    std::int32_t dy;
    std::int64_t weight;
  };
  void exchange(StrataState& state, std::size_t stack, std::uint32_t p) const;

  std::vector<Neighbour> neighbours_;
};

// Slices of a stack hand pixels of this stratum round, wherever these are: a slice gives one to the next, that one
// another to a third, and the last one to the first, where all energies together fall by it. Until no round is found
// among the slices that do so together at this moment.
void hand_round(StrataState& state, std::uint32_t moment);

}  // namespace noiseloom
