// The swap phase: one cluster off, one void on, until both are the same pixel.
//
// Energies go up and down here, so there are no lasting bounds. Instead the pixels on with the largest keys and those
// off with the smallest are kept in two heaps, complete up to a limit each: the field reports every pixel whose word
// crosses a limit. Entries are checked against the field when they come up. An empty heap is filled again by a scan.
#pragma once

#include <optional>

#include "optimize/vac_candidates.h"

namespace noiseloom {

class VacSwapper {
 public:
  // `field` must hold all slices and outlive the swapper.
  VacSwapper(VacField& field, const VacTieHash& hash);

  struct Swap {
    std::uint64_t from;
    std::uint64_t to;
  };
  // Makes the next swap; nothing when cluster and void are the same pixel. Requires that a pixel is on.
  std::optional<Swap> next();

 private:
  struct Side {
    VacView view;
    std::uint64_t limit = 0;
    std::vector<VacCandidate> heap;
  };
  std::uint64_t take(Side& side);
  void fill(Side& side);
  void offer(Side& side, std::uint64_t position);

  VacField& field_;
  VacTieHash hash_;
  Side clusters_{VacView::clusters, 0, {}};
  Side voids_{VacView::voids, 0, {}};
  std::vector<std::uint64_t> hits_;
};

}  // namespace noiseloom
