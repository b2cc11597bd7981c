// The slow twin of void and cluster: a weight for every pair of pixels by the definition, every pick by a full scan. It
// shares with the library the specification, the start pattern and the tie hash; weights and phases are its own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "noiseloom/construct/void_and_cluster.h"

namespace noiseloom::oracle {

class VoidAndClusterOracle {
 public:
  // Energies in units of 2^-scale_log2.
  VoidAndClusterOracle(const VacSpec& spec, int scale_log2);

  // The largest energy that a pixel can have: all others on.
  std::int64_t largest_energy() const;
  std::int64_t weight(std::size_t p, std::size_t q) const { return weights_[p * n_ + q]; }
  std::int64_t num_swaps() const { return num_swaps_; }

  std::vector<std::uint64_t> order();

 private:
  void flip(std::size_t p);
  // The pixel with the largest key among those on, or the smallest among those off.
  std::size_t extreme(bool largest_on) const;

  VacSpec spec_;
  std::size_t n_;
  std::vector<std::int64_t> weights_;
  std::vector<bool> on_;
  std::vector<std::int64_t> energy_;
  std::int64_t num_swaps_ = 0;
};

}  // namespace noiseloom::oracle
