// What travels between the ranks of a void-and-cluster run: short records that every rank gets from every rank. Counts
// them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "construct/fields/vac_field.h"
#include "noiseloom/dist/communicator.h"

namespace noiseloom {

// The best pixel of a rank: smaller is better. By default: none.
struct VacOffer {
  std::uint64_t key = ~std::uint64_t{0};
  std::uint64_t order = ~std::uint64_t{0};  // breaks ties
};

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
  // Where every rank knows how many bytes each gives.
  std::vector<std::byte> gather(std::span<const std::byte> own, std::span<const int> counts) {
    count(1, own.size());
    return communicator_->gather_all(own, counts);
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

// Candidates as bytes: position and energy as differences (ascending positions; energies at most `limit`'s), in groups
// of seven bits; hashes follow from positions. About five bytes each.
class VacPacker {
 public:
  explicit VacPacker(std::uint64_t limit) : energy_limit_(static_cast<std::uint32_t>(limit >> 32)) {}
  // Appends a block that unpack() reads back.
  void pack(std::span<const VacCandidate> candidates, std::vector<std::byte>& bytes) const;
  void unpack(std::span<const std::byte> bytes, VacView view, const VacTieHash& hash,
              std::vector<VacCandidate>& candidates) const;

 private:
  std::uint32_t energy_limit_;
};

}  // namespace noiseloom
