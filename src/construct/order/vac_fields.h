// The slices of one rank, in parts for threads to work on. Parts are contiguous blocks of slices and never write to
// each other, so neither their number nor that of threads can change anything.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <span>
#include <vector>

#include "construct/order/vac_field.h"
#include "construct/order/vac_portion.h"
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
  // Calls body(part, index of the part), in parallel; each thread begins with its own.
  void for_each(const std::function<void(VacField&, std::size_t)>& body);

  // See VacField. Positions of pixels of any rank.
  void clear();
  void turn_on(std::span<const std::uint64_t> positions);
  void refresh_bounds(VacView view);

  // Whether there are other threads, and parts for them.
  bool has_helpers() const { return pool_.num_threads() > 1 && parts_.size() > 1; }
  static constexpr std::size_t most_portions = 16;
  struct Picks {
    std::function<bool(VacPortion&)> next;
    std::function<void(VacPortion&)> all;
    std::function<void(const VacPortion&, std::size_t first, std::size_t last)> turned;
  };
  // Turns on (off) the pixels of one batch. `next` fills in positions and numbers of the next picks, or returns false;
  // it is called on the calling thread, at most `most_portions` times, and then `all`, which fills in those of all of
  // them. `turned` hears, on any thread, of a part's own pixels of a portion: [first, last) of it. `streamed`, which
  // requires has_helpers(): the other threads turn the portions that there are while the next ones are picked.
  // Otherwise `next` is not called, and `all` picks; this costs less for few picks. At the end all is done, and each
  // part has made the scan `then` or, without one, has ended its batch. Where a call throws, parts are left behind half
  // done, and the exception goes on.
  void turn_as_they_come(bool on, bool streamed, const Picks& picks, const VacScan* then);

 private:
  // Slices are in more parts than there are threads, and each part is of one of them, in whose caches its words are. A
  // thread with nothing left to do in a batch that is streamed makes parts of others its own, so that the one that
  // picks ends up with fewer.
  struct Progress {
    std::atomic<int> owner{0};
    std::atomic<bool> taken{false};        // by a thread that works on it
    std::atomic<std::size_t> num_done{0};  // portions
    std::atomic<bool> ended{false};        // with all of them
  };
  VacField& part_of(std::uint64_t position);
  void hand_on(bool streamed, const Picks& picks);
  void turn(std::size_t part, bool on, const VacPortion& portion, const Picks& picks, const VacScan* then);
  bool bring_up(std::size_t part, bool on, const Picks& picks, const VacScan* then);
  bool lend_a_hand(bool on, int worker, const Picks& picks, const VacScan* then);
  void help_to_the_end(bool on, int worker, const Picks& picks, const VacScan* then);
  bool all_ended() const;

  ThreadPool& pool_;
  VacLayout layout_;
  std::vector<VacField> parts_;
  std::vector<Progress> progress_;
  std::array<VacPortion, most_portions> portions_;
  VacPortion whole_;                          // all of them
  std::atomic<std::size_t> num_portions_{0};  // that have come
  std::atomic<bool> complete_{false};         // no more will come
  std::atomic<bool> failed_{false};           // a thread has thrown: nobody waits for its part
  std::vector<std::uint64_t> part_ends_;
  std::uint64_t begin_;
  std::uint64_t end_;
};

}  // namespace noiseloom
