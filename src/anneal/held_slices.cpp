#include "anneal/held_slices.h"

#include <utility>

namespace noiseloom {
namespace {

std::vector<Extents::SliceCoord> slice_offsets(const Footprint& footprint) {
  std::vector<Extents::SliceCoord> offsets;
  for (const SliceTaps& slice : footprint.slices()) offsets.push_back(slice.offset);
  return offsets;
}

}  // namespace

HeldSlices::HeldSlices(const Footprint& coupling, const FieldLayout& layout, const Communicator& communicator,
                       ThreadPool& pool)
    : pool_(pool),
      layout_(layout),
      distribution_(coupling.extents().num_slices(), communicator.size(), communicator.rank()),
      halo_(coupling.extents(), slice_offsets(coupling), distribution_),
      exchange_(communicator, halo_, distribution_),
      permutations_(static_cast<std::size_t>(num_own())) {}

std::vector<SliceIndex> HeldSlices::indices() const {
  const IndexRange<SliceIndex> own = distribution_.own_slices();
  std::vector<SliceIndex> slices(own.begin(), own.end());
  slices.insert(slices.end(), halo_.needed().begin(), halo_.needed().end());
  return slices;
}

void HeldSlices::fill(const SampleSource& source, const std::function<Permutation(SliceIndex)>& permutation_of) {
  const std::vector<SliceIndex> slices = indices();
  for (const SliceIndex slice : slices) fields_.emplace(slice, layout_);
  lay_out(slices, source, permutation_of);
}

void HeldSlices::put_back(const SampleSource& source, const std::function<Permutation(SliceIndex)>& permutation_of) {
  const IndexRange<SliceIndex> own = distribution_.own_slices();
  lay_out({own.begin(), own.end()}, source, permutation_of);
}

void HeldSlices::lay_out(const std::vector<SliceIndex>& slices, const SampleSource& source,
                         const std::function<Permutation(SliceIndex)>& permutation_of) {
  pool_.for_each(std::ssize(slices), [&](std::int64_t index, int) {
    const SliceIndex slice = slices[static_cast<std::size_t>(index)];
    Permutation ids = permutation_of(slice);
    fields_.at(slice).fill(ids, source.list(slice));
    if (owns(slice)) permutations_[distribution_.local_slice_from_global(slice)] = std::move(ids);
  });
}

void HeldSlices::carry_out(SliceIndex slice, std::span<const Swap> swaps) {
  SliceField& field = fields_.at(slice);
  Permutation& ids = permutations_[distribution_.local_slice_from_global(slice)];
  for (const Swap& swap : swaps) {
    field.swap(swap.a, swap.b);
    std::swap(ids[swap.a], ids[swap.b]);
  }
}

// A hot visit makes several swaps a cell; what travels is what they come to.
void HeldSlices::tell(const std::vector<SliceIndex>& moving, std::vector<SliceSwaps> own) {
  const Cell cells = layout_.width * layout_.height;
  pool_.for_each(std::ssize(own), [&](std::int64_t index, int) {
    SliceSwaps& changed = own[static_cast<std::size_t>(index)];
    if (!is_copied(changed.slice) || std::ssize(changed.swaps) < cells / 4) return;
    changed.swaps = fewest_swaps(changed.swaps, cells);
  });
  exchange_.begin(moving, own);
}

void HeldSlices::hear() {
  std::vector<SliceSwaps> received;  // each slice once: it moves once a step
  exchange_.wait([&received](SliceIndex slice, std::span<const Swap> swaps) {
    received.push_back({slice, {swaps.begin(), swaps.end()}});
  });
  pool_.for_each(std::ssize(received), [&](std::int64_t index, int) {
    const SliceSwaps& changed = received[static_cast<std::size_t>(index)];
    SliceField& field = fields_.at(changed.slice);
    for (const Swap& swap : changed.swaps) field.swap(swap.a, swap.b);
  });
}

}  // namespace noiseloom
