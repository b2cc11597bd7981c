// Construction: the places of the pixels of every slice, found point by point at the largest void of the filter's own
// overlap. Method `construct`, for samples of one channel that are compared by their difference.
//
// |a - b| is the integral, over all thresholds u, of [a < u] xor [b < u]. So the energy of a scalar texture [FAST24,
// eq. 7] is the integral over u of the energies of its point sets {sample < u} under the overlap F: what void and
// cluster minimises greedily, one threshold after the other, if its kernel is F. Here every slice is filled in step, so
// each is a permutation of its own samples: the pixel that is turned on as the r-th of its slice has place r, and gets
// the r-th smallest sample. The kernel is F, sharpened in space (src/construct/stamp_kernel.h).
//
// Samples on a circle are compared by the shorter way round, which is the integral over u of [a in H(u)] xor
// [b in H(u)], H(u) being the half of the circle that begins at u. So their point sets are halves of the places: as u
// goes round, the pixel of the lowest place leaves the set and that of the place half a turn on enters it. They are
// constructed by exchange.
//
// Phases, each a sequence of rounds; a round visits every slice once, one colour class (problem/colour_classes.h) after
// the other, all slices of a class against the state before. A visit makes up to `points_per_visit` picks in its slice
// alone, each at an extreme of the key (energy, keyed hash of the position, cell), which is a total order:
//   relax  from a random pattern of the same number of points in every slice: the tightest cluster is turned off, then
//          the largest void on, until both are the same pixel. Over when no visit of a round changes anything, or after
//          a fixed number of rounds (slices that move at once may chase each other).
//   drain  the tightest cluster of what is on gets the last place that is left, and is turned off
//   fill   from the pattern again: the largest void gets the next place, and is turned on, until all are
//
// On a circle, of n pixels a slice, h = n / 2 rounded down:
//   spread    from nothing the largest void is turned on, until h pixels are
//   relax     as above, of these h
//   exchange  step k: the tightest cluster of those of the h that are still on gets place k and is turned off, and the
//             largest void among the others that were never on gets place k + h and is turned on, until all have one
//
// Energies are integers and follow from the pixels that are on, so nothing depends on ranks, threads or interruptions.
// Distributed: a rank holds the energies of its own slices; after a class has moved, what it picked travels to the
// ranks whose slices it acts on, as positions.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "noiseloom/construct/spec.h"
#include "noiseloom/core/extents.h"
#include "noiseloom/core/parallel.h"
#include "noiseloom/dist/communicator.h"
#include "noiseloom/problem/footprint.h"
#include "noiseloom/problem/spec.h"

namespace noiseloom {

// The number of this algorithm: raised in the same commit as any change after which an unchanged config gives other
// /samples (tests/program/pinned_samples_test.py notices). A run file keeps it, and a run of another number is not gone
// on with.
//   2: under gauss-energy alone nothing is sharpened, unless the config says so
//   3: what is annealed after it joins the schedule elsewhere, and ends colder
inline constexpr std::int64_t construct_algorithm = 3;

// Entries of a slice that is not complete, beside places: one a pixel.
inline constexpr std::uint32_t pixel_is_on = 0xFFFFFFFEU;   // without a place yet
inline constexpr std::uint32_t pixel_is_off = 0xFFFFFFFFU;  // without a place yet

enum class ConstructPhase : std::int32_t { spread = 0, relax = 1, drain = 2, fill = 3, exchange = 4, done = 5 };

// With the places, everything that a run is between two rounds; the same for every slice.
struct ConstructProgress {
  ConstructPhase phase = ConstructPhase::relax;
  std::int64_t num_start_points = 0;  // of a slice; on a circle half of its pixels
  std::int64_t num_placed = 0;        // pixels of a slice that have their place
  std::int64_t rounds = 0;            // of the present phase
  std::int64_t num_swaps = 0;         // of the relax phase, in all slices
  friend bool operator==(const ConstructProgress&, const ConstructProgress&) = default;
};

class SliceConstruction {
 public:
  // `overlap`: that of `filter`, without a cutoff. `spec.sharpness`: as it is to be used (construct/sharpness.h finds
  // it); on a circle its density has no meaning. Communicator and pool must outlive it. Requires fewer than 2^31 cells
  // in a slice. Throws UserError for a table that cannot be used.
  SliceConstruction(const Footprint& overlap, const FilterSpec& filter, SampleScale scale, const ConstructSpec& spec,
                    std::uint64_t seed, const Communicator& communicator, ThreadPool& pool);
  ~SliceConstruction();
  SliceConstruction(const SliceConstruction&) = delete;
  SliceConstruction& operator=(const SliceConstruction&) = delete;

  void start();  // *Collective*
  // Goes on from a run of the same arguments. `places(slice)`: of a slice that slices_held() names, as places() gave
  // them; what it throws on one rank all throw. Requires that progress and places belong together (is_sound).
  // *Collective*
  void restore(const ConstructProgress& progress, const std::function<std::vector<std::uint32_t>(SliceIndex)>& places);
  // Own slices, then those that act on them, each ascending.
  std::vector<SliceIndex> slices_held() const;

  // One round. *Collective*
  void advance();
  bool done() const { return progress().phase == ConstructPhase::done; }
  const ConstructProgress& progress() const;  // the same on every rank
  // The share of the whole run that is done, by the number of picks.
  double fraction() const;

  const Distribution& distribution() const;
  // Of a slice that slices_held() names, [y][x]: the place of every pixel, or one of the two entries above.
  const std::vector<std::uint32_t>& places(SliceIndex slice) const;

  bool couples_slices() const;
  std::int64_t num_classes() const;
  std::int64_t points_per_visit() const;
  std::int64_t picks_done() const;     // by this rank since it was made
  std::int64_t bytes_sent() const;     // by this rank
  std::int64_t messages_sent() const;  // by this rank

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Whether `places` of a slice of any run can be those of `progress`: every place once, and as many pixels on as it
// says.
bool is_sound(const ConstructProgress& progress, std::span<const std::uint32_t> places);

}  // namespace noiseloom
