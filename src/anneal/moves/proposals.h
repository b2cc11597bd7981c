// Random draws of the annealed swaps, sixteen candidates at a time.
#pragma once

#include <cstdint>

#include "anneal/fields/tap_plan.h"

namespace noiseloom {

struct ProposalSource {
  std::uint64_t seed;
  std::uint32_t slice;
  std::uint32_t sweep;
  std::uint64_t num_samples;  // at most 2^32
  float lowest_step;          // of the distance between ids
  float log2_ratio;           // of the largest to the lowest
};

inline constexpr std::size_t proposal_batch = block_lanes;

struct Proposals {
  std::uint32_t cell[proposal_batch];  // uniform in [0, num_samples)
  std::int32_t step[proposal_batch];   // log-uniform between the lowest and the largest, either sign
  float threshold[proposal_batch];     // -log(u), u uniform in (0, 1): Metropolis accepts dE <= T * threshold
};

// Candidates first, first + 1, ...; the same bits on every instruction set. Philox (seed, Purpose::proposal, slice,
// sweep, candidate): words 0, 1 and 2.
Proposals draw_proposals(const ProposalSource& source, std::uint64_t first);

}  // namespace noiseloom
