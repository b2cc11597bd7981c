// Numbers as pages and plots write them: digits and a point, never an exponent, so that 0.0005 stands beside 0.001.
#pragma once

#include <string>

namespace noiseloom {

// With at most `digits` significant digits, without zeros at the end: "0.00037", "1", "20000". At most twelve decimals
// are written: what is smaller is 0. "none" for NaN.
std::string number_text(double value, int digits);

// R, with the four decimals that it is always told with.
std::string error_text(double relative_error);

}  // namespace noiseloom
