#include "construct/vac_portion.h"

#include <algorithm>

namespace noiseloom {

VacLineSorter::VacLineSorter(const VacLayout& layout, const VacKernel& kernel)
    : cells_(layout.cells),
      needed_(std::any_of(kernel.groups().begin(), kernel.groups().end(),
                          [](const VacGroupKernel& group) { return !group.contains_x(); })) {}

void VacLineSorter::sort(std::span<const std::uint64_t> positions, std::vector<VacPlace>& by_line) {
  by_line.clear();
  if (!needed_) return;
  places_.clear();
  for (const std::uint64_t position : positions) {
    const auto p = static_cast<std::int64_t>(position);
    places_.push_back({p % cells_, p / cells_});
  }
  const auto num_lines = static_cast<std::size_t>(cells_ / VacLayout::line_words + 1);
  by_line.resize(places_.size());
  if (num_lines > 8 * places_.size()) {
    by_line = places_;
    std::sort(by_line.begin(), by_line.end(),
              [](const VacPlace& a, const VacPlace& b) { return line_of(a) < line_of(b); });
    return;
  }
  line_ends_.assign(num_lines + 1, 0);
  for (const VacPlace& place : places_) ++line_ends_[static_cast<std::size_t>(line_of(place)) + 1];
  for (std::size_t i = 0; i < num_lines; ++i) line_ends_[i + 1] += line_ends_[i];
  for (const VacPlace& place : places_) by_line[line_ends_[static_cast<std::size_t>(line_of(place))]++] = place;
}

}  // namespace noiseloom
