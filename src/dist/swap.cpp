#include "noiseloom/dist/swap.h"

#include <numeric>
#include <utility>

namespace noiseloom {

std::vector<Swap> fewest_swaps(const std::vector<Swap>& swaps, std::int64_t num_cells) {
  std::vector<std::uint32_t> from(static_cast<std::size_t>(num_cells));  // where the sample of a cell was at first
  std::iota(from.begin(), from.end(), 0U);
  for (const Swap& swap : swaps) std::swap(from[swap.a], from[swap.b]);
  std::vector<Swap> fewest;
  for (std::uint32_t cell = 0; cell < from.size(); ++cell) {
    // Along a cycle, each swap brings one cell its sample; the last has it then too.
    for (std::uint32_t at = cell; from[at] != at;) {
      const std::uint32_t next = std::exchange(from[at], at);
      if (next != cell) fewest.push_back({at, next});
      at = next;
    }
  }
  return fewest;
}

}  // namespace noiseloom
