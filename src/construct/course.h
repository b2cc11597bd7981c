// The course of a construction: what its rounds do to the places of pixels, and how many picks are left. All that
// follows from the progress and needs no energies.
#pragma once

#include <cstdint>
#include <vector>

#include "noiseloom/construct/slice_construction.h"

namespace noiseloom {

// What the picks of one visit did, in their order. Of an exchange and of a swap, off and on go in pairs.
struct Changes {
  std::vector<std::uint32_t> off;
  std::vector<std::uint32_t> on;
};

class Course {
 public:
  Course(std::int64_t cells, SampleScale scale);

  bool is_circular() const { return scale_ == SampleScale::circle; }
  std::int64_t points_per_visit() const { return points_; }
  // Where every slice begins, with so many pixels on where it is not circular.
  ConstructProgress start(std::int64_t num_start_points) const;
  std::int64_t picks_of_visit(const ConstructProgress& progress) const;
  // After which relaxing ends though swaps are left.
  std::int64_t most_rounds_of_relax(const ConstructProgress& progress) const;
  // After a round of any phase but relax.
  std::int64_t num_placed_after(const ConstructProgress& progress) const;
  // Pixels of a slice that are on and have no place.
  std::int64_t num_on(const ConstructProgress& progress) const;

  // What a visit did to the places of its slice.
  void carry_out(const ConstructProgress& progress, const Changes& changes, std::vector<std::uint32_t>& places) const;
  // Whether a pixel counts in the energies, going by its entry in places().
  static bool is_on(const ConstructProgress& progress, std::uint32_t entry);
  double fraction(const ConstructProgress& progress) const;

 private:
  std::int64_t cells_;
  SampleScale scale_;
  std::int64_t points_;  // a visit
};

// Of the exchange phase: pixels that have been turned off, and on, and so have their places.
struct Exchanged {
  explicit Exchanged(const ConstructProgress& progress);
  std::int64_t off;
  std::int64_t on;
};

}  // namespace noiseloom
