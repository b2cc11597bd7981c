#include "noiseloom/core/math.h"

#include <bit>
#include <cstdint>
#include <limits>

namespace noiseloom::math {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// log 2 in two parts; the first has 11 trailing zero bits, so that its product with any exponent is exact.
constexpr double ln2_hi = 0x1.62e42fefa3800p-1;
constexpr double ln2_lo = 0x1.ef35793c76730p-45;

// Nearest integer, ties to even; |x| < 2^51. Adding 1.5 * 2^52 leaves no bits for a fraction.
double nearest_integer(double x) {
  constexpr double shift = 0x1.8p52;
  return (x + shift) - shift;
}

// 2^k for normal results.
double power_of_two(int k) { return std::bit_cast<double>(static_cast<std::uint64_t>(k + 1023) << 52); }

}  // namespace

double exp(double x) {
  if (x != x) return x;
  if (x > 710) return infinity;
  if (x < -746) return 0;
  const double k = nearest_integer(x * 0x1.71547652b82fep+0);
  const double r = (x - k * ln2_hi) - k * ln2_lo;  // |r| <= log(2) / 2: 13 terms of the series reach 4e-18
  double tail = 1.0 / 6227020800.0;
  constexpr double inverse_factorial[] = {1.0 / 2,       1.0 / 6,        1.0 / 24,       1.0 / 120,
                                          1.0 / 720,     1.0 / 5040,     1.0 / 40320,    1.0 / 362880,
                                          1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600};
  for (int n = 10; n >= 0; --n) tail = tail * r + inverse_factorial[n];
  const double value = 1 + (r + r * r * tail);
  // In two steps, because 2^k alone may leave the range where the product does not.
  const int exponent = static_cast<int>(k);
  const int half = exponent / 2;
  return value * power_of_two(half) * power_of_two(exponent - half);
}

double log(double x) {
  if (x != x || x == infinity) return x;
  if (x <= 0) return x == 0 ? -infinity : nan;
  double k = 0;
  if (x < 0x1p-1022) {
    x *= 0x1p54;
    k = -54;
  }
  // x = 2^k m with m in [sqrt(1/2), sqrt(2)); log m = 2 atanh(s), s = f / (2 + f), f = m - 1.
  std::uint64_t bits = std::bit_cast<std::uint64_t>(x);
  bits += 0x3ff0000000000000U - 0x3fe6a09e667f3bcdU;
  k += static_cast<double>(static_cast<int>(bits >> 52) - 1023);
  const double m = std::bit_cast<double>((bits & 0x000fffffffffffffU) + 0x3fe6a09e667f3bcdU);
  const double f = m - 1;
  const double s = f / (2 + f);
  const double z = s * s;
  double series = 0;  // s^2/3 + s^4/5 + ...; s^2 <= 0.0295, so s^22/23 is below 1e-18
  for (int n = 21; n >= 3; n -= 2) series = (series + 1.0 / n) * z;
  // 2 s = f - s f keeps the leading term f exact.
  const double small = s * (2 * series - f);
  return k * ln2_hi + (f + (small + k * ln2_lo));
}

double pow(double base, double exponent) {
  if (exponent == 0 || base == 1) return 1;
  if (exponent == 1) return base;
  if (exponent == 0.5) return std::sqrt(base);
  if (base == 0) return exponent > 0 ? 0 : infinity;
  return exp(exponent * log(base));
}

namespace {

// sin and cos of 2 pi `turns`: reduction to an eighth of a turn is exact, so only the series rounds.
struct SinCos {
  double sin;
  double cos;
};

SinCos sin_cos_2pi(double turns) {
  if (!(turns > -infinity && turns < infinity)) return {nan, nan};
  if (turns > 0x1p50 || turns < -0x1p50) turns = std::fmod(turns, 1.0);  // exact by definition
  turns -= nearest_integer(turns);
  const double quadrant = nearest_integer(4 * turns);
  const double x = two_pi * (turns - 0.25 * quadrant);  // |x| <= pi / 4
  const double z = x * x;
  double sin_tail = 0;  // of sin x / x - 1; x^19 / 19! is below 1e-19
  for (int n = 17; n >= 3; n -= 2) sin_tail = (sin_tail + 1) * (-z * (1.0 / (n * (n - 1))));
  double cos_tail = 0;  // of cos x - 1; x^18 / 18! is below 1e-17
  for (int n = 16; n >= 2; n -= 2) cos_tail = (cos_tail + 1) * (-z * (1.0 / (n * (n - 1))));
  const double s = x + x * sin_tail;
  const double c = 1 + cos_tail;
  switch (static_cast<int>(quadrant) & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

}  // namespace

double sin_2pi(double turns) { return sin_cos_2pi(turns).sin; }
double cos_2pi(double turns) { return sin_cos_2pi(turns).cos; }

}  // namespace noiseloom::math
