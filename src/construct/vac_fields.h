// The slices of one rank, in as many parts as there are threads to work on them. Parts are contiguous blocks of slices
// and never write to each other, so the number of threads cannot change anything.
#pragma once

#include <array>
#include <chrono>
#include <functional>
#include <span>
#include <vector>

#include "construct/vac_field.h"
#include "noiseloom/core/parallel.h"

namespace noiseloom {

// Whether threads pay: where little is to be done between two points at which they wait for each other, or where other
// programs want the processors, one thread may be faster. Found out by trying both now and then, batch by batch, which
// changes nothing but the time.
class ThreadTrial {
 public:
  bool by_threads() const { return by_threads_; }
  void begin_batch();
  void end_batch(std::size_t num_picks);

 private:
  static constexpr std::int64_t batches_of_trial = 4;  // either way
  static constexpr std::int64_t shortest_stretch = 64;
  static constexpr std::int64_t longest_stretch = 1024;
  struct Tried {
    double seconds = 0;
    double picks = 0;
  };
  std::array<Tried, 2> tried_;  // one thread, threads
  std::int64_t batch_ = 0;      // of the stretch
  std::int64_t stretch_ = shortest_stretch;
  bool by_threads_ = true;
  bool better_ = true;
  std::chrono::steady_clock::time_point begun_;
};

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
  // Calls body(part, index of the part), in parallel unless one thread is faster.
  void for_each(const std::function<void(VacField&, std::size_t)>& body);
  // Whether for_each is in parallel now.
  bool by_threads() const { return trial_.by_threads(); }
  // Around the calls that belong together.
  void begin_batch() { trial_.begin_batch(); }
  void end_batch(std::size_t num_picks) { trial_.end_batch(num_picks); }

  // See VacField. Positions of pixels of any rank.
  void clear();
  void turn_on(std::span<const std::uint64_t> positions);
  void refresh_bounds(VacView view);

 private:
  VacField& part_of(std::uint64_t position);

  ThreadPool& pool_;
  ThreadTrial trial_;
  std::vector<VacField> parts_;
  std::vector<std::uint64_t> part_ends_;
  std::uint64_t begin_;
  std::uint64_t end_;
};

}  // namespace noiseloom
