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
// that.
template <DistanceKind kind, ValueKernelKind value_kind, int C>
class SwapTerm {
 public:
  SwapTerm(const PairCost<kind, value_kind, C>& pair_cost, const float (&a)[C], const float (&b)[C])
      : pair_cost_(pair_cost) {
    for (int c = 0; c < C; ++c) {
      a_[c] = set(a[c]);
      b_[c] = set(b[c]);
    }
  }
  HWY_INLINE V term(const V (&at_i)[C], const V (&at_j)[C]) const {
    const V i = hn::Sub(pair_cost_(a_, at_i), pair_cost_(b_, at_i));
    return hn::Sub(i, hn::Sub(pair_cost_(a_, at_j), pair_cost_(b_, at_j)));
  }
  // What a sum of terms stands for, and the value that stands for 1.
  HWY_INLINE float scaled(float sum) const { return sum; }
  HWY_INLINE float unit() const { return 1; }

 private:
  const PairCost<kind, value_kind, C>& pair_cost_;
  V a_[C];
  V b_[C];
};

// For a < b: |a - s| - |b - s| = 2 clamp(s, a, b) - a - b, and a + b cancels between the centres.
template <>
class SwapTerm<DistanceKind::absolute, ValueKernelKind::distance, 1> {
 public:
  SwapTerm(const PairCost<DistanceKind::absolute, ValueKernelKind::distance, 1>&, const float (&a)[1],
           const float (&b)[1])
      : low_(set(a[0] < b[0] ? a[0] : b[0])), high_(set(a[0] < b[0] ? b[0] : a[0])), scale_(a[0] < b[0] ? 2 : -2) {}
  HWY_INLINE V term(const V (&at_i)[1], const V (&at_j)[1]) const {
    return hn::Sub(hn::Min(hn::Max(at_i[0], low_), high_), hn::Min(hn::Max(at_j[0], low_), high_));
  }
  HWY_INLINE float scaled(float sum) const { return scale_ * sum; }
  HWY_INLINE float unit() const { return 1 / scale_; }

 private:
  V low_;
  V high_;
  float scale_;
};

}  // namespace noiseloom::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
