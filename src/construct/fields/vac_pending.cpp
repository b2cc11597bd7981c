#include "construct/fields/vac_pending.h"

#include <algorithm>

namespace noiseloom {

std::optional<VacPending> VacPending::make(const VacLayout& layout, const VacKernel& kernel) {
  constexpr std::int64_t largest_reach = 32;
  VacPending result;
  bool any = false;
  for (const VacGroupKernel& group : kernel.groups()) {
    if (!waits(group)) continue;
    any = true;
    for (const VacRow& row : group.rows) {
      result.reach_x = std::max<std::int64_t>({result.reach_x, row.lo, row.hi});
      result.reach_y = std::max<std::int64_t>(result.reach_y, std::abs(row.offset[0]));
    }
  }
  const auto fits = [](std::int64_t size, std::int64_t reach, int bits) {
    return reach <= largest_reach && size >= 2 * (reach + (std::int64_t{1} << bits)) + 64;
  };
  if (!any || !fits(layout.size[0], result.reach_x, x_bits) || !fits(layout.size[1], result.reach_y, y_bits)) {
    return std::nullopt;
  }
  result.first_column = 63 + result.reach_x;
  result.row_words = 2 * result.first_column + 1;
  result.weights.resize(static_cast<std::size_t>(result.row_words * (2 * result.reach_y + 1)));
  for (const VacGroupKernel& group : kernel.groups()) {
    if (!waits(group)) continue;
    for (const VacRow& row : group.rows) {
      const std::int64_t at = (row.offset[0] + result.reach_y) * result.row_words + result.first_column - row.lo;
      for (std::int64_t i = 0; i <= row.lo + row.hi; ++i) {
        result.weights[static_cast<std::size_t>(at + i)] += group.weights[row.first + static_cast<std::size_t>(i)];
      }
    }
  }
  result.bins_per_row = ((layout.size[0] - 1) >> x_bits) + 1;
  result.bins_per_slice = result.bins_per_row * (((layout.size[1] - 1) >> y_bits) + 1);
  const std::int64_t slices = layout.slice_end - layout.slice_begin;
  result.bins.resize(static_cast<std::size_t>(slices * result.bins_per_slice));
  result.counts_.resize(result.bins.size());
  result.up_to.resize(static_cast<std::size_t>(slices * layout.leaves));
  result.clear();
  return result;
}

void VacPending::clear() {
  std::fill(bins.begin(), bins.end(), Bin{});
  std::fill(counts_.begin(), counts_.end(), std::uint8_t{0});
  std::fill(up_to.begin(), up_to.end(), 1U);
  batch = 1;
  num_waiting_ = 0;
}

}  // namespace noiseloom
