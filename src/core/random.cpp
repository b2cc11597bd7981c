#include "noiseloom/core/random.h"

#include <Random123/philox.h>

#include "noiseloom/core/error.h"

namespace noiseloom {

RandomBlock random_block(std::uint64_t seed, Purpose purpose, std::uint32_t slice, std::uint32_t sweep,
                         std::uint64_t index) {
  NOISELOOM_CHECK_LT(index >> 56, 1U);
  const r123::Philox4x32::ctr_type counter = {
      {static_cast<std::uint32_t>(index),
       static_cast<std::uint32_t>(index >> 32) | (static_cast<std::uint32_t>(purpose) << 24), slice, sweep}};
  const r123::Philox4x32::key_type key = {{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}};
  const auto bits = r123::Philox4x32{}(counter, key);
  return {bits[0], bits[1], bits[2], bits[3]};
}

}  // namespace noiseloom
