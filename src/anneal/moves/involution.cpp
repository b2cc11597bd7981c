#include "noiseloom/anneal/involution.h"

#include <bit>

#include "noiseloom/core/error.h"
#include "noiseloom/core/random.h"

namespace noiseloom {

Involution::Involution(std::uint64_t seed, std::uint32_t slice, std::uint32_t sweep, std::uint64_t num_cells)
    : num_cells_(num_cells) {
  NOISELOOM_CHECK(num_cells >= 1 && num_cells <= (std::uint64_t{1} << 32));
  while ((std::uint64_t{1} << (2 * half_bits_)) < num_cells) ++half_bits_;
  const RandomBlock keys = random_block(seed, Purpose::pairing, slice, sweep, 0);
  const RandomBlock bits = random_block(seed, Purpose::pairing, slice, sweep, 1);
  keys_ = {keys[0], keys[1], keys[2]};
  // tau must not be the identity: XOR with a number in [1, n).
  tau_ = std::has_single_bit(num_cells) ? 1 + to_below(bits[0], num_cells - 1) : to_below(bits[0], num_cells);
  if (num_cells == 1) tau_ = 0;
}

std::uint64_t Involution::reflect(std::uint64_t i) const {
  if (std::has_single_bit(num_cells_)) return i ^ tau_;
  return i <= tau_ ? tau_ - i : tau_ + num_cells_ - i;
}

// A mixing of (half, key) by multiplications and shifts; its quality only has to scramble positions.
std::uint32_t Involution::round(int r, std::uint32_t half) const {
  std::uint32_t h = half * 0x9e3779b1U ^ keys_[static_cast<std::size_t>(r)];
  h = (h ^ (h >> 16)) * 0x85ebca6bU;
  h = (h ^ (h >> 13)) * 0xc2b2ae35U;
  h ^= h >> 16;
  return h & static_cast<std::uint32_t>((std::uint64_t{1} << half_bits_) - 1);
}

std::uint64_t Involution::forward(std::uint64_t i) const {
  auto left = static_cast<std::uint32_t>(i >> half_bits_);
  auto right = static_cast<std::uint32_t>(i & ((std::uint64_t{1} << half_bits_) - 1));
  for (int r = 0; r < 3; ++r) {
    const std::uint32_t next = left ^ round(r, right);
    left = right;
    right = next;
  }
  return std::uint64_t{left} << half_bits_ | right;
}

std::uint64_t Involution::backward(std::uint64_t i) const {
  auto left = static_cast<std::uint32_t>(i >> half_bits_);
  auto right = static_cast<std::uint32_t>(i & ((std::uint64_t{1} << half_bits_) - 1));
  for (int r = 3; r-- > 0;) {
    const std::uint32_t previous = right ^ round(r, left);
    right = left;
    left = previous;
  }
  return std::uint64_t{left} << half_bits_ | right;
}

std::uint64_t Involution::permute(std::uint64_t i) const {
  do i = forward(i);
  while (i >= num_cells_);
  return i;
}

std::uint64_t Involution::unpermute(std::uint64_t i) const {
  do i = backward(i);
  while (i >= num_cells_);
  return i;
}

}  // namespace noiseloom
