#include "noiseloom/dist/halo_exchange.h"

#include <algorithm>
#include <map>

#include "dist/mpi_impl.h"
#include "noiseloom/dist/activity.h"

namespace noiseloom {
namespace {

constexpr int halo_tag = 2;

std::uint64_t pack(std::uint32_t a, std::uint32_t b) { return std::uint64_t{a} << 32 | b; }

}  // namespace

struct HaloExchange::Impl {
  Impl(const Communicator& ranks, const HaloPlan& halo, const Distribution& owners)
      : communicator(ranks), plan(halo), distribution(owners) {}
  ~Impl();
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  const Communicator& communicator;
  const HaloPlan& plan;
  Distribution distribution;
  // A message is a sequence of (slice, number of swaps), swaps...
  using Outgoing = std::map<Rank, std::vector<std::uint64_t>>;
  Outgoing outgoing;
  std::vector<MPI_Request> requests;
  std::vector<SliceIndex> expected;  // needed slices that moved, ascending
  std::vector<Rank> senders;         // their owners, ascending
  std::int64_t bytes = 0;
  std::int64_t messages = 0;
};

// Only where an exchange is unwound, as something threw between begin() and wait(), are sends still under way. They
// cannot be taken back (MPI need not know how to cancel a send), and to wait for a receiver that may never come would
// hang: so their memory is given up, not freed under MPI's hands.
HaloExchange::Impl::~Impl() {
  if (requests.empty()) return;
  int done = 0;
  MPI_Testall(static_cast<int>(requests.size()), requests.data(), &done, MPI_STATUSES_IGNORE);
  if (done == 0) [[maybe_unused]]
    const auto* given_up = new Outgoing(std::move(outgoing));
}

HaloExchange::HaloExchange(const Communicator& communicator, const HaloPlan& plan, const Distribution& distribution)
    : impl_(new Impl(communicator, plan, distribution)) {}

HaloExchange::~HaloExchange() = default;

void HaloExchange::begin(std::span<const SliceIndex> moved, std::span<const SliceSwaps> own) {
  NOISELOOM_CHECK(impl_->requests.empty() && impl_->senders.empty());
  impl_->outgoing.clear();
  for (const SliceSwaps& changed : own) {
    for (const Rank listener : impl_->plan.listeners(changed.slice)) {
      std::vector<std::uint64_t>& message = impl_->outgoing[listener];
      message.push_back(pack(static_cast<std::uint32_t>(changed.slice), narrow<std::uint32_t>(changed.swaps.size())));
      for (const Swap& swap : changed.swaps) message.push_back(pack(swap.a, swap.b));
    }
  }
  const MPI_Comm comm = impl_->communicator.impl().comm;
  for (const auto& [listener, message] : impl_->outgoing) {
    MPI_Request& request = impl_->requests.emplace_back();
    check_mpi(MPI_Isend(message.data(), narrow<int>(message.size()), MPI_UINT64_T, listener.value(), halo_tag, comm,
                        &request),
              "MPI_Isend");
    impl_->bytes += static_cast<std::int64_t>(message.size() * sizeof(std::uint64_t));
    ++impl_->messages;
  }
  impl_->expected.clear();
  std::set_intersection(moved.begin(), moved.end(), impl_->plan.needed().begin(), impl_->plan.needed().end(),
                        std::back_inserter(impl_->expected));
  for (const SliceIndex slice : impl_->expected) {
    const Rank owner = impl_->distribution.owner(slice);
    if (impl_->senders.empty() || impl_->senders.back() != owner) impl_->senders.push_back(owner);
  }
}

bool HaloExchange::pending(SliceIndex slice) const {
  return !impl_->senders.empty() && std::binary_search(impl_->expected.begin(), impl_->expected.end(), slice);
}

void HaloExchange::wait(const std::function<void(SliceIndex, std::span<const Swap>)>& apply) {
  const MPI_Comm comm = impl_->communicator.impl().comm;
  std::vector<std::uint64_t> message;
  std::vector<Swap> swaps;
  for (const Rank sender : impl_->senders) {
    MPI_Message handle = MPI_MESSAGE_NULL;
    MPI_Status status;
    const Activity waiting(Activity::Kind::waiting, "waits for the swaps of", sender);
    check_mpi(MPI_Mprobe(sender.value(), halo_tag, comm, &handle, &status), "MPI_Mprobe");
    int count = 0;
    check_mpi(MPI_Get_count(&status, MPI_UINT64_T, &count), "MPI_Get_count");
    message.resize(static_cast<std::size_t>(count));
    check_mpi(MPI_Mrecv(message.data(), count, MPI_UINT64_T, &handle, MPI_STATUS_IGNORE), "MPI_Mrecv");
    for (std::size_t at = 0; at < message.size();) {
      const auto slice = SliceIndex(message[at] >> 32);
      const std::size_t num_swaps = message[at] & 0xffffffffU;
      ++at;
      NOISELOOM_CHECK_LE(at + num_swaps, message.size());
      swaps.clear();
      for (std::size_t k = 0; k < num_swaps; ++k, ++at) {
        swaps.push_back({static_cast<std::uint32_t>(message[at] >> 32), static_cast<std::uint32_t>(message[at])});
      }
      apply(slice, swaps);
    }
  }
  impl_->senders.clear();
  const Activity waiting(Activity::Kind::waiting, "waits until others have its swaps");
  check_mpi(MPI_Waitall(static_cast<int>(impl_->requests.size()), impl_->requests.data(), MPI_STATUSES_IGNORE),
            "MPI_Waitall");
  impl_->requests.clear();
}

std::int64_t HaloExchange::bytes_sent() const { return impl_->bytes; }
std::int64_t HaloExchange::messages_sent() const { return impl_->messages; }

}  // namespace noiseloom
