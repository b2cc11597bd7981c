// Picks on their way into the fields: some that follow each other in the order, sorted the way fields want them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "construct/vac_kernel.h"
#include "construct/vac_layout.h"

namespace noiseloom {

struct VacPortion {
  std::vector<std::uint64_t> positions;  // ascending
  std::vector<std::uint32_t> numbers;    // of each: how many of its batch were picked before it
  std::vector<VacPlace> by_line;         // the same pixels by the cache line of their slices; see VacLineSorter
};

// Orders pixels by the cache line of their slices that they lie in, for the groups without x: pixels of one line reach
// the same lines along the slice axes.
class VacLineSorter {
 public:
  VacLineSorter(const VacLayout& layout, const VacKernel& kernel);

  static std::int64_t line_of(const VacPlace& place) { return place.cell / VacLayout::line_words; }
  // By counting, unless there are far more lines than pixels. Leaves `by_line` empty where no group needs it.
  void sort(std::span<const std::uint64_t> positions, std::vector<VacPlace>& by_line);

 private:
  std::int64_t cells_;
  bool needed_;
  std::vector<VacPlace> places_;
  std::vector<std::uint32_t> line_ends_;
};

}  // namespace noiseloom
