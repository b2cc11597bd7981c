#include "noiseloom/core/number_type.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

static_assert(std::endian::native == std::endian::little);

template <class Bits>
Bits bits_at(const char* bytes, bool big_endian) {
  std::array<char, sizeof(Bits)> copy{};
  std::memcpy(copy.data(), bytes, sizeof(Bits));
  if (big_endian) std::reverse(copy.begin(), copy.end());
  return std::bit_cast<Bits>(copy);
}

template <class Signed, class Unsigned>
double integer(Unsigned bits, bool is_signed) {
  return is_signed ? static_cast<double>(static_cast<Signed>(bits)) : static_cast<double>(bits);
}

double float_at(const char* bytes, const NumberType& type) {
  if (type.bytes == 2) return half_to_double(bits_at<std::uint16_t>(bytes, type.big_endian));
  if (type.bytes == 4) return static_cast<double>(std::bit_cast<float>(bits_at<std::uint32_t>(bytes, type.big_endian)));
  return std::bit_cast<double>(bits_at<std::uint64_t>(bytes, type.big_endian));
}

}  // namespace

double number_at(const char* bytes, const NumberType& type) {
  if (!type.is_integer()) return float_at(bytes, type);
  const bool is_signed = type.kind == NumberType::Kind::signed_integer;
  switch (type.bytes) {
    case 1:
      return integer<std::int8_t>(bits_at<std::uint8_t>(bytes, false), is_signed);
    case 2:
      return integer<std::int16_t>(bits_at<std::uint16_t>(bytes, type.big_endian), is_signed);
    case 4:
      return integer<std::int32_t>(bits_at<std::uint32_t>(bytes, type.big_endian), is_signed);
    default:
      return integer<std::int64_t>(bits_at<std::uint64_t>(bytes, type.big_endian), is_signed);
  }
}

// 2^53 + 1 as a double is 2^53, so the bits are looked at.
bool is_exact(const char* bytes, const NumberType& type) {
  if (!type.is_integer() || type.bytes < 8) return true;
  constexpr std::uint64_t most = std::uint64_t{1} << 53;
  const std::uint64_t bits = bits_at<std::uint64_t>(bytes, type.big_endian);
  const bool negative = type.kind == NumberType::Kind::signed_integer && bits >> 63 != 0;
  return (negative ? std::uint64_t{0} - bits : bits) <= most;
}

std::string integer_text(const char* bytes, const NumberType& type) {
  NOISELOOM_CHECK_EQ(type.bytes, 8);
  const std::uint64_t bits = bits_at<std::uint64_t>(bytes, type.big_endian);
  return type.kind == NumberType::Kind::signed_integer ? std::to_string(static_cast<std::int64_t>(bits))
                                                       : std::to_string(bits);
}

double half_to_double(std::uint16_t bits) {
  const int exponent = bits >> 10 & 31;
  const int fraction = bits & 1023;
  double value = exponent == 0 ? std::ldexp(fraction, -24) : std::ldexp(1024 + fraction, exponent - 25);
  if (exponent == 31)
    value = fraction == 0 ? std::numeric_limits<double>::infinity() : std::numeric_limits<double>::quiet_NaN();
  return bits >> 15 != 0 ? -value : value;
}

std::uint16_t half_of(double value) {
  const std::uint16_t sign = std::signbit(value) ? 0x8000 : 0;
  const auto with_sign = [sign](int bits) { return static_cast<std::uint16_t>(sign | bits); };
  const double size = std::abs(value);
  if (std::isnan(value)) return with_sign(0x7E00);
  if (size == 0) return sign;
  constexpr double past_the_largest = 65520;  // halfway from the largest, 65504, to what would come next
  if (size >= past_the_largest) return with_sign(0x7C00);
  int exponent = 0;
  std::frexp(size, &exponent);  // size = 0.5 to 1 times 2^exponent
  // Steps of the numbers of that size; below 2^-14 all have the same. Rounding up may reach the next power of two,
  // whose bits follow on.
  const int step = std::max(exponent - 11, -24);
  const auto steps = static_cast<int>(std::nearbyint(std::ldexp(size, -step)));
  return with_sign(((step + 24) << 10) + steps);
}

}  // namespace noiseloom
