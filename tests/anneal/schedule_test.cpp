#include "noiseloom/anneal/schedule.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "noiseloom/anneal/cooling.h"
#include "noiseloom/anneal/swap_choices.h"

namespace noiseloom {
namespace {

StopSpec stop_at_iterations(std::int64_t iterations) {
  StopSpec stop;
  stop.iterations = iterations;
  return stop;
}
StopSpec stop_at_score(double score) {
  StopSpec stop;
  stop.iterations = 0;
  stop.score = score;
  return stop;
}
StopSpec stop_at_improvement(double improvement) {
  StopSpec stop;
  stop.iterations = 0;
  stop.improvement = improvement;
  return stop;
}

TEST(Schedule, CoolsGeometricallyFromStartToEnd) {
  const Schedule schedule(stop_at_iterations(101), 1);
  EXPECT_EQ(schedule.moment(0, 0).fraction, 0);
  EXPECT_EQ(schedule.moment(50, 0).fraction, 0.5);
  EXPECT_EQ(schedule.moment(100, 0).fraction, 1);
  EXPECT_TRUE(schedule.moment(100, 0).ends_round());
  EXPECT_DOUBLE_EQ(temperature_at(2, 0.5, 0), 2);
  EXPECT_NEAR(temperature_at(2, 0.5, 0.5), 1, 1e-15);
  EXPECT_NEAR(temperature_at(2, 0.5, 1), 0.5, 1e-15);
  EXPECT_EQ(cooled(0, 3), 0);
  EXPECT_NEAR(cooled(0.5, 3), 0.125, 1e-15);
  EXPECT_EQ(cooled(0.3, 1), 0.3);
  EXPECT_EQ(cooled(1, 3), 1);
}

TEST(Schedule, OneIterationIsCold) { EXPECT_EQ(Schedule(stop_at_iterations(1), 1).moment(0, 0).fraction, 1); }

TEST(Schedule, TheLastSweepMakesTheIterationsThatAreLeft) {
  const Schedule schedule(stop_at_iterations(20), 8);
  EXPECT_EQ(schedule.iterations_before(0), 0);
  EXPECT_EQ(schedule.iterations_before(2), 16);
  EXPECT_EQ(schedule.iterations_before(3), 20);
  EXPECT_TRUE(schedule.moment(2, 0).ends_round());
  EXPECT_EQ(schedule.ended_by(schedule.moment(1, 0), 0.5, 0), "");
  EXPECT_EQ(schedule.ended_by(schedule.moment(2, 0), 0.5, 0), ended::by_iterations);
}

TEST(Schedule, TimeFollowsTheClockAndSaturates) {
  StopSpec stop;
  stop.iterations = 0;
  stop.time_s = 10;
  const Schedule schedule(stop, 8);
  EXPECT_EQ(schedule.moment(7, 2.5).fraction, 0.25);
  EXPECT_EQ(schedule.moment(7, 11).fraction, 1);
  EXPECT_FALSE(schedule.moment(7, 11).ends_round());
}

TEST(Schedule, RoundsOfAHundredIterationsDouble) {
  for (const std::int64_t per_sweep : {1, 4, 8}) {
    const Schedule schedule(stop_at_improvement(0.01), per_sweep);
    const std::int64_t first = (100 + per_sweep - 1) / per_sweep;
    EXPECT_TRUE(schedule.moment(first - 1, 0).ends_round());
    EXPECT_EQ(schedule.moment(first, 0).round, 1);
    EXPECT_EQ(schedule.moment(first, 0).fraction, 0);
    EXPECT_TRUE(schedule.moment(3 * first - 1, 0).ends_round());
    EXPECT_EQ(schedule.moment(3 * first, 0).round_length, 4 * first);
    EXPECT_EQ(schedule.iterations_of_round(schedule.moment(3 * first, 0)), 4 * first * per_sweep);
  }
}

TEST(Schedule, ScoresAsOftenAsWantedAndAtTheEnd) {
  for (const std::int64_t iterations : {1, 7, 50, 1000, 12345}) {
    const Schedule schedule(stop_at_iterations(iterations), 1);
    int scores = 0;
    for (std::int64_t sweep = 0; sweep < iterations; ++sweep) scores += score_due(schedule.moment(sweep, 0), 50);
    EXPECT_TRUE(score_due(schedule.moment(iterations - 1, 0), 50));
    EXPECT_EQ(scores, std::min<std::int64_t>(iterations, 50));
  }
}

TEST(Schedule, ScoresThatDoNotKnowTheEndGrowSparser) {
  std::vector<std::int64_t> due;
  for (std::int64_t sweeps = 1; sweeps <= 64; ++sweeps) {
    if (score_due_without_end(sweeps, 1)) due.push_back(sweeps);
  }
  EXPECT_THAT(due, testing::ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 18, 20, 22, 24, 26, 28,
                                        30, 32, 36, 40, 44, 48, 52, 56, 60, 64));
  due.clear();
  for (std::int64_t sweeps = 1; sweeps <= 64; ++sweeps) {
    if (score_due_without_end(sweeps, 7)) due.push_back(sweeps);
  }
  EXPECT_THAT(due, testing::ElementsAre(7, 14, 21, 28, 35, 42, 49, 56, 63, 64));
}

TEST(Schedule, ScoresOfAHistoryCostLittle) {
  for (const double worth : {0.01, 1.0, 30.0, 1e6}) {  // iterations that cost as much as one
    for (const std::int64_t iterations : {1, 20, 200, 1000, 100'000}) {
      const std::int64_t rows = scores_per_round(worth, iterations);
      EXPECT_GE(rows, 1);
      EXPECT_LE(rows, 50);
      const double share = static_cast<double>(rows) * worth / static_cast<double>(iterations);
      EXPECT_TRUE(rows == 1 || share <= (rows <= 8 ? 1.0 / 20 : 1.0 / 40)) << worth << " " << iterations;
    }
    EXPECT_LE(worth / static_cast<double>(score_interval(worth)), 1.0 / 40);
  }
  EXPECT_EQ(scores_per_round(1, 100'000), 50);
  EXPECT_EQ(scores_per_round(1, 200), 8);
}

// Rounds of 100, 200, 400, ... iterations, one iteration a sweep, that end with R as `score_of` says of their length;
// how many iterations are done when the rule ends the run, and why it did.
struct Ending {
  std::int64_t iterations;
  std::string reason;
};
template <class ScoreOf>
Ending ending(const StopSpec& stop, const ScoreOf& score_of) {
  const Schedule schedule(stop, 1);
  double before = 0;
  std::int64_t done = 0;
  for (std::int64_t length = 100; length < 1'000'000'000; length *= 2) {
    done += length;
    const double score = score_of(static_cast<double>(length));
    const std::string reason = schedule.ended_by(schedule.moment(done - 1, 0), score, before);
    if (!reason.empty()) return {done, reason};
    before = score;
  }
  return {done, ""};
}

// As measured on scalars of 64x64x16: R of runs of 100 to 6,400 iterations.
double typical_score(double iterations) { return 0.087 + 0.038 * std::pow(iterations / 100, -0.38); }

TEST(Schedule, ImprovementIsPerHundredIterations) {
  // 800 iterations instead of 400 lower R by 5 %, 1.2 % for each hundred.
  EXPECT_EQ(ending(stop_at_improvement(0.02), typical_score).iterations, 100 + 200 + 400 + 800);
  EXPECT_EQ(ending(stop_at_improvement(0.02), typical_score).reason, ended::by_improvement);
  const std::int64_t deep = ending(stop_at_improvement(0.001), typical_score).iterations;
  EXPECT_GT(deep, 5'000);
  EXPECT_LT(deep, 50'000);
  // Rounds that make nothing better end any such run.
  EXPECT_EQ(ending(stop_at_improvement(1e-9), [](double) { return 0.3; }).iterations, 300);
}

TEST(Schedule, AScoreEndsWhereItIsReached) {
  const Ending reached = ending(stop_at_score(0.1), typical_score);
  EXPECT_EQ(reached.reason, ended::by_score);
  EXPECT_LE(typical_score(static_cast<double>(reached.iterations + 100) / 2), 0.1);
  const Schedule schedule(stop_at_score(0.1), 1);
  EXPECT_EQ(schedule.ended_by(schedule.moment(17, 0), 0.1, 0), ended::by_score);  // in the middle of a round too
  EXPECT_EQ(schedule.ended_by(schedule.moment(17, 0), 0.1001, 0), "");
}

TEST(Schedule, AScoreOutOfReachEndsTheRunAndOneWithinReachDoesNot) {
  EXPECT_EQ(ending(stop_at_score(0.05), typical_score).reason, ended::out_of_reach);
  EXPECT_LT(ending(stop_at_score(0.05), typical_score).iterations, 10'000);
  EXPECT_EQ(ending(stop_at_score(0.05), [](double) { return 0.3; }).reason, ended::out_of_reach);
  EXPECT_EQ(ending(stop_at_score(0.086), typical_score).reason, ended::out_of_reach);  // just below what can be had
  for (const double target : {0.11, 0.1, 0.095, 0.092, 0.09}) {
    EXPECT_EQ(ending(stop_at_score(target), typical_score).reason, ended::by_score) << target;
  }
}

TEST(Schedule, EndsColderWhereScalarsJoinIt) {
  const TemperatureRange whole{0.11, 8e-4};
  const TemperatureRange colder = joined_range(whole, 0.5);
  EXPECT_LT(colder.end, whole.end);
  EXPECT_EQ(colder.start, temperature_at(whole.start, whole.end, 0.5));
  EXPECT_TRUE(ends_colder(DistanceKind::absolute, 1, false));
  EXPECT_FALSE(ends_colder(DistanceKind::absolute, 1, true));
  EXPECT_FALSE(ends_colder(DistanceKind::circle, 1, false));
}

}  // namespace
}  // namespace noiseloom
