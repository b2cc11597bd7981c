#include "noiseloom/anneal/schedule.h"

#include <gtest/gtest.h>

namespace noiseloom {
namespace {

TEST(Schedule, CoolsGeometricallyFromStartToEnd) {
  StopSpec stop;
  stop.iterations = 101;
  EXPECT_EQ(moment_of(stop, 0, 0).fraction, 0);
  EXPECT_EQ(moment_of(stop, 50, 0).fraction, 0.5);
  EXPECT_EQ(moment_of(stop, 100, 0).fraction, 1);
  EXPECT_TRUE(moment_of(stop, 100, 0).ends_round());
  EXPECT_DOUBLE_EQ(temperature_at(2, 0.5, 0), 2);
  EXPECT_NEAR(temperature_at(2, 0.5, 0.5), 1, 1e-15);
  EXPECT_NEAR(temperature_at(2, 0.5, 1), 0.5, 1e-15);
}

TEST(Schedule, OneIterationIsCold) {
  StopSpec stop;
  stop.iterations = 1;
  EXPECT_EQ(moment_of(stop, 0, 0).fraction, 1);
}

TEST(Schedule, TimeFollowsTheClockAndSaturates) {
  StopSpec stop;
  stop.iterations = 0;
  stop.time_s = 10;
  EXPECT_EQ(moment_of(stop, 7, 2.5).fraction, 0.25);
  EXPECT_EQ(moment_of(stop, 7, 11).fraction, 1);
  EXPECT_FALSE(moment_of(stop, 7, 11).ends_round());
}

TEST(Schedule, RoundsDouble) {
  StopSpec stop;
  stop.iterations = 0;
  stop.improvement = 0.01;
  EXPECT_TRUE(moment_of(stop, 99, 0).ends_round());
  EXPECT_EQ(moment_of(stop, 100, 0).round, 1);
  EXPECT_EQ(moment_of(stop, 100, 0).fraction, 0);
  EXPECT_TRUE(moment_of(stop, 299, 0).ends_round());
  EXPECT_EQ(moment_of(stop, 300, 0).round_length, 400);
}

TEST(Schedule, ScoresAboutFiftyTimesAndAtTheEnd) {
  for (const std::int64_t iterations : {1, 7, 50, 1000, 12345}) {
    StopSpec stop;
    stop.iterations = iterations;
    int scores = 0;
    for (std::int64_t sweep = 0; sweep < iterations; ++sweep) scores += score_due(moment_of(stop, sweep, 0), 50);
    EXPECT_TRUE(score_due(moment_of(stop, iterations - 1, 0), 50));
    EXPECT_GE(scores, std::min<std::int64_t>(iterations, 50));
    EXPECT_LE(scores, 101);
  }
}

}  // namespace
}  // namespace noiseloom
