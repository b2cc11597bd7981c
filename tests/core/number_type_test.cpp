// Floats of 16 bits.
#include "noiseloom/core/number_type.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace noiseloom {
namespace {

TEST(Half, EveryFloatOf16BitsComesBack) {
  for (int bits = 0; bits < 65536; ++bits) {
    const double value = half_to_double(static_cast<std::uint16_t>(bits));
    if (std::isnan(value)) {
      EXPECT_TRUE(std::isnan(half_to_double(half_of(value))));
      continue;
    }
    ASSERT_EQ(half_of(value), bits);
  }
}

TEST(Half, IsTheNearestOneTiesToEven) {
  for (int bits = 0; bits < 0x7BFF; ++bits) {
    const double low = half_to_double(static_cast<std::uint16_t>(bits));
    const double high = half_to_double(static_cast<std::uint16_t>(bits + 1));
    const double middle = (low + high) / 2;
    ASSERT_EQ(half_of(std::nextafter(middle, low)), bits);
    ASSERT_EQ(half_of(std::nextafter(middle, high)), bits + 1);
    ASSERT_EQ(half_of(middle), bits % 2 == 0 ? bits : bits + 1);
    ASSERT_EQ(half_of(-middle), 0x8000 | (bits % 2 == 0 ? bits : bits + 1));
  }
  EXPECT_EQ(half_of(65519), 0x7BFF);
  EXPECT_EQ(half_of(65520), 0x7C00);
  EXPECT_EQ(half_of(-std::numeric_limits<double>::infinity()), 0xFC00);
  EXPECT_EQ(half_of(1e-30), 0);
}

}  // namespace
}  // namespace noiseloom
