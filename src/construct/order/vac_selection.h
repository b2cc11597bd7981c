// The picks of a batch, by all threads and ranks.
//
// Each thread picks among the candidates of some of its rank's slices (vac_selector.h).
// Then the ranks tell each other what they picked, every rank picks among what waits, which is little, and each finds
// the numbers of its own picks: how many of all picks come before.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "construct/bins/vac_selector.h"
#include "construct/fields/vac_portion.h"
#include "construct/fields/vac_work.h"
#include "construct/order/vac_exchange.h"
#include "noiseloom/core/partition.h"

namespace noiseloom {

class VacSelection {
 public:
  // Exchange and pool must outlive the selection. Fewer candidates than `fewest` are sooner picked among than divided.
  VacSelection(const VacSpec& spec, const VacKernel& kernel, const Partition& partition, int rank,
               VacExchange& exchange, ThreadPool& pool, std::size_t fewest = 256);

  // Takes all picks that follow from the candidates (VacSelector::begin). The numbers of those of other ranks' slices
  // are right only where there are more than `most`. At most 2^28 candidates on several ranks. *Collective*
  void take(VacView view, std::span<const VacCandidate> candidates, std::uint64_t limit, std::size_t most,
            VacPortion& picks);

 private:
  static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
  bool divides(std::size_t num_candidates) const;
  void pick_among_own();
  void exchange_picks();
  void pick_what_waits();
  void add_list(std::span<const VacPick> picks);
  void number_picks(std::size_t most);

  VacExchange& exchange_;
  int rank_;
  std::size_t fewest_;
  std::vector<std::uint64_t> rank_positions_;  // where ranks begin; then how many pixels there are
  std::vector<std::uint64_t> part_positions_;  // where this rank's parts begin, of each thread one; then where they end
  std::vector<VacSelector> selectors_;         // of its parts; none where picks are never divided
  std::optional<VacWork> work_;
  VacSelector rest_;  // among what waits, or among all

  VacView view_ = VacView::voids;
  std::uint64_t limit_ = 0;
  std::span<const VacCandidate> candidates_;
  std::vector<std::size_t> rank_begins_;              // in the candidates; then how many there are
  std::vector<VacPick> waiting_;                      // of all ranks
  std::vector<std::vector<VacPick>> picks_of_ranks_;  // other ranks'
  std::vector<VacPick> picks_of_rest_;
  std::vector<VacCandidate> candidates_of_rest_;
  std::vector<std::span<const VacPick>> lists_;  // of all picks; each list ascends
  std::size_t num_picks_ = 0;
  std::vector<std::uint32_t> number_;  // of each candidate; none where it is not picked
};

}  // namespace noiseloom
