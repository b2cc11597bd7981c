// The next candidates of a texture: all pixels with a key up to some limit, a few thousandths of the pixels at a time.
// Every rank looks through its own slices; what it finds travels to all.
#pragma once

#include "construct/vac_exchange.h"
#include "construct/vac_fields.h"

namespace noiseloom {

class VacSearch {
 public:
  // Fields and exchange must outlive the search. At most `max_found` >= 1 candidates of a part of a rank at a time;
  // 0: chosen by the number of pixels.
  VacSearch(VacFields& fields, VacExchange& exchange, const VacTieHash& hash, std::size_t max_found = 0);

  // Replaces `found` by all pixels of the texture with a key up to the limit that is returned, ascending in position;
  // at least one unless none is left. The limit is such that a share of about `fraction` of the leaves may reach it,
  // going by their bounds, as they are now or were after the last search. Bounds must be right for `view`. The same on
  // every rank. *Collective*
  std::uint64_t find(VacView view, double fraction, std::vector<VacCandidate>& found);

  // Recomputes all bounds for `view`: before the first search, and where pixels were turned the other way since.
  void refresh_bounds(VacView view);

 private:
  std::uint64_t own_proposal(double fraction);
  static std::uint64_t agreed(std::vector<std::uint64_t> all);
  std::uint64_t propose(double fraction);
  std::uint64_t lower_limit();

  VacFields& fields_;
  VacExchange& exchange_;
  VacTieHash hash_;
  std::size_t max_found_;
  std::uint64_t next_limit_ = 0;    // what the ranks have agreed on for the next search; 0: nothing
  std::vector<std::uint8_t> fits_;  // of each part: whether its scan found no more than it may
};

}  // namespace noiseloom
