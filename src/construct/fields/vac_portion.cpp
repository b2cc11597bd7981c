#include "construct/fields/vac_portion.h"

#include <limits>

namespace noiseloom {

void VacPortion::divide(const VacLayout& layout) {
  cells.clear();
  slices.clear();
  slice_begins.clear();
  constexpr std::int64_t most = std::numeric_limits<std::uint32_t>::max();
  const auto count = static_cast<std::int64_t>(positions.size());
  if (count < layout.num_slices || count > most || layout.cells > most) return;
  const auto size = static_cast<std::uint64_t>(layout.cells);
  std::uint64_t begin = 0;
  for (std::int64_t slice = 0; slice < layout.num_slices; ++slice, begin += size) {
    slice_begins.push_back(static_cast<std::uint32_t>(cells.size()));
    while (cells.size() < positions.size() && positions[cells.size()] - begin < size) {
      cells.push_back(static_cast<std::uint32_t>(positions[cells.size()] - begin));
      slices.push_back(static_cast<std::uint32_t>(slice));
    }
  }
  slice_begins.push_back(static_cast<std::uint32_t>(cells.size()));
}

}  // namespace noiseloom
