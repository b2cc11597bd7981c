// XXH64 [Collet, xxhash.com], seed 0: finds damage; it is no protection against forgery.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

struct XXH64_state_s;

namespace noiseloom {

// Digest of a sequence of bytes that arrives in pieces. How it is cut does not matter.
class Digest {
 public:
  Digest();
  void update(std::span<const std::byte> bytes);
  std::uint64_t value() const;

 private:
  struct Free {
    void operator()(XXH64_state_s* state) const;
  };
  std::unique_ptr<XXH64_state_s, Free> state_;
};

std::uint64_t digest_of(std::span<const std::byte> bytes);

// 16 lower-case hexadecimal digits.
std::string to_hex(std::uint64_t digest);

}  // namespace noiseloom
