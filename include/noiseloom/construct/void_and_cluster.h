// Void and cluster in any dimension: the order in which the pixels of a scalar mask are turned on.
//
// The energy of a pixel p is the sum over the pixels q != p that are on of K(p - q) [Ulichney93]
// [STBN22, sections 3.1 and 4.1], with
//
//   K(d) = sum_g w_g [d is zero on every axis outside group g] * prod_{a in g} k_a(d_a),
//   k_a(d) = exp(-d^2 / 2 sigma_g^2)
//
// or, on the box axes of a group, k_a(d) = max(0, n - |d|) / n with n = box_g (folded; 1 where the box is as long as
// the axis): the energy of the unions of n slices in a row, added up over all such runs, so that each union is blue.
// There the same pixel of another slice weighs as much as all other weights together: it is turned on only when all
// pixels that no such slice has are, so that the members of a union are disjoint.
//
// A group may have a tail: then the product over its other axes than boxes is at least
//
//   tail / (tail + r^(2 p)), r^2 the sum of the squares of the shortest d_a,
//
// which still tells distances apart where the Gaussian is as good as 0, so that the first points keep far apart.
//
// Along the tile axes of a group every slice is one of N tiles, and any tile may lie beside any: the part of a pixel's
// footprint beyond an edge of x or y lies on the far side of every tile, 1 / N of it on each, the pixel's own among
// them. Inside, tiles do not act on each other. So K(d) is that of d without the tile axes, within a tile where the
// shortest way passes no edge, and between any two tiles, over N, where it does.
//
// On a toroidal axis k_a is summed over all images of d, so a footprint larger than the axis folds and nothing changes
// under a shift of the torus. Weights are fixed-point integers (construct/fields/vac_kernel.h in src): energies never
// drift.
//
// Three phases, each a sequence of picks at an extreme of the key (energy, keyed hash of the position, position), which
// is a total order:
//   swap   the pixel that is on with the largest key is turned off, then the one that is off with the smallest key is
//          turned on, until both are the same pixel. The sum of keys falls with every swap, so this ends.
//   drain  from the pattern of n points: the pixel on with the largest key gets place n-1 and is turned off, and so on.
//   fill   from the pattern again: the pixel off with the smallest key gets the next place and is turned on, until all
//          are. Beyond half this is the paper's third phase too: the tightest cluster of what is off is the emptiest
//          place of what is on, because the energies of the two add up to the same constant everywhere (on a torus).
//
// Distributed: a rank holds the energies and the places of the pixels of its own slices, nothing else that grows with
// the texture but the few candidates below and, for the pairs among them, a table of bins. Energies never travel.
//   start  every rank draws the whole pattern and keeps what falls into its slices; the number of pixels drawn twice is
//          summed. Whenever energies are computed anew, the pixels that are on travel as one bit a pixel.
//   swap   each rank offers its best cluster, then its best void: two collectives of 16 bytes a swap.
//   drain, fill   a batch: the ranks agree on a limit, each finds the pixels of its slices with a key up to it, these
//          candidates (position and energy, about five bytes each) go to all, each thread of each rank picks among
//          those of its own slices, the picks (eight bytes a candidate) go to all, every rank picks among those that
//          had to wait for other slices, and all is carried out in the own slices. Three collectives of MPI's a batch,
//          which is hundreds to tens of thousands of picks: numbers of bytes and the next limit, the candidates, the
//          picks. Exact because keys only rise while pixels are turned on (off): all that the picks up to the limit
//          depend on are the candidates (vac_selector.h). Limits change where batches end, not the picks. Of a single
//          large slice whose groups are all over x and y, the rank that has it takes the picks alone, its threads in
//          bands of rows (vac_windows.h), and one sum a batch travels.
// So all decisions are made from the same integers on every rank, and no rank or thread count can change them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "noiseloom/construct/spec.h"
#include "noiseloom/core/extents.h"
#include "noiseloom/core/parallel.h"
#include "noiseloom/dist/communicator.h"
#include "noiseloom/files/order_codec.h"

namespace noiseloom {

// The number of this algorithm, and of how samples follow from the order: raised in the same commit as any change after
// which an unchanged config gives another /order or other /samples (tests/program/pinned_samples_test.py notices). A
// run file keeps it, and a run of another number is not gone on with.
//   2: without an initial pattern unless the config asks for one
inline constexpr std::int64_t void_and_cluster_algorithm = 2;

// Throws UserError listing everything that is wrong with `spec`.
void check_vac_spec(const VacSpec& spec);

// Energies are in units of 2^-this: the largest of at most 30 that leaves bit 31 free whichever pixels are on.
int vac_scale_log2(const VacSpec& spec);

// How the pixels are divided among the threads of `ranks` ranks: by slices, or by bands of the rows of a single large
// slice, whose fields then go through the caches window by window.
struct VacDivision {
  int workers;      // threads with pixels of their own
  bool by_windows;  // also where the slice is so large that one thread alone goes through windows
};
VacDivision vac_division(const VacSpec& spec, int ranks, int threads);

// The keyed hash that breaks ties of energy. For positions below 2^32 it is a bijection, so no two are equal.
class VacTieHash {
 public:
  explicit VacTieHash(std::uint64_t seed);
  std::uint32_t operator()(std::uint64_t position) const {
    const auto high = static_cast<std::uint32_t>(position >> 32);
    const std::uint32_t inner = mix(static_cast<std::uint32_t>(position) + key0_);
    return mix((inner ^ key1_) + high * 0x9E3779B9U);
  }

 private:
  // A bijection of 32 bits: odd multiplications and xor-shifts.
  static std::uint32_t mix(std::uint32_t x) {
    x = (x ^ (x >> 16)) * 0x7FEB352DU;
    x = (x ^ (x >> 15)) * 0x846CA68BU;
    return x ^ (x >> 16);
  }
  std::uint32_t key0_;
  std::uint32_t key1_;
};

// floor(density * pixels)
std::int64_t vac_num_start_points(const VacSpec& spec);
// Positions (ascending) of the random pattern that the swap phase starts from: so many distinct pixels.
std::vector<std::uint64_t> vac_start_pattern(const VacSpec& spec);

enum class VacPhase : std::int32_t { swap = 0, drain = 1, fill = 2, done = 3 };

// With the order, everything that a run is between any two picks. Energies are not part of it: they follow exactly from
// the pixels that are on, which are the marked ones (swap, drain) or those with a place (fill).
struct VacProgress {
  VacPhase phase = VacPhase::swap;
  std::int64_t num_start_points = 0;
  std::int64_t num_swaps = 0;
  std::int64_t num_placed = 0;  // pixels that have their place
  friend bool operator==(const VacProgress&, const VacProgress&) = default;
};

// One texture over ranks and threads; slices in contiguous blocks (core/partition.h). The order does not depend on
// either.
class VoidAndCluster {
 public:
  // Throws UserError where check_vac_spec does. Communicator and pool must outlive it.
  VoidAndCluster(const VacSpec& spec, const Communicator& communicator, ThreadPool& pool);
  ~VoidAndCluster();
  VoidAndCluster(const VoidAndCluster&) = delete;
  VoidAndCluster& operator=(const VoidAndCluster&) = delete;

  void start();  // *Collective*
  // Goes on from a run of the same spec. `order(slice)`: the bytes of an own slice as order() gave them. Throws
  // SharedUserError when order and progress do not belong together, and on all ranks what it throws on one.
  // *Collective*
  void restore(const VacProgress& progress, const std::function<std::vector<std::byte>(SliceIndex)>& order);
  // Does up to `max_picks` >= 1 picks (a swap counts as one); fewer only when done. How the picks are divided among
  // calls changes the time alone: picks are taken in batches of up to about a hundredth of the pixels, and what a
  // smaller `max_picks` leaves of one the next call goes on with. *Collective*
  void advance(std::int64_t max_picks);
  // The most picks that are taken at once from here on, >= 1; changes the time alone. The same on every rank.
  void limit_batches(std::int64_t max_picks);
  bool done() const { return progress().phase == VacPhase::done; }
  const VacProgress& progress() const;  // the same on every rank
  const Partition& partition() const;

  // The places of an own slice, [y][x], and marks where pixels have none yet: the bytes of /order, which codec() reads.
  std::vector<std::byte> order(SliceIndex slice) const;
  OrderCodec codec() const;

  std::int64_t collectives() const;  // MPI's, by this rank since it was made; none when it is alone
  std::int64_t bytes_sent() const;   // that this rank gave to them

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace noiseloom
