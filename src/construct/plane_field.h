// The energies of one slice, with its pixels that are on marked, and the next pick among them.
//
// Words, views and ties are those of void and cluster (vac_field.h): a word is an energy, with vac_flag where the pixel
// is on; through the view a smaller value is picked earlier, equal ones by the keyed hash of the position, then by the
// cell. What differs is that picks are looked for in this slice alone.
//
// A lower bound of the smallest value of every leaf (64 neighbouring cells) and of every branch (64 leaves) leads to
// the pick. While pixels are only turned on (voids) or only off (clusters), values of that view only rise, so bounds
// hold without any work and are mended where a pick opens them. Where values also fall (points that are swapped,
// kernels with negative weights) the leaves in reach of a change are looked at anew.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "construct/fields/vac_field.h"
#include "construct/stamp_kernel.h"

namespace noiseloom {

// Whether pixels can be retired: then they are picked through neither view, and stay on or off. It takes a bit more of
// a word: of a pixel that is retired, bit 30 is not as bit 31, and the other way round of one that is not. So either
// view sees those that it may pick below 2^30, and all others above.
enum class Retiring { no, yes };
constexpr int energy_bits(Retiring retiring) { return retiring == Retiring::yes ? 30 : 31; }

class PlaneField {
 public:
  // Takes up memory; clear() comes first. The kernel, whose energies must take no more than energy_bits(retiring), must
  // outlive the field. `first_position`: of cell 0, for ties.
  PlaneField(const StampKernel& kernel, const VacTieHash& hash, std::uint64_t first_position,
             Retiring retiring = Retiring::no);

  // All off, and all energies those of an empty texture.
  void clear();
  // Pixels of another slice, which lies so far off that `stamp` leads from it to this one, are turned on (off).
  void act(const SliceStamp& stamp, bool on, std::span<const std::uint32_t> cells);
  // A pixel of this slice. Requires that it is off (on).
  void turn_on(std::uint32_t cell);
  void turn_off(std::uint32_t cell);
  // A pixel that is turned on (off) right after it.
  void retire(std::uint32_t cell) { words_[cell] ^= retired_bit_; }
  // A pixel that is off is not picked while it is closed. It may be opened to be turned on right after it, or to be
  // picked again.
  void close(std::uint32_t cell);
  void open(std::uint32_t cell) { retire(cell); }
  void reopen(std::uint32_t cell);
  void open_all();
  bool is_on(std::uint32_t cell) const { return (words_[cell] & vac_flag) != 0; }
  std::uint32_t word(std::uint32_t cell) const { return words_[cell]; }

  // From here on picks are asked for through these views; only while this was said do bounds cost time.
  void watch(bool voids, bool clusters);
  // The pixel that is off (voids) or on (clusters) with the least key; nothing where there is none. Requires that the
  // view is watched.
  std::optional<std::uint32_t> pick(VacView view);

 private:
  // The cell of a leaf that would be picked, as long as the epoch is that of the field: until something may have
  // changed. Else every pick would compare all cells of equal value anew, and where points lie out of each other's
  // reach nearly all have one.
  struct Winner {
    std::uint32_t hash = 0;
    std::uint32_t cell = 0;
    std::uint32_t epoch = 0;
  };
  struct Bounds {
    bool watched = false;
    bool stale = true;  // everything has to be looked at anew
    std::vector<std::uint32_t> leaves;
    std::vector<std::uint32_t> branches;
    std::vector<Winner> winners;  // by leaf
  };
  static std::size_t index(VacView view) { return view == VacView::voids ? 0 : 1; }
  void refresh(VacView view);
  std::uint32_t least_of_leaf(std::size_t leaf, VacView view) const;
  Winner winner_of(std::size_t leaf, VacView view, std::uint32_t value) const;
  template <class Visit>
  void each_leaf_in_reach(std::uint32_t cell, const Visit& visit) const;
  void look_again(std::uint32_t cell);
  bool may_fall(VacView view, bool on) const;

  const StampKernel& kernel_;
  VacTieHash hash_;
  std::uint64_t first_position_;
  std::uint32_t on_bits_;      // what turning a pixel on or off changes
  std::uint32_t retired_bit_;  // 0 where none can be retired
  std::uint32_t pickable_;     // views see the pixels that they may pick below this
  std::uint32_t cells_;
  std::size_t num_leaves_;
  VacWords words_;  // the plane, filled up to whole leaves, and a vector behind it
  Bounds bounds_[2];
  std::uint32_t epoch_ = 1;  // of what other slices did
};

}  // namespace noiseloom
