// What travels between the ranks of a void-and-cluster run: short records that every rank gets from every rank. Counts
// them.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "construct/vac_field.h"
#include "noiseloom/dist/communicator.h"

namespace noiseloom {

// The best pixel of a rank: smaller is better. By default: none.
struct VacOffer {
  std::uint64_t key = ~std::uint64_t{0};
  std::uint64_t order = ~std::uint64_t{0};  // breaks ties: the position, complemented for clusters
  friend auto operator<=>(const VacOffer&, const VacOffer&) = default;
};
inline VacOffer vac_offer(VacView view, std::uint64_t key, std::uint64_t position) {
  return {key, view == VacView::voids ? position : ~position};
}
inline std::uint64_t position_of(VacView view, const VacOffer& offer) {
  return view == VacView::voids ? offer.order : ~offer.order;
}

class VacExchange {
 public:
  // With no other rank.
  VacExchange() = default;
  // The communicator must outlive the exchange.
  explicit VacExchange(const Communicator& communicator) : communicator_(&communicator) {}
  bool alone() const { return num_ranks() == 1; }
  int num_ranks() const { return communicator_ == nullptr ? 1 : communicator_->size(); }

  // What all ranks give, in the order of the ranks; of words each gives the same number. *Collective*
  std::vector<std::uint64_t> gather(std::span<const std::uint64_t> own) {
    if (alone()) return {own.begin(), own.end()};
    count(1, own.size_bytes());
    return communicator_->gather_all(own);
  }
  std::vector<std::byte> gather(std::span<const std::byte> own) {
    if (alone()) return {own.begin(), own.end()};
    count(2, own.size() + sizeof(int));
    return communicator_->gather_all(own);
  }
  std::int64_t sum(std::int64_t own) {
    if (!alone()) {
      count(1, sizeof(own));
      communicator_->sum(std::span(&own, 1));
    }
    return own;
  }

  VacOffer least(const VacOffer& own) {
    if (alone()) return own;
    count(1, sizeof(own));
    const auto [key, order] = communicator_->least({own.key, own.order});
    return {key, order};
  }

  std::int64_t collectives() const { return collectives_; }
  std::int64_t bytes() const { return bytes_; }

 private:
  void count(int collectives, std::size_t bytes) {
    collectives_ += collectives;
    bytes_ += static_cast<std::int64_t>(bytes);
  }

  const Communicator* communicator_ = nullptr;
  std::int64_t collectives_ = 0;
  std::int64_t bytes_ = 0;  // that this rank gave to collectives
};

}  // namespace noiseloom
