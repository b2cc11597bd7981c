#include "construct/order/vac_swapper.h"

#include <algorithm>

namespace noiseloom {
namespace {

// For a heap with the least key at the front. (Keys of one rank are equal past 2^32 pixels alone.)
struct Later {
  VacView view;
  bool operator()(const VacCandidate& a, const VacCandidate& b) const {
    if (a.key() != b.key()) return a.key() > b.key();
    return view == VacView::voids ? a.position > b.position : a.position < b.position;
  }
};

}  // namespace

VacSwapper::VacSwapper(VacSlices& slices, VacExchange& exchange, const VacTieHash& hash)
    : slices_(slices), exchange_(exchange), hash_(hash), own_search_(slices, alone_, hash) {}

void VacSwapper::fill(Side& side) {
  constexpr double fraction = 0.25;
  own_search_.refresh_bounds(side.view);
  side.limit = own_search_.find(side.view, fraction, side.heap);
  std::make_heap(side.heap.begin(), side.heap.end(), Later{side.view});
}

void VacSwapper::offer(Side& side, std::uint64_t position) {
  if (!slices_.has(position)) return;
  const auto flip = static_cast<std::uint32_t>(side.view);
  const VacCandidate now{position, slices_.word(position) ^ flip, hash_(position) ^ flip};
  if (now.key() > side.limit) return;
  side.heap.push_back(now);
  std::push_heap(side.heap.begin(), side.heap.end(), Later{side.view});
}

// The best of this rank.
VacOffer VacSwapper::best(Side& side) {
  const auto flip = static_cast<std::uint32_t>(side.view);
  for (bool filled = false;; filled = true) {
    while (!side.heap.empty()) {
      const VacCandidate top = side.heap.front();
      const std::uint32_t value = slices_.word(top.position) ^ flip;
      if (value == top.energy) return {top.key(), side.view == VacView::voids ? top.position : ~top.position};
      std::pop_heap(side.heap.begin(), side.heap.end(), Later{side.view});
      side.heap.pop_back();
      if (value > top.energy) offer(side, top.position);  // a smaller value has an entry of its own
    }
    if (filled) return {};  // no such pixel in this rank's slices
    fill(side);
  }
}

std::uint64_t VacSwapper::agree(Side& side) {
  const VacOffer least = exchange_.least(best(side));
  return side.view == VacView::voids ? least.order : ~least.order;
}

std::optional<VacSwapper::Swap> VacSwapper::next() {
  const std::uint64_t from = agree(clusters_);
  hits_.clear();
  for (std::size_t i = 0; i < slices_.num_parts(); ++i) {
    slices_.part(i).turn_off_watching(from, static_cast<std::uint32_t>(voids_.limit >> 32), hits_);
  }
  for (const std::uint64_t position : hits_) offer(voids_, position);
  offer(voids_, from);
  const std::uint64_t to = agree(voids_);
  hits_.clear();
  for (std::size_t i = 0; i < slices_.num_parts(); ++i) {
    slices_.part(i).turn_on_watching(to, ~static_cast<std::uint32_t>(clusters_.limit >> 32), hits_);
  }
  for (const std::uint64_t position : hits_) offer(clusters_, position);
  offer(clusters_, to);
  if (from == to) return std::nullopt;
  return Swap{from, to};
}

}  // namespace noiseloom
