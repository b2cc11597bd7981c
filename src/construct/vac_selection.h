// The next picks of the whole texture, in their order, from the candidates of all parts of all ranks.
//
// Every part picks by itself among the candidates of its own slices, some hundred picks ahead. Then all parts learn of
// the picks of all. A pick of another part that acts on a candidate of one's own forestalls own picks that come later
// (by key) and were made without it; what lies before the first pick that falls in this way is what one process would
// have picked, as by induction no pick before it was made without one that acts on it. These stand, and the parts go on
// from there. So the picks depend on nothing but the candidates.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "construct/vac_candidates.h"
#include "construct/vac_selector.h"

namespace noiseloom {

class VacSelection {
 public:
  // Fields and exchange must outlive it.
  VacSelection(const VacSpec& spec, const VacKernel& kernel, VacFields& fields, VacExchange& exchange);

  // `picks` becomes the positions of the picks among what `search` has found, up to its limit and at most `max_picks`,
  // in the order picked. The same on every rank. *Collective*
  void select(VacView view, const VacSearch& search, std::uint64_t limit, std::size_t max_picks,
              std::vector<std::uint64_t>& picks);
  // After select, of every part: tells its field what the candidates that were not picked have come to.
  void end(VacField& field, std::size_t part, std::span<const VacCandidate> found);
  // After end: the positions of the part's picks, ascending.
  const std::vector<std::uint64_t>& picked(std::size_t part) const { return picked_[part]; }

 private:
  void begin(VacView view, const VacSearch& search, std::uint64_t limit);
  void for_each(const std::function<void(VacSelector&, std::size_t)>& body);
  void offers_of_rank(std::size_t most);
  void offers_of_all(std::size_t most);
  std::size_t settle();

  VacFields& fields_;
  VacExchange& exchange_;
  // One for each part, of which each picks in a thread of its own; or one for all, where one thread does everything.
  std::vector<VacSelector> of_parts_;
  std::vector<VacSelector> of_all_;
  std::span<VacSelector> selectors_;                // those of the present batch
  std::vector<VacCandidate> all_found_;             // by all parts, for the one
  std::vector<std::size_t> first_of_part_;          // in all_found_
  std::vector<std::vector<std::uint64_t>> picked_;  // by part
  std::vector<VacOffer> fallen_;                    // by selector
  std::size_t picks_ahead_;                         // of a part
  std::vector<VacOffer> offers_;
  std::vector<VacOffer> more_offers_;
  bool is_complete_ = false;  // nothing can come after the last of offers_ but what follows from them
};

}  // namespace noiseloom
