// The next candidates of a texture: all pixels with a key up to some limit, a few thousandths of the pixels at a time.
// Every rank looks through its own slices; what it finds travels to all.
#pragma once

#include <optional>

#include "construct/order/vac_exchange.h"
#include "construct/order/vac_slices.h"

namespace noiseloom {

class VacSearch {
 public:
  // Fields and exchange must outlive the search.
  VacSearch(VacSlices& slices, VacExchange& exchange, const VacTieHash& hash);

  // Replaces `found` by all pixels of the texture with a key up to the limit that is returned, ascending in position;
  // at least one unless none is left. The limit is such that a share of about `fraction` of the leaves may reach it,
  // going by their bounds, as they are now or were after the last search. Bounds must be right for `view`. The same on
  // every rank. *Collective*
  std::uint64_t find(VacView view, double fraction, std::vector<VacCandidate>& found);

  // What fields are to be asked, as they turn what was picked from the last search, in order that the next one finds it
  // done. Nothing where its limit is not known yet. `fraction`: of the next search.
  std::optional<VacScan> scan_ahead(VacView view, double fraction);

  // Recomputes all bounds for `view`: before the first search, and where pixels were turned the other way since.
  void refresh_bounds(VacView view);

 private:
  std::uint64_t own_proposal(double fraction);
  static std::uint64_t agreed(std::vector<std::uint64_t> all);
  std::uint64_t propose(double fraction);
  std::uint64_t lower_limit();

  VacSlices& slices_;
  VacExchange& exchange_;
  VacTieHash hash_;
  std::size_t max_found_ = 0;  // of a part
  // The same after the limit was lowered, as at the beginning, where all energies are alike: there many candidates make
  // few picks.
  std::size_t max_found_if_lowered_ = 0;
  std::uint64_t next_limit_ = 0;  // what the ranks have agreed on for the next search; 0: nothing
  bool scanned_ = false;          // fields were asked for that limit
};

}  // namespace noiseloom
