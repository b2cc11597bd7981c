// Tells other ranks what changed in the slices that they are coupled with. Only swaps travel, never slices; one message
// for each pair of coupled ranks and step; nothing at all where slices are not coupled.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "noiseloom/dist/communicator.h"
#include "noiseloom/dist/halo_plan.h"
#include "noiseloom/dist/swap.h"

namespace noiseloom {

class HaloExchange {
 public:
  // The communicator and the plan must outlive the exchange.
  HaloExchange(const Communicator& communicator, const HaloPlan& plan, const Distribution& distribution);
  ~HaloExchange();
  HaloExchange(const HaloExchange&) = delete;
  HaloExchange& operator=(const HaloExchange&) = delete;

  // Starts sending the swaps of own slices and notes which ranks will send some. `moved` lists all slices of the
  // texture that moved in this step, own or not, ascending; `own` those of this rank. `own` must stay unchanged until
  // wait(). Every rank must begin the same steps in the same order; the previous exchange must have been waited for.
  void begin(std::span<const SliceIndex> moved, std::span<const SliceSwaps> own);
  // True while messages of a begun step are outstanding and `slice` is a slice of another rank that they may change.
  bool pending(SliceIndex slice) const;
  // Completes the step: calls `apply` for every moved slice in the plan's needed(), in ascending order of the sender.
  void wait(const std::function<void(SliceIndex, std::span<const Swap>)>& apply);

  std::int64_t bytes_sent() const;
  std::int64_t messages_sent() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace noiseloom
