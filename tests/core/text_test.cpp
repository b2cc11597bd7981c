#include "noiseloom/core/text.h"

#include <gtest/gtest.h>

#include <limits>

#include "noiseloom/core/quantity_text.h"

namespace noiseloom {
namespace {

TEST(NumberText, IsTheShortestThatReadsBackAndIsNoInteger) {
  EXPECT_EQ(number_text(1), "1.0");
  EXPECT_EQ(number_text(-0.0), "-0.0");
  EXPECT_EQ(number_text(0.1), "0.1");
  EXPECT_EQ(number_text(1.0 / 3), "0.3333333333333333");
  EXPECT_EQ(number_text(1e-300), "1e-300");
  EXPECT_EQ(number_text(9007199254740993.0), "9007199254740992.0");
  EXPECT_EQ(number_text(std::numeric_limits<double>::infinity()), "inf");
  EXPECT_EQ(number_text(std::numeric_limits<double>::quiet_NaN()), "nan");
}

TEST(DigitsText, HasThreeDigitsAndNoExponentButForTheTiniest) {
  EXPECT_EQ(digits_text(0.001), "0.00100");
  EXPECT_EQ(digits_text(0.00043219), "0.000432");
  EXPECT_EQ(digits_text(4.3219e-7), "0.000000432");
  EXPECT_EQ(digits_text(4.3219e-13), "4.32e-13");
  EXPECT_EQ(digits_text(1), "1.00");
  EXPECT_EQ(digits_text(-12.345), "-12.3");
  EXPECT_EQ(digits_text(1234567), "1234567");
  EXPECT_EQ(digits_text(0), "0");
  EXPECT_EQ(digits_text(std::numeric_limits<double>::infinity()), "inf");
}

TEST(Shortened, CutsBetweenCharacters) {
  EXPECT_EQ(shortened("abcdef", 6), "abcdef");
  EXPECT_EQ(shortened("abcdefg", 6), "ab ...");
  EXPECT_EQ(shortened("a\u00e9\u00e9\u00e9", 6), "a ...");
  EXPECT_EQ(shortened("\u00e9\u00e9\u00e9\u00e9", 6), "\u00e9 ...");
  EXPECT_EQ(shortened("\x80\x80\x80\x80\x80\x80\x80", 6), " ...");
}

TEST(ParseDuration, ReadsUnitsFromLargeToSmall) {
  EXPECT_EQ(parse_duration("10s"), 10.0);
  EXPECT_EQ(parse_duration("5m"), 300.0);
  EXPECT_EQ(parse_duration("2h"), 7200.0);
  EXPECT_EQ(parse_duration("1h30m"), 5400.0);
  EXPECT_EQ(parse_duration("1.5h"), 5400.0);
  EXPECT_EQ(parse_duration("1d0h0m0.5s"), 86400.5);
  EXPECT_EQ(parse_duration("90"), 90.0);
  EXPECT_EQ(parse_duration("0"), 0.0);
}

TEST(ParseDuration, RefusesEverythingElse) {
  for (const char* text : {"", "s", "-1s", "1x", "10 s", " 10s", "1h30", "1m1h", "1s1s", "1e3", "inf", "nan", "0x10",
                           "1h ", "+1", ".5s", "10ms"}) {
    EXPECT_EQ(parse_duration(text), std::nullopt) << text;
  }
}

}  // namespace
}  // namespace noiseloom
