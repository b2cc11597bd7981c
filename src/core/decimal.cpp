#include "noiseloom/core/decimal.h"

#include <array>
#include <charconv>
#include <cstdlib>
#include <string_view>

#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

constexpr int most_decimals = 18;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Digits with at most one point among them, then perhaps an exponent. Returns false where the text is nothing of the
// kind; `fits` becomes false where there are more significant digits than are kept.
bool read_decimal(std::string_view text, DecimalFraction& fraction, bool& fits) {
  std::size_t at = 0;
  int digits = 0;
  bool point = false;
  fits = true;
  for (; at < text.size() && (is_digit(text[at]) || (text[at] == '.' && !point)); ++at) {
    if (text[at] == '.') {
      point = true;
      continue;
    }
    ++digits;
    if (fraction.numerator == 0 && text[at] == '0') {
      fraction.decimals += point ? 1 : 0;
      continue;
    }
    fits = fits && fraction.numerator < 100'000'000'000'000'000U;  // 18 digits at most
    if (fits) fraction.numerator = 10 * fraction.numerator + static_cast<std::uint64_t>(text[at] - '0');
    fraction.decimals += point ? 1 : 0;
  }
  if (digits == 0) return false;
  if (at == text.size()) return true;
  int exponent = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data() + at + 1, end, exponent);
  if ((text[at] != 'e' && text[at] != 'E') || error != std::errc{} || stop != end || std::abs(exponent) > 1000)
    return false;
  fraction.decimals -= exponent;
  return true;
}

void strip_trailing_zeros(DecimalFraction& fraction) {
  if (fraction.numerator == 0) fraction.decimals = 0;
  while (fraction.numerator > 0 && fraction.numerator % 10 == 0) {
    fraction.numerator /= 10;
    --fraction.decimals;
  }
}

}  // namespace

std::int64_t DecimalFraction::floor_of_times(std::int64_t count) const {
  // 10^18 times 2^63 is below 10^37, and 10^38 fits: with more decimals than that nothing is left of any count.
  __extension__ using Wide = unsigned __int128;
  constexpr int most_digits = 38;
  if (decimals > most_digits) return 0;
  Wide power = 1;
  for (int i = 0; i < decimals; ++i) power *= 10;
  return static_cast<std::int64_t>(Wide{numerator} * static_cast<std::uint64_t>(count) / power);
}

std::string DecimalFraction::text() const {
  std::string digits = std::to_string(numerator);
  if (decimals == 0) return digits;
  const auto places = static_cast<std::size_t>(decimals);
  if (digits.size() <= places) digits = std::string(places + 1 - digits.size(), '0') + digits;
  const std::size_t point = digits.size() - places;
  return digits.substr(0, point) + "." + digits.substr(point);
}

DecimalFraction parse_fraction(const std::string& what, const std::string& text) {
  DecimalFraction fraction;
  bool fits = true;
  const auto refuse = [&](const std::string& why) { throw UserError("command line", what + " " + text + ": " + why); };
  if (!read_decimal(text, fraction, fits)) refuse("must be a number above 0 and at most 1, such as 0.1");
  strip_trailing_zeros(fraction);
  // A number that keeps a last digit other than 0 before the point is 1 or more; only 1 itself is accepted.
  const bool is_one = fraction.numerator == 1 && fraction.decimals == 0;
  if (fraction.numerator == 0 || (fraction.decimals <= 0 && !is_one)) refuse("must be above 0 and at most 1");
  if (!fits || fraction.decimals > most_decimals)
    refuse("has more than " + std::to_string(most_decimals) + " decimals");
  std::uint64_t one = 1;
  for (int i = 0; i < fraction.decimals; ++i) one *= 10;
  if (fraction.numerator > one) refuse("must be above 0 and at most 1");
  return fraction;
}

DecimalFraction decimal_of(double value) {
  NOISELOOM_CHECK(value >= 0 && value <= 1);
  std::array<char, 32> shortest{};  // at most 17 digits, a point and an exponent
  const auto [end, error] = std::to_chars(shortest.data(), shortest.data() + shortest.size(), value);
  NOISELOOM_CHECK(error == std::errc{});
  DecimalFraction fraction;
  bool fits = true;
  NOISELOOM_CHECK(
      read_decimal(std::string_view(shortest.data(), static_cast<std::size_t>(end - shortest.data())), fraction, fits));
  strip_trailing_zeros(fraction);
  return fraction;
}

}  // namespace noiseloom
