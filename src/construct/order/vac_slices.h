// The slices of one rank, in parts for threads to work on. Parts are contiguous blocks of slices and never write to
// each other, so neither their number nor that of threads can change anything. Of one large slice, threads go through
// windows (vac_windows.h).
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "construct/fields/vac_field.h"
#include "construct/fields/vac_portion.h"
#include "construct/fields/vac_work.h"
#include "construct/order/vac_windows.h"

namespace noiseloom {

class VacSlices {
 public:
  // Slices [begin, end). Kernel and pool must outlive the fields.
  VacSlices(const VacSpec& spec, const VacKernel& kernel, std::int32_t begin, std::int32_t end, ThreadPool& pool);

  // Where threads go through windows of the only slice: then its picks are taken by them.
  VacWindows* windows() { return windows_ ? &*windows_ : nullptr; }

  std::size_t num_parts() const { return parts_.size(); }
  VacField& part(std::size_t i) { return parts_[i]; }
  std::size_t num_leaves() const;
  // Own positions.
  std::uint64_t begin() const { return begin_; }
  std::uint64_t end() const { return end_; }
  bool has(std::uint64_t position) const { return position >= begin_ && position < end_; }
  // Requires has(position).
  std::uint32_t word(std::uint64_t position) { return part_of(position).word(position); }
  // Calls body(part, index of the part), in parallel.
  void for_each(const std::function<void(VacField&, std::size_t)>& body);

  // See VacField. Positions of pixels of any rank.
  void clear();
  void turn_on(std::span<const std::uint64_t> positions);
  void refresh_bounds(VacView view);

  // Turns on (off) the pixels of one batch. `turned` hears, on any thread, of a part's own pixels of it:
  // [first, last). With `is_last`, no more of the batch follow: then each part makes the scan `then` or, without one,
  // ends its batch. Where a call throws, parts are left behind half done, and the exception goes on.
  using Turned = std::function<void(std::size_t first, std::size_t last)>;
  void turn_batch(bool on, VacPortion& portion, const Turned& turned, bool is_last, const VacScan* then);

 private:
  VacField& part_of(std::uint64_t position);

  VacLayout layout_;
  std::vector<VacField> parts_;
  std::optional<VacWindows> windows_;
  std::optional<VacWork> work_;  // by parts
  std::vector<std::uint64_t> part_ends_;
  std::uint64_t begin_;
  std::uint64_t end_;
};

}  // namespace noiseloom
