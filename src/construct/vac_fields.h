// The slices of one rank, in as many parts as there are threads to work on them. Parts are contiguous blocks of slices
// and never write to each other, so neither their number nor that of threads can change anything.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <span>
#include <vector>

#include "construct/vac_field.h"
#include "construct/vac_portion.h"
#include "noiseloom/core/parallel.h"

namespace noiseloom {

class VacFields {
 public:
  // Slices [begin, end). Kernel and pool must outlive the fields.
  VacFields(const VacSpec& spec, const VacKernel& kernel, std::int32_t begin, std::int32_t end, ThreadPool& pool);

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
  void turn_off(std::span<const std::uint64_t> positions);
  void refresh_bounds(VacView view);

  // Turns pixels on (off) while they are still being picked: calls next(portion) on the calling thread until that fills
  // in no more, at most `most_portions` times, with positions and numbers; the threads that have nothing to do turn
  // what has come. `turned` hears of the part's own pixels of a portion, [first, last) of it, from any thread. At the
  // end all is done, and the batch of each part ended. Where `next` throws, what came before is done and the exception
  // goes on.
  static constexpr std::size_t most_portions = 16;
  void turn_as_they_come(bool on, bool streamed, const std::function<bool(VacPortion&)>& next,
                         const std::function<void(const VacPortion&, std::size_t first, std::size_t last)>& turned);
  // Not `streamed`: all threads begin when all portions are there, which costs less for few picks. Streamed: requires
  // has_helpers().
  bool has_helpers() const { return pool_.num_threads() > 1 && parts_.size() > 1; }

 private:
  using Turned = std::function<void(const VacPortion&, std::size_t, std::size_t)>;
  // What a part has of the portions that have come.
  struct Progress {
    std::atomic<bool> taken{false};  // by a thread that works on it
    std::atomic<std::size_t> num_done{0};
    std::atomic<bool> ended{false};
  };
  VacField& part_of(std::uint64_t position);
  bool lend_a_hand(bool on, std::size_t start, const Turned& turned);
  bool all_ended() const;

  ThreadPool& pool_;
  std::vector<VacField> parts_;
  std::vector<Progress> progress_;
  VacLineSorter sorter_;
  std::array<VacPortion, most_portions> portions_;
  std::atomic<std::size_t> num_portions_{0};
  std::atomic<bool> complete_{false};
  std::vector<std::uint64_t> part_ends_;
  std::uint64_t begin_;
  std::uint64_t end_;
};

}  // namespace noiseloom
