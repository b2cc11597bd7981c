// Which runs may go on beyond the end that they were given.
#include "noiseloom/run/resume.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace noiseloom {
namespace {

using testing::HasSubstr;

StopSpec iterations(std::int64_t count) { return {.iterations = count}; }
StopSpec seconds(double time_s) { return {.iterations = 0, .time_s = time_s}; }
StopSpec score(double value) { return {.iterations = 0, .score = value}; }
StopSpec improvement(double value) { return {.iterations = 0, .improvement = value}; }

std::string why_not(StopSpec before, StopSpec now, Method method = Method::anneal, bool grow_fraction = true) {
  OptimizerSpec first;
  first.method = method;
  first.grow_fraction = grow_fraction;
  first.stop = before;
  OptimizerSpec second = first;
  second.stop = now;
  return why_not_extended(first, second);
}

TEST(Extension, RoundsDoNotDependOnTheirEnd) {
  for (const Method method : {Method::anneal, Method::fast}) {
    EXPECT_EQ(why_not(score(0.3), score(0.2), method), "");
    EXPECT_EQ(why_not(improvement(0.1), improvement(0.01), method), "");
    EXPECT_THAT(why_not(score(0.2), score(0.3), method), HasSubstr("score = 0.2 in the file, score = 0.3 here"));
    EXPECT_THAT(why_not(improvement(0.01), improvement(0.1), method), HasSubstr("not shortened"));
  }
}

TEST(Extension, AScheduleThatRunsToItsEndHasNoOther) {
  EXPECT_THAT(why_not(iterations(30), iterations(60)),
              HasSubstr("a run of 60 is not one of 30 and 30 more; start it afresh"));
  EXPECT_THAT(why_not(iterations(60), iterations(30)), HasSubstr("not shortened"));
  EXPECT_THAT(why_not(seconds(10), seconds(20)), HasSubstr("follows the clock"));
  EXPECT_THAT(why_not(seconds(10), score(0.2)), HasSubstr("the rule itself must stay"));
  EXPECT_THAT(why_not(score(0.2), improvement(0.2)), HasSubstr("the rule itself must stay"));
}

TEST(Extension, ThePublishedAlgorithmGoesOnWhereItsFractionGrowsAsOften) {
  EXPECT_EQ(why_not(iterations(30), iterations(10'000), Method::fast), "");
  EXPECT_EQ(why_not(iterations(10'000), iterations(10'099), Method::fast), "");
  EXPECT_THAT(why_not(iterations(30), iterations(10'100), Method::fast), HasSubstr("once in 100 sweeps"));
  EXPECT_EQ(why_not(iterations(30), iterations(1'000'000), Method::fast, false), "");
  EXPECT_THAT(why_not(iterations(30), iterations(29), Method::fast, false), HasSubstr("not shortened"));
}

}  // namespace
}  // namespace noiseloom
