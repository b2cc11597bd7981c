// The sequence in which the pixels of a mask are turned on: /order of a run file, and the point sets that it holds.
//
// The first k pixels of the sequence are the mask at density k / N, for every k: a progressive point set. Positions are
// cell + cells_per_slice * slice (core/extents.h).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "noiseloom/files/run_file.h"

namespace noiseloom {

// A fraction written in decimals, kept exactly: numerator / 10^decimals. Binary numbers would lose a point here and
// there (floor(0.29 * 100) is 28 in double).
struct DecimalFraction {
  std::uint64_t numerator = 0;
  int decimals = 0;
  std::int64_t floor_of_times(std::int64_t count) const;  // exact for every count
};

// "0.1", ".25", "1", "2e-3": in (0, 1], at most 18 decimals. Throws UserError naming `what` otherwise.
DecimalFraction parse_fraction(const std::string& what, const std::string& text);

// Why a run file with that content has no sequence; "" where it has one.
std::string why_no_order(const RunFileContent& content);

// /order of an open run file. `path` is for messages; the reader must outlive it.
class PixelOrder {
 public:
  // Throws UserError where the file holds no /order, or where pixels have no rank yet (all of it is read).
  PixelOrder(const RunFileReader& reader, const std::string& path);

  std::int64_t num_pixels() const { return reader_.content().extents.num_cells(); }
  // The rank of every cell of the slice, below num_pixels(); uint32 or uint64 in the file.
  void read_slice(SliceIndex slice, std::span<std::uint64_t> ranks) const;
  // The positions of the first `count` pixels, in their order. Throws UserError where /order is not a permutation.
  std::vector<std::uint64_t> first_pixels(std::int64_t count) const;

 private:
  void require_all_ranked() const;

  const RunFileReader& reader_;
  std::string path_;
  int dataset_;
};

}  // namespace noiseloom
