// The error function and the inverse of the normal distribution.
#include <limits>

#include "noiseloom/core/math.h"

namespace noiseloom::math {
namespace {

constexpr double sqrt_pi = 0x1.c5bf891b4ef6bp+0;

// erf x = 2 / sqrt(pi) sum_n (-1)^n x^(2n+1) / (n! (2n+1)), 0 <= x < 1: 18 terms leave 1e-18, and little cancels.
double erf_series(double x) {
  double power = x;  // (-1)^n x^(2n+1) / n!
  double sum = x;
  for (int n = 1; n < 18; ++n) {
    power *= -x * x / n;
    sum += power / (2 * n + 1);
  }
  return 2 / sqrt_pi * sum;
}

// erfc x = exp(-x^2) / sqrt(pi) / (x + (1/2)/(x + (2/2)/(x + (3/2)/(x + ...)))), x >= 1. The levels left
// out, each nearly x + n/2 / itself, are replaced by the fixed point of that: 140 levels then leave 1e-16 of erfc.
double erfc_fraction(double x) {
  double below = 0.5 * (x + std::sqrt(x * x + 2 * 141));
  for (int n = 140; n >= 1; --n) below = x + 0.5 * n / below;
  return exp(-x * x) / (sqrt_pi * below);
}

// A quotient of two polynomials of degree 7, lowest power first.
struct Quotient {
  double numerator[8];
  double denominator[8];

  double operator()(double x) const {
    double p = 0;
    double q = 0;
    for (int n = 7; n >= 0; --n) {
      p = p * x + numerator[n];
      q = q * x + denominator[n];
    }
    return p / q;
  }
};

// Printed by tools/math_fit.py. Centre: x / q as a function of 0.425^2 - q^2, q = p - 1/2. Tails: x as a function of
// sqrt(-2 log p), for arguments to 5, to 12 and to 39 (the smallest double is at 38.6).
constexpr Quotient centre = {{3.3871328727963463, 128.73512833927406, 1830.5574815113367, 12139.224929910146,
                              38265.211503024673, 52232.989649179892, 23904.103338421833, 1633.0123040982055},
                             {1.0, 41.012366222778051, 641.63926569239473, 4815.8575442903737, 17948.909892653414,
                              31203.393235623688, 21170.851481403788, 3539.5413483390161}};
constexpr Quotient tail_to_5 = {{3.5570267368315573, 25.812776640799921, 26.650463606595695, -10.511818703587474,
                                 -18.458940422845467, -6.8605275436616253, -0.97996783966651973, -0.040704591709712315},
                                {1.0, 11.985160678905459, 28.047747611597936, 21.800875207923186, 7.0627348458397509,
                                 0.98088470472034264, 0.040694503955370546, 8.4077193212043146e-8}};
constexpr Quotient tail_to_12 = {
    {3.1265950334076228, 7.7311926372269058, -0.95508673896568813, -4.40388145698567, -1.6381288278314278,
     -0.23553577735658226, -0.013400243450964518, -2.214094559941106e-4},
    {1.0, 5.2280706302460585, 5.1901843613402608, 1.6960546326320341, 0.23683908416697258, 0.013402256658761838,
     2.2140031140411031e-4, 3.198140206525919e-11}};
constexpr Quotient tail_to_39 = {
    {2.6996261665215073, 2.7671286874304328, -1.8150307997504478, -1.7083391268888747, -0.32245287255497502,
     -0.019739733540033416, -4.0432466496906214e-4, -2.2028051024894301e-6},
    {1.0, 2.8531173875084807, 1.7923321970522097, 0.32463547983448259, 0.019755195083935424, 4.0433105614038507e-4,
     2.2027959025666677e-6, 1.0212687181546497e-14}};

// p <= 0.075.
double lower_tail(double p) {
  const double r = std::sqrt(-2 * log(p));
  return r < 5 ? tail_to_5(r) : r < 12 ? tail_to_12(r) : tail_to_39(r);
}

}  // namespace

double erf(double x) {
  if (x < 0) return -erf(-x);
  if (x < 1) return erf_series(x);
  return x > 6 ? 1 : 1 - erfc_fraction(x);
}

double inverse_normal_cdf(double p) {
  const double q = p - 0.5;
  if (q >= -0.425 && q <= 0.425) return q * centre(0.425 * 0.425 - q * q);
  if (!(p > 0 && p < 1)) {
    constexpr double endless = std::numeric_limits<double>::infinity();
    return p == 0 ? -endless : p == 1 ? endless : std::numeric_limits<double>::quiet_NaN();
  }
  return q < 0 ? lower_tail(p) : -lower_tail(1 - p);
}

}  // namespace noiseloom::math
