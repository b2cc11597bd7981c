#include "optimize/vac_swapper.h"

#include <algorithm>

namespace noiseloom {
namespace {

// For a heap with the least key at the front.
bool later(const VacCandidate& a, const VacCandidate& b) {
  return a.key() != b.key() ? a.key() > b.key() : a.position > b.position;
}

}  // namespace

VacSwapper::VacSwapper(VacField& field, const VacTieHash& hash) : field_(field), hash_(hash) {}

void VacSwapper::fill(Side& side) {
  constexpr double fraction = 0.25;
  field_.refresh_bounds(side.view);
  const std::size_t max_found = std::max<std::size_t>(4096, field_.bounds().size());
  side.limit = vac_find_candidates(field_, side.view, hash_, fraction, max_found, side.heap);
  std::make_heap(side.heap.begin(), side.heap.end(), later);
}

void VacSwapper::offer(Side& side, std::uint64_t position) {
  const auto flip = static_cast<std::uint32_t>(side.view);
  const VacCandidate now{position, field_.word(position) ^ flip, hash_(position) ^ flip};
  if (now.key() > side.limit) return;
  side.heap.push_back(now);
  std::push_heap(side.heap.begin(), side.heap.end(), later);
}

std::uint64_t VacSwapper::take(Side& side) {
  while (true) {
    while (!side.heap.empty()) {
      std::pop_heap(side.heap.begin(), side.heap.end(), later);
      const VacCandidate top = side.heap.back();
      side.heap.pop_back();
      const std::uint32_t value = field_.word(top.position) ^ static_cast<std::uint32_t>(side.view);
      if (value == top.energy) return top.position;
      if (value > top.energy) offer(side, top.position);  // a smaller value has an entry of its own
    }
    fill(side);
  }
}

std::optional<VacSwapper::Swap> VacSwapper::next() {
  const std::uint64_t from = take(clusters_);
  hits_.clear();
  field_.turn_off_watching(from, static_cast<std::uint32_t>(voids_.limit >> 32), hits_);
  for (const std::uint64_t position : hits_) offer(voids_, position);
  offer(voids_, from);
  const std::uint64_t to = take(voids_);
  hits_.clear();
  field_.turn_on_watching(to, ~static_cast<std::uint32_t>(clusters_.limit >> 32), hits_);
  for (const std::uint64_t position : hits_) offer(clusters_, position);
  offer(clusters_, to);
  if (from == to) return std::nullopt;
  return Swap{from, to};
}

}  // namespace noiseloom
