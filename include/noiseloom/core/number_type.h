// How a number is stored in files: floats and integers of 1 to 8 bytes, in either byte order.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace noiseloom {

struct NumberType {
  enum class Kind { floating, signed_integer, unsigned_integer };
  Kind kind = Kind::floating;
  int bytes = 4;  // floats: 2, 4 or 8; integers: 1, 2, 4 or 8
  bool big_endian = false;

  bool is_integer() const { return kind != Kind::floating; }
  friend bool operator==(const NumberType&, const NumberType&) = default;
};

// The value of `type.bytes` bytes. Integers beyond 2^53 are rounded.
double number_at(const char* bytes, const NumberType& type);
// False for integers beyond +-2^53, which do not fit a double.
bool is_exact(const char* bytes, const NumberType& type);
// The integer in digits. Requires an integer type of 8 bytes.
std::string integer_text(const char* bytes, const NumberType& type);

// The value of a float of 16 bits (IEEE 754 binary16).
double half_to_double(std::uint16_t bits);
// The nearest float of 16 bits, ties to even; infinite beyond 65504.
std::uint16_t half_of(double value);

}  // namespace noiseloom
