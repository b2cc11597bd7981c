// The slow twin of construct/slice_construction.h: the kernel at every offset of the torus, energies that every pick
// changes one by one, and for every pick a scan of its whole slice. With the same arithmetic and the same ties, so that
// places are equal one by one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "noiseloom/construct/slice_construction.h"
#include "noiseloom/construct/void_and_cluster.h"

namespace noiseloom::oracle {

// The weights of construction at every offset of the torus, by its position among all cells.
struct FullKernel {
  std::vector<std::int64_t> weights{};  // of offset zero: 0
  std::int64_t bias = 0;                // the magnitudes of negative weights
  std::int64_t magnitude = 0;           // those of all weights
  int scale_log2 = 0;
};

// Shares of F(0) below 2^-12 are left out.
FullKernel full_kernel(const Extents& extents, const FilterSpec& filter, double sharpness, int energy_bits = 31);

class SliceConstructionOracle {
 public:
  using Places = std::vector<std::vector<std::uint32_t>>;  // [slice][cell]

  // `points_per_visit`: of the run that is compared.
  SliceConstructionOracle(const Extents& extents, const FilterSpec& filter, SampleScale scale,
                          const ConstructSpec& spec, std::uint64_t seed, std::int64_t points_per_visit);

  const Places& places() const { return places_; }
  const ConstructProgress& progress() const { return progress_; }
  const FullKernel& kernel() const { return kernel_; }
  bool done() const { return progress_.phase == ConstructPhase::done; }

  // One round.
  void advance();

  // What the pixels that `is_on` names have as energy together, in units of the weights: every pair twice.
  std::int64_t energy_of(const Places& places, std::uint32_t is_on) const;

 private:
  struct Tap {
    std::int64_t dx;
    std::int64_t dy;
    std::int64_t weight;
  };
  struct Flip {
    std::size_t slice;
    std::size_t cell;
    bool on;
  };

  void list_taps();
  std::size_t moved(std::size_t cell, const Tap& tap) const;
  // Which slice offset leads from one slice to another.
  std::size_t offset(std::size_t from, std::size_t to) const;
  void draw_start(std::uint64_t seed, std::size_t slice);

  void act(std::size_t from, std::size_t cell, bool on, std::size_t to);
  void turn(const Flip& flip);
  void tell_others(const Flip& flip);
  void turn_everywhere(std::size_t slice, std::size_t cell, bool on);

  // The pixel with the largest key among those on, or the smallest among those off; in an exchange of those without a
  // place.
  std::size_t extreme(std::size_t slice, bool largest_on) const;
  std::int64_t picks_of_visit() const;
  // Returns how many swaps were made. What others have to be told is added to `flips`.
  std::int64_t visit(std::size_t slice, std::int64_t picks, std::vector<Flip>& flips);
  void enter(ConstructPhase phase);
  void end_relaxing();
  void end_phases();

  Extents extents_;
  bool circular_;
  FullKernel kernel_;
  std::vector<std::vector<SliceIndex>> classes_;
  VacTieHash hash_;
  std::size_t cells_;
  std::int64_t points_;
  std::vector<std::vector<Tap>> taps_;  // that are not zero, by slice offset; dx and dy in [0, size)
  ConstructProgress progress_;
  Places places_;
  std::vector<std::vector<bool>> on_;
  std::vector<std::vector<std::int64_t>> energy_;
};

}  // namespace noiseloom::oracle
