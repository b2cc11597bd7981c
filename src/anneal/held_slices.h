// The slices of a texture that one rank holds: its own, and copies of those that they are coupled with.
//
// A slice is its permutation (element [cell] is the id of the sample there; own slices only) and its field (the samples
// themselves, laid out for the inner loops: slice_field.h). All that ever happens to a slice is a list of swaps, which
// its owner carries out at once and tells the ranks that hold a copy.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "noiseloom/anneal/slice_field.h"
#include "noiseloom/anneal/swap_delta.h"
#include "noiseloom/core/parallel.h"
#include "noiseloom/dist/halo_exchange.h"
#include "noiseloom/problem/footprint.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {

class HeldSlices {
 public:
  // `coupling`: which slices act on each other. `layout`: of every field. The arguments must outlive the object.
  HeldSlices(const Footprint& coupling, const FieldLayout& layout, const Communicator& communicator, ThreadPool& pool);

  const Distribution& distribution() const { return distribution_; }
  const HaloPlan& halo() const { return halo_; }
  const HaloExchange& exchange() const { return exchange_; }
  std::int32_t num_own() const { return distribution_.num_own(); }
  bool owns(SliceIndex slice) const { return distribution_.owns(slice); }
  // Whether another rank holds a copy of an own slice.
  bool is_copied(SliceIndex slice) const { return !halo_.listeners(slice).empty(); }
  // Own slices, then the others, each ascending.
  std::vector<SliceIndex> indices() const;

  // Lays the samples of every held slice out as `permutation_of` says. Before all that follows.
  void fill(const SampleSource& source, const std::function<Permutation(SliceIndex)>& permutation_of);
  const SliceField& field(SliceIndex slice) const { return fields_.at(slice); }
  FieldOf fields() const {
    return [this](SliceIndex slice) -> const SliceField& { return fields_.at(slice); };
  }
  const Permutation& permutation(SliceIndex slice) const {
    return permutations_[distribution_.local_slice_from_global(slice)];
  }

  // Lays own slices out anew. Copies of them stay as they are.
  void put_back(const SampleSource& source, const std::function<Permutation(SliceIndex)>& permutation_of);

  // Swaps of an own slice. Calls for different cells may run at the same time.
  void carry_out(SliceIndex slice, std::span<const Swap> swaps);
  // Sends what was done to own slices to the ranks that hold copies. `moving`: all slices of the texture that moved in
  // this step, ascending. hear() must have been called since the last call. *Collective*
  void tell(const std::vector<SliceIndex>& moving, std::vector<SliceSwaps> own);
  // Brings the copies up to date with what others have told. *Collective*
  void hear();
  // Whether the copy of a slice waits for that.
  bool is_behind(SliceIndex slice) const { return exchange_.pending(slice); }

 private:
  void lay_out(const std::vector<SliceIndex>& slices, const SampleSource& source,
               const std::function<Permutation(SliceIndex)>& permutation_of);

  ThreadPool& pool_;
  const FieldLayout& layout_;
  Distribution distribution_;
  HaloPlan halo_;
  HaloExchange exchange_;
  std::map<SliceIndex, SliceField> fields_;
  IndexedVector<LocalSlice, Permutation> permutations_;
};

}  // namespace noiseloom
