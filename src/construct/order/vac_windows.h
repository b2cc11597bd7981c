// The order of one large slice, window by window.
//
// The least key of a neighbourhood is picked, whatever happens elsewhere: keys only rise, so nothing that is picked
// later can come before it. So a window of rows can run ahead of the rest of the slice, and stays in the caches while
// it does, unless its rows are very long: the field, which is larger than any cache, goes through memory once for many
// batches of a window instead of once for each. A candidate that has a lesser one in its footprint whose own
// surroundings are not seen has to wait (vac_selector.h), and from it on rows are left to the next window.
//
// Threads go through bands of rows, from the first window to the last. They neither read nor write beyond their bands,
// so that what lies on the edges is left over; windows around the edges pick that, and one selector for the whole slice
// whatever may be left then. Where windows and bands lie cannot change anything: the order is that of the keys.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "construct/bins/vac_selector.h"
#include "construct/fields/vac_field.h"
#include "construct/fields/vac_work.h"

namespace noiseloom {

class VacWindows {
 public:
  struct Sizes {
    int bands;
    std::int64_t rows;   // of a window
    std::int64_t picks;  // of a batch of the whole slice, about
  };
  // Nothing where the texture is not one slice, a group is not over x and y alone, or the slice is so small that it
  // does not pay.
  static std::optional<Sizes> sizes(const VacLayout& layout, const VacKernel& kernel, int num_threads);

  // The field is that of all rows of the slice. Kernel, field and pool must outlive the windows.
  VacWindows(const VacSpec& spec, const VacKernel& kernel, const Sizes& sizes, VacField& field, ThreadPool& pool);

  // Turns on some pixels, ascending. Requires bands six times as high as footprints reach, as those of sizes() are.
  void turn_on(std::span<const std::uint64_t> positions);
  // To be called before take(), where pixels were turned by others or the other way. Bounds must be right.
  void restart();
  // Turns on (off) the next picks and says which they are, in their order: about as many as wanted, few after
  // restart(), none when no pixel is left. Valid until the next call.
  std::span<const std::uint64_t> take(VacView view);
  // How many of them windows left over.
  std::size_t num_left_over() const { return num_left_over_; }

 private:
  // Rows [begin, end). Those below 0 stand for the last ones, around the torus.
  struct Rows {
    std::int64_t begin;
    std::int64_t end;
    std::int64_t size() const { return end - begin; }
  };
  // Picks are taken in `own` rows; `seen` has all that reach them.
  struct Window {
    Rows seen;
    Rows own;
  };
  struct Pick {
    std::uint64_t key;
    std::uint64_t position;
  };
  // What a thread works with. Aligned, as each thread writes to one.
  struct alignas(64) Worker {
    Worker(const VacSpec& spec, const VacKernel& kernel) : selector(spec, kernel, false) {}
    VacSelector selector;
    std::vector<VacCandidate> found;  // with positions in the window
    std::vector<std::uint32_t> sample;
    std::vector<bool> is_picked;
    std::vector<std::uint64_t> positions;
    std::vector<Pick> picks;
  };

  std::int64_t leaf_begin(std::int64_t row) const;
  std::int64_t leaf_end(std::int64_t row) const;
  template <class Visit>
  void each_run(const Rows& rows, const Visit& visit) const;
  std::optional<std::uint32_t> low_bound(const Rows& rows, std::uint32_t least, std::size_t num_samples,
                                         std::vector<std::uint32_t>& sample) const;
  std::uint64_t find(const Rows& rows, std::uint64_t after, Worker& worker);
  std::uint64_t position_of(const Rows& rows, std::uint64_t position_in_rows) const;
  void give_back(const Rows& rows, std::span<const VacCandidate> found);
  void turn(std::span<const std::uint64_t> positions, bool on);
  Window pick_in(Window window, Worker& worker);
  void pick_in_band(std::size_t band);
  void pick_around_begin_of(std::size_t band);
  void sort_picks();

  const VacKernel& kernel_;
  VacField& field_;
  const VacLayout& layout_;
  VacTieHash hash_;
  std::int64_t reach_ = 0;
  // What picks write to may end past the rows that they reach: whole vectors go on in the next row, which they leave as
  // it is.
  std::int64_t reach_of_vectors_;
  std::int64_t row_step_;
  std::int64_t window_rows_;
  std::int64_t wanted_picks_;
  std::vector<std::int64_t> band_rows_;  // the first row of each; then how many there are
  std::vector<Worker> workers_;          // of each band
  Worker rest_;
  VacWork work_;

  VacView view_ = VacView::voids;
  bool is_fresh_ = true;
  std::uint32_t limit_ = 0;  // energies up to this one are picked
  std::uint32_t step_ = 0;
  std::size_t num_left_over_ = 0;
  std::vector<Pick> picks_;
  std::vector<std::size_t> buckets_;
  std::vector<Pick> sorted_;
  std::vector<std::uint64_t> positions_;
};

}  // namespace noiseloom
