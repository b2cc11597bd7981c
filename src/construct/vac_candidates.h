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
  // going by their bounds. Bounds must be right for `view`. The same on every rank. *Collective*
  std::uint64_t find(VacView view, double fraction, std::vector<VacCandidate>& found);

 private:
  std::uint64_t propose(double fraction);
  std::uint64_t lower_limit();

  VacFields& fields_;
  VacExchange& exchange_;
  VacTieHash hash_;
  std::size_t max_found_;
  std::vector<std::uint8_t> fits_;  // of each part: whether its scan found no more than it may
};

}  // namespace noiseloom
