// The sequence in which the pixels of a mask are turned on: /order of a run file, and the point sets that it holds.
//
// The first k pixels of the sequence are the mask at density k / N, for every k: a progressive point set.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "noiseloom/core/index.h"
#include "noiseloom/files/order_codec.h"
#include "noiseloom/files/run_file.h"

namespace noiseloom {

// A place in the sequence. (An entry of /order may also be a mark: order_codec.h.)
using OrderPlace = Index<struct OrderPlaceTag, std::uint64_t>;

// /order of an open run file. `path` is for messages; the reader must outlive it.
class PixelOrder {
 public:
  // Throws UserError where the file holds no /order, or where pixels have no place yet (all of it is read).
  PixelOrder(const RunFileReader& reader, const std::string& path);

  std::int64_t num_pixels() const { return reader_.content().extents.num_cells(); }
  // The place of every cell of the slice, below num_pixels().
  void read_slice(SliceIndex slice, std::span<OrderPlace> places) const;

 private:
  const RunFileReader& reader_;
  int dataset_;
};

}  // namespace noiseloom
