// The swap phase: one cluster off, one void on, until both are the same pixel. Distributed, and still pick by pick.
//
// Energies go up and down here, so there are no lasting bounds. Instead every rank tracks the same pixels, wherever
// they lie: at first all pixels that are on with a key up to one limit and all that are off with a key up to another,
// with their energies, which follow from the picks alone. So every rank makes the same picks ahead, without a word.
// Then it carries them out in its own slices and watches for intruders: pixels that nobody tracks and that come within
// a limit. An intruder with a key below that of a later pick of its side would have been picked instead; the earliest
// such pick of any rank is agreed on, it and all after it are taken back (integers: exactly), intruders are tracked
// from then on, and picking goes on from there. The first pick of a batch cannot be wrong, so every batch gets
// somewhere.
#pragma once

#include <optional>
#include <vector>

#include "optimize/vac_bins.h"
#include "optimize/vac_candidates.h"

namespace noiseloom {

class VacSwapper {
 public:
  // Fields and exchange must outlive the swapper; the fields hold the pixels that are on.
  VacSwapper(const VacSpec& spec, const VacKernel& kernel, VacFields& fields, VacExchange& exchange,
             const VacTieHash& hash);

  struct Swap {
    std::uint64_t from;
    std::uint64_t to;
  };
  // Makes up to `max_swaps` swaps and appends them, the same on every rank; false when cluster and void are the same
  // pixel. Requires that a pixel is on. `max_batch` >= 1: the most that are made ahead. *Collective*
  bool advance(std::int64_t max_swaps, std::int64_t max_batch, std::vector<Swap>& swaps);

  std::int64_t num_batches() const { return num_batches_; }
  std::int64_t num_taken_back() const { return num_taken_back_; }
  std::int64_t num_refills() const { return num_refills_; }

 private:
  struct Entry {
    std::uint64_t key;
    std::uint64_t order;  // position, complemented for clusters
    std::uint32_t index;
    friend bool operator<(const Entry& a, const Entry& b) {  // for a heap with the least at the front
      return a.key != b.key ? a.key > b.key : a.order > b.order;
    }
  };
  struct Side {
    VacView view;
    std::uint64_t limit = 0;
    std::vector<Entry> heap;
  };
  struct Pick {
    std::uint32_t index;
    std::uint64_t key;
  };
  struct Part {  // of this rank's fields, while it carries out a batch
    std::size_t valid;
    std::size_t applied;
    std::vector<std::uint64_t> intruders;
    std::vector<std::uint64_t> hits;
  };

  Side& side_of(std::uint32_t word) { return (word & vac_flag) != 0 ? clusters_ : voids_; }
  bool picks_void(std::size_t pick) const { return (pick % 2 != 0) != from_.has_value(); }
  std::uint64_t key_of(const Side& side, std::uint64_t position, std::uint32_t word) const;

  void track(std::uint64_t position, std::uint32_t word);
  void push(std::uint32_t index);
  void toggle(std::uint32_t index);
  std::optional<Pick> take(Side& side);
  void refill();
  void pick_ahead(std::size_t max_picks);
  void carry_out(VacField& field, Part& part);
  void take_back(VacField& field, const Part& part, std::size_t valid) const;
  std::size_t agree_on_valid();
  void track_intruders();

  VacFields& fields_;
  VacExchange& exchange_;
  VacTieHash hash_;
  VacSearch search_;
  VacLayout layout_;

  // Tracked pixels.
  std::vector<VacBins> bins_;
  std::vector<VacBins::Coord> at_;
  std::vector<std::uint64_t> positions_;
  std::vector<std::uint32_t> words_;  // as in the fields
  std::vector<bool> is_tracked_;      // own pixels
  Side clusters_{VacView::clusters, 0, {}};
  Side voids_{VacView::voids, 0, {}};

  std::optional<std::uint64_t> from_;  // turned off, and its swap not complete
  std::vector<Pick> picks_;            // of the batch: in turn a cluster and a void
  std::vector<Part> parts_;
  std::int64_t batch_ = 32;
  std::int64_t num_batches_ = 0;
  std::int64_t num_taken_back_ = 0;
  std::int64_t num_refills_ = 0;
};

}  // namespace noiseloom
