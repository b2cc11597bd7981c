// The energies of a range of slices, with the pixels that are on marked, and what void and cluster asks of them.
//
// A word per pixel: its energy, and vac_flag where it is on. Slices are padded to an odd number of cache lines, so that
// a pixel's neighbours along the slice axes do not all fall into the same set of the cache.
//
// The search sees a word through a view that makes "the next pick" the smallest value below vac_flag: voids read a word
// as it is, clusters read its complement (2^31 - 1 - energy where the pixel is on). A leaf is 64 neighbouring pixels of
// a slice; `bounds` holds a lower bound of its smallest value. While pixels are only turned on (voids) or only turned
// off (clusters) values only rise, so bounds stay bounds without any work; a scan refreshes those it opens.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "construct/fields/vac_kernel.h"
#include "construct/fields/vac_layout.h"
#include "construct/fields/vac_pending.h"
#include "construct/fields/vac_portion.h"

namespace noiseloom {

enum class VacView : std::uint32_t { voids = 0, clusters = 0xFFFFFFFFU };

// Smaller is picked earlier. Energy and hash are those of the view (complemented for clusters).
struct VacCandidate {
  std::uint64_t position;
  std::uint32_t energy;
  std::uint32_t hash;
  std::uint64_t key() const { return (std::uint64_t{energy} << 32) | hash; }
};

// Asks for the pixels with key <= `limit`, unless there are more than `max_found`.
struct VacScan {
  VacView view;
  VacTieHash hash;
  std::uint64_t limit;
  std::size_t max_found;
  std::int64_t shift = 0;  // added to the positions of what is found
};

struct VacFree {
  void operator()(void* memory) const;
};
using VacWords = std::unique_ptr<std::uint32_t[], VacFree>;
// Uninitialised; on huge pages where they are many. Throws std::bad_alloc.
VacWords allocate_words(std::size_t count);

class VacField {
 public:
  // `kernel` must outlive the field. Pixels wait where a slice has at least `cells_to_wait`: beyond what a third cache
  // holds.
  static constexpr std::int64_t usual_cells_to_wait = std::int64_t{1} << 22;
  VacField(const VacSpec& spec, const VacKernel& kernel, std::int32_t slice_begin, std::int32_t slice_end,
           std::int64_t cells_to_wait = usual_cells_to_wait);

  const VacLayout& layout() const { return layout_; }
  bool has(std::uint64_t position) const;
  // Energy and flag of a pixel of this field.
  std::uint32_t word(std::uint64_t position) {
    settle();
    return data_[index(position)];
  }

  // All words, slice by slice as the layout says, where nothing can wait.
  std::uint32_t* words() { return data_.get(); }

  // All off, all energies zero.
  void clear();
  // Pixels of any slices, ascending, after divide(); they act on the slices of this field. `then`: what scan() is to be
  // called with afterwards; done slice by slice, while they are in the second cache.
  void turn(bool on, const VacPortion& portion, const VacScan* then = nullptr);
  void turn(bool on, std::vector<std::uint64_t> positions);
  // [begin, end) of ascending positions: those of this field.
  std::pair<std::size_t, std::size_t> own(std::span<const std::uint64_t> positions) const;

  // Turns one pixel of any slice on (off) at once, and appends to `hits` the pixels of this field that are on (off) and
  // whose word thereby rose to at least (fell to at most) `limit`.
  void turn_on_watching(std::uint64_t position, std::uint32_t limit, std::vector<std::uint64_t>& hits);
  void turn_off_watching(std::uint64_t position, std::uint32_t limit, std::vector<std::uint64_t>& hits);

  // Recomputes all bounds for `view`.
  void refresh_bounds(VacView view);
  std::span<const std::uint32_t> bounds() const;
  std::span<std::uint32_t> bounds();
  // Finds what is asked for, or, where that is too much, some of it. What is found is left out of the bounds until the
  // next scan or end_of_batch() takes up again what was not picked.
  void scan(const VacScan& asked);
  // By the last scan, ascending in position; whether it is all.
  const std::vector<VacCandidate>& found() const { return found_; }
  bool found_all() const { return found_all_; }
  void end_of_batch();

 private:
  std::size_t index(std::uint64_t position) const;
  std::size_t leaf(std::uint64_t position) const;
  void settle();
  template <bool On>
  void turn_in_slice(std::span<const std::uint64_t> positions);
  template <bool On>
  void turn_all(const VacPortion& portion, const VacScan* then);
  void begin_scan(const VacScan& asked);
  void scan_slices(const VacScan& asked, std::int64_t begin, std::int64_t end);
  void take_back(const VacCandidate& candidate);
  template <bool On>
  void turn_one(std::uint64_t position, std::uint32_t limit, std::vector<std::uint64_t>& hits);

  VacLayout layout_;
  const VacKernel& kernel_;
  std::size_t num_words_;
  VacWords data_;
  std::vector<std::uint32_t> bounds_;
  std::optional<VacPending> pending_;
  std::vector<std::uint64_t> at_once_;  // of those of a slice: pixels that cannot wait
  VacView view_ = VacView::voids;       // of the last scan
  std::vector<VacCandidate> found_;
  std::vector<VacCandidate> found_before_;  // while a scan follows
  bool found_all_ = true;
  std::vector<std::size_t> watched_;
};

}  // namespace noiseloom
