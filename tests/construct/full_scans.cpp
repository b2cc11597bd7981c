#include "construct/full_scans.h"

#include <algorithm>

namespace noiseloom::oracle {

std::vector<std::uint64_t> picks_one_by_one(const VacSpec& spec, VacField field, VacView view) {
  const VacTieHash hash(spec.seed);
  const auto flip = static_cast<std::uint32_t>(view);
  const auto num_pixels = static_cast<std::uint64_t>(spec.extents.num_cells());
  std::vector<std::uint64_t> order;
  while (order.size() < num_pixels) {
    std::uint64_t best = 0;
    std::uint64_t best_key = ~std::uint64_t{0};
    for (std::uint64_t p = 0; p < num_pixels; ++p) {
      const std::uint32_t energy = field.words()[p] ^ flip;
      const std::uint64_t key = VacCandidate{p, energy, hash(p) ^ flip}.key();
      if (energy < vac_flag && key < best_key) {
        best = p;
        best_key = key;
      }
    }
    order.push_back(best);
    field.turn(view == VacView::voids, {best});
  }
  return order;
}

std::optional<std::uint32_t> pick_of(const PlaneField& field, std::uint32_t num_cells, const VacTieHash& hash,
                                     std::uint64_t first_position, VacView view) {
  const bool clusters = view == VacView::clusters;
  std::optional<std::uint32_t> best;
  const auto key = [&](std::uint32_t cell) {
    const std::uint64_t energy = field.word(cell) & ~vac_flag;
    return (energy << 32) | hash(first_position + cell);
  };
  for (std::uint32_t cell = 0; cell < num_cells; ++cell) {
    if (field.is_on(cell) != clusters) continue;
    if (!best || (clusters ? key(cell) > key(*best) : key(cell) < key(*best))) best = cell;
  }
  return best;
}

bool has_equals(const VacTieHash& hash, std::uint64_t num_pixels) {
  std::vector<std::uint32_t> values(num_pixels);
  for (std::uint64_t p = 0; p < num_pixels; ++p) values[p] = hash(p);
  std::sort(values.begin(), values.end());
  return std::adjacent_find(values.begin(), values.end()) != values.end();
}

}  // namespace noiseloom::oracle
