#include "noiseloom/files/digest.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <new>

namespace noiseloom {

void Digest::Free::operator()(XXH64_state_s* state) const { XXH64_freeState(state); }

Digest::Digest() : state_(XXH64_createState()) {
  if (!state_) throw std::bad_alloc();
  XXH64_reset(state_.get(), 0);
}

void Digest::update(std::span<const std::byte> bytes) { XXH64_update(state_.get(), bytes.data(), bytes.size()); }

std::uint64_t Digest::value() const { return XXH64_digest(state_.get()); }

std::uint64_t digest_of(std::span<const std::byte> bytes) { return XXH64(bytes.data(), bytes.size(), 0); }

std::string to_hex(std::uint64_t digest) { return fmt::format("{:016x}", digest); }

}  // namespace noiseloom
