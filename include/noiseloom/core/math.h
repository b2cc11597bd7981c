// Elementary functions whose results are the same bits on every machine.
//
// The C library's exp, log, sin, cos, acos, pow and erf pick FMA variants at run time and so change their last bit with
// the CPU. Whatever decides a result (samples, taps, acceptance) uses these instead: only +, -, *, /, sqrt of IEEE
// doubles, compiled without contraction. Each states its largest error, which tests/core/math_test.cpp checks.
#pragma once

namespace noiseloom::math {

double exp(double x);                      // relative error <= 1e-15; 0 and inf past the range
double log(double x);                      // x > 0; absolute error <= 1e-15 * max(1, |log x|)
double pow(double base, double exponent);  // base >= 0; relative error <= 1e-14 * max(1, |exponent * log base|)
double sin_2pi(double turns);              // sin(2 pi turns); absolute error <= 5e-16 for |turns| <= 2^20
double cos_2pi(double turns);
double acos(double x);                // x in [-1, 1] (values outside are clamped); absolute error <= 5e-16 * 2
double erf(double x);                 // absolute error <= 1e-15
double inverse_normal_cdf(double p);  // 0 < p < 1; relative error <= 1e-13 (p is not near 0 or 1 by cancellation here)

}  // namespace noiseloom::math
