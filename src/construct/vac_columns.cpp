#include "construct/vac_columns.h"

#include <algorithm>

namespace noiseloom {

std::optional<VacColumns> VacColumns::make(const VacLayout& layout, const VacGroupKernel& group) {
  constexpr std::int64_t most_taps = 1 << 22;
  if (group.axis0 < 2 || !group.others.empty()) return std::nullopt;
  std::int64_t taps = 0;
  for (const VacRow& row : group.rows) taps += row.lo + row.hi + 1;
  if (layout.num_slices > most_taps / std::max<std::int64_t>(taps, 1)) return std::nullopt;
  VacColumns result;
  const auto a = static_cast<std::size_t>(group.axis0);
  const std::int64_t step = layout.slice_step[a];
  const std::int64_t size = layout.size[a];
  result.step_ = step * layout.slice_words;
  result.ends_.push_back(0);
  for (std::int64_t slice = 0; slice < layout.num_slices; ++slice) {
    const std::int64_t at = slice / step % size;
    for (const VacRow& row : group.rows) {
      const std::uint32_t* const weights = group.weights.data() + row.first;
      bool goes_on = false;
      for (std::int64_t d = -row.lo; d <= row.hi; ++d) {
        std::int64_t to = at;
        const bool inside = layout.move(to, group.axis0, d);
        const std::int64_t reached = slice + (to - at) * step;
        const bool present = inside && layout.has_slice(reached);
        if (present && goes_on && to > 0) {
          ++result.runs_.back().count;
        } else if (present) {
          result.runs_.push_back({(reached - layout.slice_begin) * layout.slice_words, weights + d + row.lo, 1});
        }
        goes_on = present;
      }
    }
    result.ends_.push_back(static_cast<std::uint32_t>(result.runs_.size()));
  }
  return result;
}

}  // namespace noiseloom
