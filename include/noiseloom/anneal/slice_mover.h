// One visit of one slice, or of a tile of it: pairs of cells are drawn whose samples might change places (candidates),
// and the change of the energy decides about each of them. Everything around the tile is taken as it was before the
// visit. What comes out is the list of swaps, in order; whoever holds the slice carries them out.
//
// Two ways of drawing and deciding: AnnealMover, one candidate after the other by the Metropolis rule [Metropolis53],
// and PairingMover, the step of [FAST24], where all cells are paired at once.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "noiseloom/anneal/swap_delta.h"
#include "noiseloom/dist/halo_exchange.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {

struct Visit {
  SliceIndex slice;
  std::uint32_t sweep = 0;
  std::uint64_t seed = 0;
  std::int64_t iterations = 1;  // anneal: n / 2 candidates each, for n cells of the slice
  int tile = 0;                 // anneal: makes the candidates of one of `num_tiles` equal shares
  int num_tiles = 1;
  Corner corner{};  // of the tile; its size is that of the SwapDelta
};

struct VisitResult {
  std::vector<Swap> swaps;  // in order
  std::int64_t num_swaps = 0;
  std::int64_t candidates = 0;
  double energy = 0;  // anneal: sum of dE of the swaps, each as the one before it left the tile
};

// How far partners lie: between n / near and n / far ids, for n samples; near >= far >= 2.
struct StepRange {
  double near;
  double far = 2;
};

// Draws the partner of a cell among the samples that are like its own: a swap of like samples changes the energy little
// and is accepted more often. Ids number the samples of a slice so that neighbours are alike (samples/sample_space.h);
// the distance between the ids of a pair is drawn log-uniformly from a StepRange, and is at least 1. At both ends ids
// are reflected, or, on a circle, go on at the other end.
class PartnerDraw {
 public:
  // num_strata: ids fall into so many equal runs, and partners are drawn from that of the sample, which does not go
  // on at its other end.
  PartnerDraw(std::int64_t num_samples, StepRange range, bool circular, int num_strata = 1);

  float lowest_step() const { return lowest_step_; }
  float log2_ratio() const { return log2_ratio_; }  // of the largest step to the lowest
  // The id that is `step` away from `id`, |step| <= length of a run / 2 + 1.
  SampleId partner(SampleId id, std::int32_t step) const {
    const std::uint32_t first = num_strata_ == 1 ? 0 : id.value() / run_ * run_;
    const std::int64_t other = std::int64_t{id.value() - first} + step;
    const std::int64_t last = std::int64_t{run_} - 1;
    if (circular_) return unchecked(other < 0 ? other + run_ : other > last ? other - run_ : other);
    const std::int64_t above = other < 0 ? -other : other;
    return unchecked(first + (above > last ? std::max<std::int64_t>(0, 2 * last - above) : above));
  }

 private:
  static SampleId unchecked(std::int64_t id) { return SampleId(static_cast<std::uint32_t>(id)); }

  int num_strata_;
  std::uint32_t run_;  // ids of a stratum
  bool circular_;
  float lowest_step_;
  float log2_ratio_;
};

// The cells of a window in the order of their samples' ids, which is all that partners need to know of them: looked
// into with the place of a sample among those of the window, which is its id where the window is the slice.
IndexedVector<SampleId, std::uint32_t> cells_by_id(const FieldLayout& slice, Corner corner, const FieldLayout& window,
                                                   std::span<const SampleId> permutation);

// Metropolis at one temperature; candidates in order, each seeing the swaps before it. temperature 0
// accepts improvements and ties only. Partners are looked up for sixteen candidates at a time (proposals.h).
//
// Where the SwapDelta has estimates, they are a sieve: a candidate whose estimate lies too far above what Metropolis
// would accept is not judged. That is decided for sixteen candidates at a time, before the first of them is judged.
class AnnealMover {
 public:
  explicit AnnealMover(std::unique_ptr<SwapDelta> delta);
  // `partners` is for as many samples as the window of the SwapDelta has; the swaps are of cells of the slice.
  VisitResult visit(const Visit& visit, double temperature, const PartnerDraw& partners, const SliceField& field,
                    std::span<const SampleId> permutation, const FieldOf& others);
  // Memory for the swaps of the next visit.
  void recycle(std::vector<Swap> swaps) { spare_ = std::move(swaps); }
  // Mean |dE| of `count` candidates of the visit, none of them carried out.
  double mean_magnitude(const Visit& visit, std::int64_t count, const PartnerDraw& partners, const SliceField& field,
                        std::span<const SampleId> permutation, const FieldOf& others);

 private:
  struct Batch;
  void load(const Visit& visit, const SliceField& field, std::span<const SampleId> permutation);
  void draw(const Visit& visit, std::uint64_t first, std::uint64_t end, const PartnerDraw& partners,
            Batch& batch) const;
  void carry_out(CellPair pair);
  struct Range;
  void move_all(const Range& range, VisitResult& result);
  void move_sieved(const Range& range, VisitResult& result);
  void judge(const Range& range, const Batch& batch, std::size_t k, VisitResult& result);

  std::unique_ptr<SwapDelta> delta_;
  // Of the cells of the window: the place of the sample there among those of the window, and the other way round.
  std::vector<SampleId> id_at_;
  IndexedVector<SampleId, std::uint32_t> cell_of_;
  std::vector<Swap> spare_;
  std::size_t num_swaps_ = 0;  // of the visit before: about as many as of the next
};

// The paper's step [FAST24, section 4.1]: every cell is paired with another by a random involution, all pairs are
// judged from the frozen state, and of a random fraction gamma of them those are swapped that lower the energy.
class PairingMover {
 public:
  explicit PairingMover(std::unique_ptr<SwapDelta> delta) : delta_(std::move(delta)) {}
  VisitResult visit(const Visit& visit, double fraction, const SliceField& field, const FieldOf& others);

 private:
  std::unique_ptr<SwapDelta> delta_;
};

}  // namespace noiseloom
