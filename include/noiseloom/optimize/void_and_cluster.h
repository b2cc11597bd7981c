// Void and cluster in any dimension: the order in which the pixels of a scalar mask are turned on.
//
// The energy of a pixel p is the sum over the pixels q != p that are on of K(p - q) [Ulichney 1993,
// doi:10.1117/12.152707; STBN22, sections 3.1 and 4.1, doi:10.2312/sr.20221161], with
//
//   K(d) = sum_g [d is zero on every axis outside group g] * prod_{a in g} k_a(d_a),   k_a(d) = exp(-d^2 / 2 sigma_g^2)
//
// On a toroidal axis k_a is summed over all images of d, so a footprint larger than the axis folds and nothing changes
// under a shift of the torus. Weights are fixed-point integers (optimize/vac_kernel.h in src): energies never drift.
//
// Three phases, each a sequence of picks at an extreme of the key (energy, keyed hash of the position, position), which
// is a total order:
//   swap   the pixel that is on with the largest key is turned off, then the one that is off with the smallest key is
//          turned on, until both are the same pixel. The sum of keys falls with every swap, so this ends.
//   drain  from the pattern of n points: the pixel on with the largest key gets rank n-1 and is turned off, and so on.
//   fill   from the pattern again: the pixel off with the smallest key gets the next rank and is turned on, until all
//          are. Beyond half this is the paper's third phase too: the tightest cluster of what is off is the emptiest
//          place of what is on, because the energies of the two add up to the same constant everywhere (on a torus).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "noiseloom/core/extents.h"

namespace noiseloom {

struct VacGroup {
  std::vector<int> axes;  // indices into Extents, each once
  double sigma_px = 1.9;
};

struct VacSpec {
  Extents extents;
  std::vector<VacGroup> groups;
  std::vector<bool> toroidal;  // per axis; empty: all
  double density = 0.10;       // fraction of pixels in the initial pattern (rounded down), [0, 0.5]
  std::uint64_t seed = 1;
};

// Throws UserError listing everything that is wrong with `spec`.
void check_vac_spec(const VacSpec& spec);

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

// Positions (ascending) of the random pattern that the swap phase starts from: floor(density * pixels) distinct pixels.
std::vector<std::uint64_t> vac_start_pattern(const VacSpec& spec);

// The rank of every pixel, x fastest (position = cell + cells_per_slice * slice). uint32 up to 2^32 - 2 pixels, else
// uint64: the two largest values mark pixels that have no rank yet.
class VacOrder {
 public:
  explicit VacOrder(std::int64_t num_cells);
  std::int64_t size() const { return wide() ? narrow_size(wide_) : narrow_size(narrow_); }
  bool wide() const { return narrow_.empty(); }

  bool has_rank(std::uint64_t position) const { return get(position) < on(); }
  bool is_on(std::uint64_t position) const { return get(position) == on(); }
  std::uint64_t rank(std::uint64_t position) const { return get(position); }
  void set_rank(std::uint64_t position, std::uint64_t rank) { set(position, rank); }
  void set_on(std::uint64_t position) { set(position, on()); }
  void set_off(std::uint64_t position) { set(position, on() + 1); }

  // The one that is not in use is empty.
  std::span<const std::uint32_t> narrow() const { return narrow_; }
  std::span<const std::uint64_t> wide_ranks() const { return wide_; }

  friend bool operator==(const VacOrder&, const VacOrder&) = default;

 private:
  template <class T>
  static std::int64_t narrow_size(const std::vector<T>& v) {
    return static_cast<std::int64_t>(v.size());
  }
  std::uint64_t on() const { return wide() ? ~std::uint64_t{1} : std::uint64_t{~std::uint32_t{1}}; }
  std::uint64_t get(std::uint64_t p) const { return wide() ? wide_[p] : narrow_[p]; }
  void set(std::uint64_t p, std::uint64_t value) {
    if (wide()) {
      wide_[p] = value;
    } else {
      narrow_[p] = static_cast<std::uint32_t>(value);
    }
  }

  std::vector<std::uint32_t> narrow_;
  std::vector<std::uint64_t> wide_;
};

enum class VacPhase : std::int32_t { swap = 0, drain = 1, fill = 2, done = 3 };

// Everything that a run is, between any two picks. Energies are not part of it: they follow exactly from the pixels
// that are on, which are the marked ones (swap, drain) or the ranked ones (fill).
struct VacState {
  VacPhase phase = VacPhase::swap;
  std::int64_t num_start_points = 0;
  std::int64_t num_swaps = 0;
  std::int64_t num_ranked = 0;
  VacOrder order;
};

class VoidAndCluster {
 public:
  // Requires a spec that check_vac_spec accepts.
  explicit VoidAndCluster(const VacSpec& spec);
  // Continues; `state` must come from a run of the same spec.
  VoidAndCluster(const VacSpec& spec, VacState state);
  ~VoidAndCluster();
  VoidAndCluster(VoidAndCluster&&) noexcept;
  VoidAndCluster& operator=(VoidAndCluster&&) noexcept;

  // Does up to `max_picks` >= 1 picks (a swap counts as one). How the picks are divided among calls changes the time
  // alone: picks are taken in batches of a few thousandths of the pixels, which a smaller `max_picks` cuts short.
  void advance(std::int64_t max_picks);
  bool done() const { return state().phase == VacPhase::done; }
  const VacState& state() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// The whole of it.
VacOrder void_and_cluster(const VacSpec& spec);

}  // namespace noiseloom
