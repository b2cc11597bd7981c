#include "anneal/moves/proposals.h"

#include "noiseloom/core/random.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "anneal/moves/proposals.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "anneal/fields/simd_kernels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace noiseloom::HWY_NAMESPACE {

struct Words {
  std::uint32_t word[3][proposal_batch];
};

#if HWY_TARGET == HWY_SCALAR

HWY_INLINE void draw_words(const ProposalSource& source, std::uint64_t first, Words& words) {
  for (std::size_t k = 0; k < proposal_batch; ++k) {
    const RandomBlock block = random_block(source.seed, Purpose::proposal, source.slice, source.sweep, first + k);
    for (std::size_t w = 0; w < 3; ++w) words.word[w][k] = block[w];
  }
}

#else

// Philox4x32-10 of core/random.h on 64-bit lanes, one candidate a lane, of which only the low halves count.
HWY_INLINE void draw_words(const ProposalSource& source, std::uint64_t first, Words& words) {
  using D = hn::CappedTag<std::uint64_t, proposal_batch>;
  const D d;
  const hn::Repartition<std::uint32_t, D> d32;
  const auto multiply = [&](auto a, std::uint32_t by) { return hn::MulEven(hn::BitCast(d32, a), hn::Set(d32, by)); };
  for (std::size_t lane = 0; lane < proposal_batch; lane += hn::MaxLanes(d)) {
    const auto index = hn::Add(hn::Set(d, first + lane), hn::Iota(d, 0));
    auto c0 = index;
    auto c1 = hn::Or(hn::ShiftRight<32>(index),
                     hn::Set(d, std::uint64_t{static_cast<std::uint32_t>(Purpose::proposal)} << 24));
    auto c2 = hn::Set(d, source.slice);
    auto c3 = hn::Set(d, source.sweep);
    auto key0 = static_cast<std::uint32_t>(source.seed);
    auto key1 = static_cast<std::uint32_t>(source.seed >> 32);
    for (int round = 0; round < 10; ++round) {
      const auto product0 = multiply(c0, 0xD2511F53U);
      const auto product1 = multiply(c2, 0xCD9E8D57U);
      c0 = hn::Xor(hn::Xor(hn::ShiftRight<32>(product1), c1), hn::Set(d, key0));
      c1 = product1;
      c2 = hn::Xor(hn::Xor(hn::ShiftRight<32>(product0), c3), hn::Set(d, key1));
      c3 = product0;
      key0 += 0x9E3779B9U;
      key1 += 0xBB67AE85U;
    }
    std::uint64_t out[3][hn::MaxLanes(d)];
    hn::StoreU(c0, d, out[0]);
    hn::StoreU(c1, d, out[1]);
    hn::StoreU(c2, d, out[2]);
    for (std::size_t w = 0; w < 3; ++w) {
      for (std::size_t k = 0; k < hn::MaxLanes(d); ++k) words.word[w][lane + k] = static_cast<std::uint32_t>(out[w][k]);
    }
  }
}

#endif

// (0, 1) in steps of 2^-23, from the upper 23 bits.
HWY_INLINE V to_unit(const std::uint32_t* words) {
  const hn::RebindToSigned<Floats> ints;
  const hn::RebindToUnsigned<Floats> bits;
  const auto whole = hn::BitCast(ints, hn::ShiftRight<9>(hn::LoadU(bits, words)));
  return hn::Mul(hn::Add(hn::ConvertTo(Floats(), whole), set(0.5F)), set(0x1p-23F));
}

Proposals draw(const ProposalSource& source, std::uint64_t first) {
  const hn::RebindToSigned<Floats> ints;
  Words words;
  draw_words(source, first, words);
  Proposals proposals;
  for (std::size_t k = 0; k < proposal_batch; ++k) {
    proposals.cell[k] = to_below(words.word[0][k], source.num_samples);
  }
  for (std::size_t lane = 0; lane < proposal_batch; lane += vector_lanes) {
    const V unit = to_unit(words.word[1] + lane);
    const V step = hn::Mul(set(source.lowest_step), exp2(hn::Mul(unit, set(source.log2_ratio))));
    hn::StoreU(hn::ConvertTo(ints, step), ints, proposals.step + lane);
    const V threshold = hn::Mul(set(-0.69314718F), log2(to_unit(words.word[2] + lane)));
    hn::StoreU(threshold, Floats(), proposals.threshold + lane);
  }
  for (std::size_t k = 0; k < proposal_batch; ++k) {
    if ((words.word[1][k] & 1U) != 0) proposals.step[k] = -proposals.step[k];
  }
  return proposals;
}

}  // namespace noiseloom::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace noiseloom {

HWY_EXPORT(draw);

Proposals draw_proposals(const ProposalSource& source, std::uint64_t first) {
  return HWY_DYNAMIC_DISPATCH(draw)(source, first);
}

}  // namespace noiseloom
#endif
