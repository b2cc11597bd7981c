// The slices of one rank, in as many parts as there are threads to work on them. Parts are contiguous blocks of slices
// and never write to each other, so the number of threads cannot change anything.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "construct/vac_field.h"
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
  // Nothing where the pixel is another rank's.
  void lower_bound_to(std::uint64_t position, std::uint32_t value) {
    if (has(position)) part_of(position).lower_bound_to(position, value);
  }

 private:
  VacField& part_of(std::uint64_t position);

  ThreadPool& pool_;
  std::vector<VacField> parts_;
  std::vector<std::uint64_t> part_ends_;
  std::uint64_t begin_;
  std::uint64_t end_;
};

}  // namespace noiseloom
