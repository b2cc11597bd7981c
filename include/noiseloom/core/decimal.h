// Fractions as people write them: decimal digits, kept exactly.
//
// A share of a count ("a tenth of all pixels") must not depend on how a decimal fraction is rounded to binary: 0.29 of
// 100 is 29, but floor(0.29 * 100) in double is 28. Every place of the program that turns a density into a number of
// points asks here, so that all of them find the same number.
#pragma once

#include <cstdint>
#include <string>

namespace noiseloom {

// numerator / 10^decimals, at most 1; decimals >= 0. Without trailing zeros, so that equal fractions have equal
// members.
struct DecimalFraction {
  std::uint64_t numerator = 0;  // below 10^18
  int decimals = 0;

  // The largest whole number that is not above fraction * count: exact for every count >= 0.
  std::int64_t floor_of_times(std::int64_t count) const;
  // The digits without an exponent: "0.29", "1".
  std::string text() const;
};

// "0.1", ".25", "1", "2e-3": in (0, 1], at most 18 decimals. Throws UserError naming `what` otherwise.
DecimalFraction parse_fraction(const std::string& what, const std::string& text);

// The decimal fraction that a person meant who wrote `value`: the one with the fewest digits that rounds to it.
// Requires 0 <= value <= 1.
DecimalFraction decimal_of(double value);

}  // namespace noiseloom
