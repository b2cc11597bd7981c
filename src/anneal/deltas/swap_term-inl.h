// What one tap contributes to the change of the energy by a swap, a vector of taps at a time.
#if defined(NOISELOOM_SWAP_TERM) == defined(HWY_TARGET_TOGGLE)
#ifdef NOISELOOM_SWAP_TERM
#undef NOISELOOM_SWAP_TERM
#else
#define NOISELOOM_SWAP_TERM
#endif

#include "anneal/fields/simd_kernels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace noiseloom::HWY_NAMESPACE {

// sum over taps of F (K(b, s) - K(a, s)), at the centre i less at the centre j, for a at i and b at j: dE is twice
// that. at_i, at_j: give the samples around the centres in a channel.
template <DistanceKind kind, ValueKernelKind value_kind, int C>
class SwapTerm {
 public:
  using Cost = PairCost<kind, value_kind, C>;
  static constexpr int most_channels = C;
  static constexpr int channels(const Cost& /*pair_cost*/) { return C; }

  SwapTerm(const Cost& pair_cost, const float (&a)[C], const float (&b)[C]) : pair_cost_(pair_cost) {
    for (int c = 0; c < C; ++c) {
      a_[c] = set(a[c]);
      b_[c] = set(b[c]);
    }
  }
  template <class Samples>
  HWY_INLINE V term(const Samples& at_i, const Samples& at_j) const {
    V i[C];
    V j[C];
    for (int c = 0; c < C; ++c) {
      i[c] = at_i(c);
      j[c] = at_j(c);
    }
    const V change_at_i = hn::Sub(pair_cost_(a_, i), pair_cost_(b_, i));
    return hn::Sub(change_at_i, hn::Sub(pair_cost_(a_, j), pair_cost_(b_, j)));
  }
  // What a sum of terms stands for, and the value that stands for 1.
  HWY_INLINE float scaled(float sum) const { return sum; }
  HWY_INLINE float unit() const { return 1; }

 private:
  const Cost& pair_cost_;
  V a_[C];
  V b_[C];
};

// For a < b: |a - s| - |b - s| = 2 clamp(s, a, b) - a - b, and a + b cancels between the centres.
template <>
class SwapTerm<DistanceKind::absolute, ValueKernelKind::distance, 1> {
 public:
  using Cost = PairCost<DistanceKind::absolute, ValueKernelKind::distance, 1>;
  static constexpr int most_channels = 1;
  static constexpr int channels(const Cost& /*pair_cost*/) { return 1; }

  SwapTerm(const Cost& /*pair_cost*/, const float (&a)[1], const float (&b)[1])
      : low_(set(a[0] < b[0] ? a[0] : b[0])), high_(set(a[0] < b[0] ? b[0] : a[0])), scale_(a[0] < b[0] ? 2 : -2) {}
  template <class Samples>
  HWY_INLINE V term(const Samples& at_i, const Samples& at_j) const {
    return hn::Sub(hn::Min(hn::Max(at_i(0), low_), high_), hn::Min(hn::Max(at_j(0), low_), high_));
  }
  HWY_INLINE float scaled(float sum) const { return scale_ * sum; }
  HWY_INLINE float unit() const { return 1 / scale_; }

 private:
  V low_;
  V high_;
  float scale_;
};

// SwapTerm for any number of channels, which are added one after another.
template <DistanceKind kind, ValueKernelKind value_kind>
class ChannelwiseSwapTerm {
 public:
  using Cost = ChannelwisePairCost<kind, value_kind>;
  static constexpr int most_channels = 8;
  static int channels(const Cost& pair_cost) { return pair_cost.channels(); }

  ChannelwiseSwapTerm(const Cost& pair_cost, const float (&a)[most_channels], const float (&b)[most_channels])
      : pair_cost_(pair_cost), a_(a), b_(b) {}
  template <class Samples>
  HWY_INLINE V term(const Samples& at_i, const Samples& at_j) const {
    V all[4] = {set(0), set(0), set(0), set(0)};
    for (int c = 0; c < pair_cost_.channels(); ++c) {
      const V i = at_i(c);
      const V j = at_j(c);
      all[0] = pair_cost_.with_channel(all[0], set(a_[c]), i);
      all[1] = pair_cost_.with_channel(all[1], set(b_[c]), i);
      all[2] = pair_cost_.with_channel(all[2], set(a_[c]), j);
      all[3] = pair_cost_.with_channel(all[3], set(b_[c]), j);
    }
    const V change_at_i = hn::Sub(pair_cost_.cost(all[0]), pair_cost_.cost(all[1]));
    return hn::Sub(change_at_i, hn::Sub(pair_cost_.cost(all[2]), pair_cost_.cost(all[3])));
  }
  HWY_INLINE float scaled(float sum) const { return sum; }
  HWY_INLINE float unit() const { return 1; }

 private:
  const Cost& pair_cost_;
  const float (&a_)[most_channels];
  const float (&b_)[most_channels];
};

}  // namespace noiseloom::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
