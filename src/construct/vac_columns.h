// The taps of a group along one slice axis alone, by the slice that they are seen from: which slices of a field they
// reach, with which weights.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "construct/vac_kernel.h"
#include "construct/vac_layout.h"

namespace noiseloom {

class VacColumns {
 public:
  // Nothing for other groups, and where slices and taps are so many that the table would be large.
  static std::optional<VacColumns> make(const VacLayout& layout, const VacGroupKernel& group);

  // Calls visit(word, weight) for the taps of one pixel, of any slice, in the words of the field.
  template <class Visit>
  void visit(const VacPlace& place, std::uint32_t* data, const Visit& visit) const {
    const std::uint32_t end = ends_[static_cast<std::size_t>(place.slice) + 1];
    for (std::uint32_t i = ends_[static_cast<std::size_t>(place.slice)]; i < end; ++i) {
      const Run& run = runs_[i];
      std::uint32_t* word = data + run.first_word + place.cell;
      const std::uint32_t* weight = run.weights;
      for (std::uint32_t left = run.count; left > 0; --left, word += step_) visit(*word, *weight++);
    }
  }

 private:
  // Slices one step apart that are all in the field.
  struct Run {
    std::int64_t first_word;
    const std::uint32_t* weights;
    std::uint32_t count;
  };
  std::int64_t step_ = 0;            // in words
  std::vector<std::uint32_t> ends_;  // by slice: where its runs end, after a 0
  std::vector<Run> runs_;
};

}  // namespace noiseloom
