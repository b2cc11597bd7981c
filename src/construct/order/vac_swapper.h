// The swap phase: one cluster off, one void on, until both are the same pixel.
//
// Energies go up and down here, so there are no lasting bounds. Instead the pixels on with the largest keys and those
// off with the smallest are kept in two heaps, complete up to a limit each: the field reports every pixel whose word
// crosses a limit. Entries are checked against the field when they come up. An empty heap is filled again by a scan.
//
// A rank does this for its own slices; the pick is the best of the ranks. Looking ahead does not pay: a pixel that is
// turned off leaves a void about it that mostly is the next pick, so runs that are known beforehand are two swaps long.
#pragma once

#include <optional>
#include <utility>

#include "construct/order/vac_candidates.h"

namespace noiseloom {

class VacSwapper {
 public:
  // Fields and exchange must outlive the swapper.
  VacSwapper(VacSlices& slices, VacExchange& exchange, const VacTieHash& hash);

  struct Swap {
    std::uint64_t from;
    std::uint64_t to;
  };
  // Makes the next swap, the same on every rank; nothing when cluster and void are the same pixel. Requires that a
  // pixel is on. *Collective*
  std::optional<Swap> next();

 private:
  struct Side {
    VacView view;
    std::uint64_t limit = 0;
    std::vector<VacCandidate> heap;
  };
  std::uint64_t agree(Side& side);
  VacOffer best(Side& side);
  void fill(Side& side);
  void offer(Side& side, std::uint64_t position);

  VacSlices& slices_;
  VacExchange& exchange_;
  VacTieHash hash_;
  VacExchange alone_;
  VacSearch own_search_;
  Side clusters_{VacView::clusters, 0, {}};
  Side voids_{VacView::voids, 0, {}};
  std::vector<std::uint64_t> hits_;
};

}  // namespace noiseloom
