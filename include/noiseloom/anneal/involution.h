// A random perfect pairing of the cells of a slice: rho = sigma tau sigma^-1 [FAST24, eq. 9].
//
// sigma is a random permutation by a three-round Feistel network on the next power of four, walked along its cycles
// back into [0, n) where n is smaller. tau is XOR with random bits where n is a power of two, as published; elsewhere,
// where XOR would leave up to half of the cells alone, the reflection i -> (c - i) mod n, which is an involution for
// any n. Fixed points are cells without a partner.
#pragma once

#include <array>
#include <cstdint>

namespace noiseloom {

class Involution {
 public:
  Involution(std::uint64_t seed, std::uint32_t slice, std::uint32_t sweep, std::uint64_t num_cells);
  // rho(rho(i)) == i.
  std::uint64_t operator()(std::uint64_t i) const { return permute(reflect(unpermute(i))); }

  std::uint64_t permute(std::uint64_t i) const;    // sigma
  std::uint64_t unpermute(std::uint64_t i) const;  // sigma^-1

 private:
  std::uint64_t reflect(std::uint64_t i) const;  // tau
  std::uint32_t round(int r, std::uint32_t half) const;
  std::uint64_t forward(std::uint64_t i) const;
  std::uint64_t backward(std::uint64_t i) const;

  std::uint64_t num_cells_;
  int half_bits_ = 1;
  std::array<std::uint32_t, 3> keys_{};
  std::uint64_t tau_ = 0;
};

}  // namespace noiseloom
