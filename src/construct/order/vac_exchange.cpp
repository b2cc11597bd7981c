#include "construct/order/vac_exchange.h"

namespace noiseloom {
namespace {

void put(std::vector<std::byte>& bytes, std::uint64_t value) {
  for (; value >= 0x80; value >>= 7) bytes.push_back(static_cast<std::byte>(value | 0x80));
  bytes.push_back(static_cast<std::byte>(value));
}

std::uint64_t get(std::span<const std::byte> bytes, std::size_t& at) {
  std::uint64_t value = 0;
  for (int shift = 0;; shift += 7) {
    const auto byte = static_cast<std::uint64_t>(bytes[at++]);
    value |= (byte & 0x7F) << shift;
    if (byte < 0x80) return value;
  }
}

}  // namespace

void VacPacker::pack(std::span<const VacCandidate> candidates, std::vector<std::byte>& bytes) const {
  put(bytes, candidates.size());
  std::uint64_t last = 0;
  for (const VacCandidate& c : candidates) {
    put(bytes, c.position - last);
    put(bytes, energy_limit_ - c.energy);
    last = c.position;
  }
}

void VacPacker::unpack(std::span<const std::byte> bytes, VacView view, const VacTieHash& hash,
                       std::vector<VacCandidate>& candidates) const {
  for (std::size_t at = 0; at < bytes.size();) {
    std::uint64_t position = 0;
    for (std::uint64_t left = get(bytes, at); left > 0; --left) {
      position += get(bytes, at);
      const auto energy = energy_limit_ - static_cast<std::uint32_t>(get(bytes, at));
      candidates.push_back({position, energy, hash(position) ^ static_cast<std::uint32_t>(view)});
    }
  }
}

}  // namespace noiseloom
