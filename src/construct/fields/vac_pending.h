// Picks in a large slice whose weights have not been added to the field yet.
//
// Energies only rise while pixels are turned on, so a leaf need not know of a pick before it is opened by a scan: its
// bound stays one. Adding a pick to all rows around it at once would fetch some fifty cache lines from memory for two
// additions each. So picks wait here, and a leaf is brought up to date when it is opened: its four lines are fetched
// once for all picks since it was opened last. Sums of integers are the same in any order.
//
// Picks wait in bins of 64 x 16 pixels, each one cache line of 16 entries. Picks go in by batches, and a leaf remembers
// which batch it is up to.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "construct/fields/vac_layout.h"

namespace noiseloom {

class VacPending {
 public:
  // An entry: batch, y and x within the bin. Batches begin at 1, so that an empty place has a batch that no leaf asks
  // for.
  static constexpr int x_bits = 6;
  static constexpr int y_bits = 4;
  static constexpr std::size_t bin_size = 16;
  struct alignas(64) Bin {
    std::uint32_t entries[bin_size];
  };
  // Nothing where no group is over x and y alone, where the footprint could meet a bin from both sides of the torus, or
  // where it is so large that its weights would not stay in the first cache.
  static std::optional<VacPending> make(const VacLayout& layout, const VacKernel& kernel);

  static bool waits(const VacGroupKernel& group) { return group.is_of_plane(); }

  // A pixel of a slice that is present. False where its bin is full: then it must be added to the field at once.
  bool add(const VacLayout& layout, const VacPlace& place) {
    const std::int64_t y = place.cell / layout.size[0];
    const std::int64_t x = place.cell % layout.size[0];
    const auto i = static_cast<std::size_t>((place.slice - layout.slice_begin) * bins_per_slice +
                                            (y >> y_bits) * bins_per_row + (x >> x_bits));
    if (counts_[i] == bin_size) return false;
    bins[i].entries[counts_[i]++] =
        static_cast<std::uint32_t>((batch << (x_bits + y_bits)) | (y % 16 << x_bits) | x % 64);
    ++num_waiting_;
    return true;
  }
  void end_batch() { ++batch; }
  // So many that most of the bins would soon be full, which fill alike as picks keep apart (4096x4096 takes 12.8 s
  // where they may be half full, 12.3, 12.2 and 13.0 s with 12, 13 and 14 of 16); or so many batches that an entry
  // could not hold their number.
  bool is_full() const { return num_waiting_ > bins.size() * (bin_size - 3) || batch >= (1 << 21); }
  bool empty() const { return num_waiting_ == 0; }
  void clear();  // after all leaves were brought up to date

  // For the vector loops (vac_pending-inl.h). Of all groups that wait together: row reach_y + dy of `weights` holds the
  // weight at (dx, dy) in column first_column + dx, with zeros around, so that the weights of any 64 pixels in a row
  // that are not out of reach are 64 words of it.
  std::vector<std::uint32_t> weights;
  std::int64_t reach_x = 0;
  std::int64_t reach_y = 0;
  std::int64_t first_column = 0;
  std::int64_t row_words = 0;
  std::int64_t bins_per_row = 0;
  std::int64_t bins_per_slice = 0;
  std::int64_t batch = 1;
  std::vector<Bin> bins;
  std::vector<std::uint32_t> up_to;  // of each leaf: the first batch that it does not have

 private:
  VacPending() = default;
  std::vector<std::uint8_t> counts_;
  std::size_t num_waiting_ = 0;
};

}  // namespace noiseloom
