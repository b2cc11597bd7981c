// Elementary functions whose results are the same bits on every machine.
//
// The C library's exp, log, sin, cos, acos, pow and erf pick FMA variants at run time and so change their last bit with
// the CPU. Whatever decides a result (samples, taps, acceptance) uses these instead: only +, -, *, /, sqrt of IEEE
// doubles in round-to-nearest, compiled without contraction. Each states its largest error, which
// tests/core/math_test.cpp checks. NaN in, NaN out. tools/math_fit.py prints the fitted coefficients.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace noiseloom::math {

inline constexpr double pi = 0x1.921fb54442d18p+1;
inline constexpr double two_pi = 0x1.921fb54442d18p+2;

double exp(double x);  // relative error <= 1e-15; inf and 0 past the range, denormals to their last bit
double log(double x);  // relative error <= 1e-15; log(0) = -inf, NaN below
double pow(double base, double exponent);  // base >= 0; relative error <= 1e-14 * max(1, |exponent * log base|)
double sin_2pi(double turns);              // sin(2 pi turns); absolute error <= 5e-16 for every finite argument
double cos_2pi(double turns);
double erf(double x);                 // absolute error <= 1e-15
double inverse_normal_cdf(double p);  // 0 < p < 1; relative error <= 1e-13. Below 1/2 the tail is p itself: exact

namespace detail {

inline constexpr std::uint64_t sign_bit = std::uint64_t{1} << 63;
inline std::uint64_t bits(double x) { return std::bit_cast<std::uint64_t>(x); }
inline double masked(double x, std::uint64_t mask) { return std::bit_cast<double>(bits(x) & mask); }
// All ones where the sign bit of x is set, else zero.
inline std::uint64_t sign_mask(double x) { return 0 - (bits(x) >> 63); }

}  // namespace detail

// x in [-1, 1] (values outside are clamped); absolute error <= 1e-15; acos(1) = 0, acos(-1) = pi. Choices are masks,
// not branches: the cost does not depend on x, and loops over it vectorise (where sqrt need not set errno:
// -fno-math-errno).
inline double acos(double x) {
  using detail::masked;
  const double magnitude = masked(x, ~detail::sign_bit);
  // asin(s) with s <= 1/2 either way, a = |x|: acos(a) = 2 asin(sqrt((1 - a) / 2)) above 1/2, pi/2 - asin(a) below.
  const double room = 1 - magnitude;
  const double z_flat = magnitude * magnitude;
  const double z_steep = 0.5 * masked(room, ~detail::sign_mask(room));
  const std::uint64_t steep = detail::sign_mask(z_steep - z_flat);
  const double z = std::bit_cast<double>(detail::bits(masked(z_steep, steep)) | detail::bits(masked(z_flat, ~steep)));
  const double s = std::sqrt(z);  // sqrt(a * a) is a again
  const double z2 = z * z;
  const double z4 = z2 * z2;
  const double p0 =
      (0.16666666666666649 + 0.075000000000207644 * z) + (0.044642857103423643 + 0.030381947367098481 * z) * z2;
  const double p1 =
      (0.02237204763174451 + 0.017355259955786322 * z) + (0.013929652902326633 + 0.011875494382636923 * z) * z2;
  const double p2 =
      (7.8029494773533171e-3 + 0.016035514349148823 * z) + (-0.010749050339697808 + 0.028169218060881413 * z) * z2;
  const double asin_s = s + s * (z * (p0 + (p1 + p2 * z4) * z4));
  // acos(a) is 0 + 2 asin(s) or pi/2 - asin(s); acos(-a) is pi less that.
  const double signed_asin = std::bit_cast<double>(detail::bits(asin_s) ^ (detail::sign_bit & ~steep));
  const double from_right = masked(0.5 * pi, ~steep) + (signed_asin + masked(asin_s, steep));
  const double turned = std::bit_cast<double>(detail::bits(from_right) ^ (detail::bits(x) & detail::sign_bit));
  return masked(pi, detail::sign_mask(x)) + turned;
}

}  // namespace noiseloom::math
