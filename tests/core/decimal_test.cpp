// Shares of counts are those of the decimal digits, not of the binary numbers nearest to them.
#include "noiseloom/core/decimal.h"

#include <gmock/gmock.h>

#include <string>

#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

using testing::HasSubstr;

std::string refusal(const std::string& text) {
  try {
    parse_fraction("--threshold", text);
  } catch (const UserError& error) {
    return error.what();
  }
  return "";
}

TEST(ParseFraction, KeepsDecimalsExactly) {
  EXPECT_EQ(parse_fraction("t", "0.29").floor_of_times(100), 29);  // 28 in double
  EXPECT_EQ(parse_fraction("t", ".1").floor_of_times(10), 1);
  EXPECT_EQ(parse_fraction("t", "1").floor_of_times(462), 462);
  EXPECT_EQ(parse_fraction("t", "1.000").floor_of_times(462), 462);
  EXPECT_EQ(parse_fraction("t", "0.100").floor_of_times(459), 45);
  EXPECT_EQ(parse_fraction("t", "25e-2").floor_of_times(7), 1);
  EXPECT_EQ(parse_fraction("t", "0.025E1").floor_of_times(8), 2);
  // Past 2^53 no pixel is lost either.
  const std::int64_t many = (std::int64_t{1} << 62) + 3;
  EXPECT_EQ(parse_fraction("t", "0.5").floor_of_times(many), (std::int64_t{1} << 61) + 1);
  EXPECT_EQ(parse_fraction("t", "0.999999999999999999").floor_of_times(many), many - 5);
  EXPECT_EQ(parse_fraction("t", "1").floor_of_times(many), many);
}

TEST(ParseFraction, RefusesWhatIsNoFraction) {
  for (const char* const text : {"", ".", "0", "0.0", "-0.1", "1.1", "10", "2", "0,1", "0.1x", "1e", "e-1", "1e1",
                                 "nan", "0.1.2", "0x1p-3", "1e99999999999", "10 %", "0.1234567890123456789"})
    EXPECT_THAT(refusal(text), HasSubstr(std::string("--threshold ") + text + ": "));
}

// The slow twin: whole numbers alone. floor(percent / 100 * count), with the fraction as text and as a double.
TEST(DecimalOf, FindsTheSameShareAsTheDigits) {
  int differs_in_double = 0;
  for (int percent = 1; percent <= 100; ++percent)
    for (const std::int64_t count : {100, 300, 462, 10'000, 40'000, 16'384, 1'000'003}) {
      const double value = percent / 100.0;
      const std::int64_t expected = percent * count / 100;
      EXPECT_EQ(decimal_of(value).floor_of_times(count), expected) << percent << " % of " << count;
      differs_in_double += static_cast<std::int64_t>(value * static_cast<double>(count)) != expected;
    }
  EXPECT_GT(differs_in_double, 0) << "these cases do not show the fault";
}

// Masks whose sizes are powers of two keep the number of points that a product in double gave them.
TEST(DecimalOf, AgreesWithDoubleForPowersOfTwo) {
  for (int thousandths = 1; thousandths <= 500; ++thousandths)
    for (int bits = 0; bits <= 40; ++bits) {
      const std::int64_t count = std::int64_t{1} << bits;
      const double value = thousandths / 1000.0;
      ASSERT_EQ(decimal_of(value).floor_of_times(count), static_cast<std::int64_t>(value * static_cast<double>(count)))
          << value << " of " << count;
    }
}

TEST(DecimalOf, HoldsTheSmallestAndTheLargest) {
  EXPECT_EQ(decimal_of(0).floor_of_times(1'000'000), 0);
  EXPECT_EQ(decimal_of(1).floor_of_times(462), 462);
  EXPECT_EQ(decimal_of(5e-324).floor_of_times(std::int64_t{1} << 62), 0);
  EXPECT_EQ(decimal_of(1e-18).floor_of_times(std::int64_t{1} << 62), 4);
}

TEST(DecimalFraction, WritesItsDigits) {
  for (const char* const text : {"0.1", "0.29", "1", "0.000000000000000001", "0.025"})
    EXPECT_EQ(parse_fraction("t", text).text(), text);
  EXPECT_EQ(parse_fraction("t", ".250").text(), "0.25");
  EXPECT_EQ(parse_fraction("t", "1e-3").text(), "0.001");
}

}  // namespace
}  // namespace noiseloom
