// What turning a pixel on does to the energies of every slice, in fixed point, cut into rows.
//
// Construction wants a sharper kernel than the filter's overlap F (sharpness.h finds how sharp; gauss 1.3435 x ema: R
// 0.0523 with F, 0.0477 at its best): within the plane of every slice offset o it is
//
//   G(d, o) = F(c, o) * (|F(d, o)| / |F(c, o)|)^p        with the sign of F(d, o);  c: where |F(., o)| is largest
//
// for a product, and the same for the plane of every group of a sum before the groups are added up. So F is sharpened
// in space and not over slices. p = 1 is F itself.
//
// What is below 2^-12 of F(0) is left out. A weight is round(2^b * G / G(0)), with the largest b of at most 30 for
// which the magnitudes of all weights together stay below 2^31. An energy is `bias` (the magnitude of all negative
// weights together) plus a sum of weights over distinct offsets, so it stays within [0, 2^31) whichever pixels are on,
// and bit 31 of a word is free for a flag. Additions and removals cancel exactly, in any order.
#pragma once

#include <cstdint>
#include <vector>

#include "noiseloom/core/extents.h"
#include "noiseloom/problem/spec.h"

namespace noiseloom {

// Offsets of one slice offset that differ in x alone: dx from -lo to hi, |dx| < width; weights[first] belongs to -lo.
struct StampRow {
  std::int32_t dy;
  std::int32_t lo;
  std::int32_t hi;
  std::size_t first;
};

// The weights that lead from a slice to the one at `offset` (canonical: problem/footprint.h).
struct SliceStamp {
  Extents::SliceCoord offset{};
  std::vector<StampRow> rows{};
  // How far the rows reach. Where none is longer than a vector the stamp is narrow, and all rows go from -left to
  // right.
  std::int32_t left = 0;
  std::int32_t right = 0;
  std::int32_t up = 0;
  std::int32_t down = 0;
  bool is_narrow = true;
};

class StampKernel {
 public:
  // Rows of weights are filled up with zeros to a multiple of these, and as many follow the last row: a row that goes
  // on at the other side of the plane is read in two parts, of which the second begins anywhere in it.
  static constexpr std::size_t vector_words = 16;

  // Requires sharpness > 0. `energy_bits`: 31, or less where more bits of a word are wanted. Reads table files where
  // the spec does not hold their contents (UserError).
  StampKernel(const Extents& extents, const FilterSpec& filter, double sharpness, int energy_bits = 31);

  const Extents& extents() const { return extents_; }
  // By slice offset; the first is that of the slice itself, whose offset (0, 0) has weight 0. Stamps of other offsets
  // are not empty.
  const std::vector<SliceStamp>& stamps() const { return stamps_; }
  const std::vector<std::uint32_t>& weights() const { return weights_; }  // negative ones as 2^32 - magnitude
  std::uint32_t bias() const { return bias_; }
  // Whether turning a pixel on lowers no energy.
  bool is_monotone() const { return bias_ == 0; }
  int scale_log2() const { return scale_log2_; }

 private:
  Extents extents_;
  std::vector<SliceStamp> stamps_;
  std::vector<std::uint32_t> weights_;
  std::uint32_t bias_ = 0;
  int scale_log2_ = 0;
};

}  // namespace noiseloom
