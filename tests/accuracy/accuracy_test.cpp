// What accuracy costs: the ladder, what fits into a budget, the table on disk.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "accuracy/accuracy_score.h"
#include "accuracy/ladder_support.h"
#include "noiseloom/accuracy/accuracy_ladder.h"
#include "noiseloom/accuracy/accuracy_table.h"
#include "support/run_files.h"

namespace noiseloom {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

AccuracyLadder ladder_of(const std::string& optimizer, bool background = true, bool scalar = false, int runs = 1) {
  const bool named = optimizer.find("method") != std::string::npos;
  return accuracy_ladder(config_with((named ? "" : "method = \"anneal\"\n") + optimizer),
                         {.constructs = scalar, .background = background, .exact_cost = background ? 10.0 : 1.0}, runs);
}

std::vector<std::int64_t> iterations_of(const AccuracyLadder& ladder, Method method) {
  std::vector<std::int64_t> counts;
  for (const AccuracyPoint& point : ladder.lines)
    if (point.method == method) counts.push_back(point.iterations);
  return counts;
}

std::vector<std::string> values_of(const AccuracyLadder& ladder, const std::string& setting) {
  std::vector<std::string> values;
  for (const AccuracyKnob& knob : ladder.knobs)
    if (knob.setting == setting) values.push_back(knob.value);
  return values;
}

// What a run takes on an imagined machine.
double imagined_seconds(const AccuracyPoint& point, double per_iteration) {
  const double factor = point.method == Method::fast ? 0.5 : point.setting == "precision" ? 20 : 1;
  return 0.25 + factor * per_iteration * static_cast<double>(point.iterations);
}

// Every point that runs within the budget on that machine.
LadderStep climb(const AccuracyLadder& ladder, double budget_s, double per_iteration, std::vector<TimedPoint>& done) {
  double spent = 0;
  for (const TimedPoint& run : done) spent += run.seconds;
  for (;;) {
    LadderStep step = next_step(ladder, done, {}, budget_s - spent, budget_s);
    if (!step.next) return step;
    const double seconds = imagined_seconds(*step.next, per_iteration);
    done.push_back({*step.next, seconds, 1 / seconds});
    spent += seconds;
  }
}

TEST(AccuracyLadder, RisesOnBothLinesWithTheDefaultAmongThem) {
  const AccuracyLadder ladder = ladder_of("stop = { iterations = 1000 }\n");
  EXPECT_THAT(iterations_of(ladder, Method::anneal),
              ElementsAre(25, 50, 100, 200, 400, 800, 1000, 1600, 3200, 6400, 12800, 25600));
  EXPECT_THAT(iterations_of(ladder, Method::fast), ElementsAre(10, 30, 100, 300, 1000, 3000, 10000));
  EXPECT_EQ(ladder.default_point().iterations, 1000);
  EXPECT_EQ(std::count_if(ladder.lines.begin(), ladder.lines.end(), [](const auto& p) { return p.is_default; }), 1);
  EXPECT_THAT(iterations_of(ladder_of("stop = { iterations = 200 }\n"), Method::anneal),
              ElementsAre(25, 50, 100, 200, 400, 800, 1600, 3200, 6400, 12800, 25600));
}

TEST(AccuracyLadder, ChangesEachSettingAwayFromTheConfigs) {
  const AccuracyLadder ladder = ladder_of("cutoff = 0.01\nbackground_features = 8\n");
  EXPECT_THAT(values_of(ladder, "cutoff"), ElementsAre("0", "0.001", "0.05"));
  EXPECT_THAT(values_of(ladder_of(""), "cutoff"), ElementsAre("0", "0.01", "0.05"));
  EXPECT_THAT(values_of(ladder_of("method = \"fast\"\n"), "cutoff"), ElementsAre("0.001", "0.01", "0.05"));
  EXPECT_THAT(values_of(ladder, "background_features"), ElementsAre("0", "4", "16", "32"));
  EXPECT_THAT(values_of(ladder, "precision"), ElementsAre("double"));
  EXPECT_THAT(values_of(ladder_of("", false), "background_features"), IsEmpty());
  EXPECT_THAT(values_of(ladder_of("precision = \"double\"\n"), "precision"), ElementsAre("float"));
  EXPECT_EQ(ladder_of("method = \"fast\"\n", false).method, Method::fast);
}

TEST(AccuracyLadder, ComparesMethodsThatMakeTheSameKindOfTexture) {
  // Construction alone is one point, and is tried as soon as there is time.
  const AccuracyLadder anneal = ladder_of("stop = { iterations = 1000 }\n", true, true);
  EXPECT_THAT(names_of(anneal.lines),
              AllOf(Contains("construct"), Contains("construct-400"), Contains("anneal-25"), Contains("fast-10")));
  std::vector<TimedPoint> done;
  climb(anneal, 3, 1e-3, done);
  EXPECT_TRUE(
      std::any_of(done.begin(), done.end(), [](const auto& run) { return point_name(run.point) == "construct"; }));
  EXPECT_THAT(names_of(ladder_of("", true, false).lines), Not(Contains("construct")));
  EXPECT_EQ(describe_point({Method::construct, "iterations", "400", 400, false}), "construct, then 400 iterations");
  // A config of construction has no iterations of its own and no settings of swaps.
  const AccuracyLadder construct = ladder_of("method = \"construct\"\n", true, true);
  EXPECT_EQ(point_name(construct.default_point()), "default");
  EXPECT_THAT(names_of(construct.lines),
              AllOf(Contains("anneal-1600"), Contains("fast-300"), Not(Contains("construct"))));
  EXPECT_THAT(names_of(construct.lines), Contains("construct-25600"));
  EXPECT_THAT(construct.knobs, IsEmpty());
  const AccuracyLadder annealed = ladder_of("method = \"construct\"\nstop = { iterations = 400 }\n", true, true);
  EXPECT_EQ(annealed.default_point().iterations, 400);
  EXPECT_THAT(iterations_of(annealed, Method::construct), ElementsAre(0, 100, 400, 1600, 6400, 25600));
  const AccuracyLadder timed = ladder_of("method = \"construct\"\nstop = { time = 30 }\n", true, true);
  EXPECT_EQ(predicted_seconds(timed, timed.default_point(), {}), 32);
  done.clear();
  EXPECT_THAT(climb(construct, 1e9, 1e-3, done).left_out, IsEmpty());
  EXPECT_TRUE(done.front().point.is_default);
}

TEST(AccuracyLadder, ComparesAMaskWithOthersThatWrapAround) {
  const AccuracyLadder mask = accuracy_ladder(parse_config(order_config, "m.toml", "", {}), {.constructs = true});
  EXPECT_EQ(mask.default_point().method, Method::void_and_cluster);
  EXPECT_THAT(names_of(mask.lines), AllOf(Contains("anneal-25"), Contains("fast-10"), Contains("construct")));
  const AccuracyLadder bounded =
      accuracy_ladder(parse_config(order_config + "bounded = \"t\"\n", "m.toml", "", {}), {.constructs = true});
  EXPECT_THAT(names_of(bounded.lines), ElementsAre("default"));
  std::vector<TimedPoint> done;
  const LadderStep end = climb(bounded, 100, 1e-3, done);
  EXPECT_EQ(end.left_out.size(), 3U);
  EXPECT_THAT(end.left_out, testing::Each(testing::Field(&LeftOut::reason, HasSubstr("wrap around"))));
}

TEST(AccuracyLadder, NamesEveryPointDifferently) {
  const AccuracyLadder ladder = ladder_of("stop = { iterations = 300 }\n");
  std::set<std::string> names;
  std::vector<TimedPoint> done;
  climb(ladder, 1e9, 1e-3, done);
  for (const TimedPoint& run : done) EXPECT_TRUE(names.insert(point_name(run.point)).second) << point_name(run.point);
  EXPECT_EQ(names.size(), ladder.lines.size() + ladder.knobs.size());
}

TEST(AccuracyPrediction, FollowsTheLineThroughStartUpAndIterations) {
  const AccuracyLadder ladder = ladder_of("");
  const auto point = [](std::int64_t n) {
    return AccuracyPoint{Method::anneal, "iterations", std::to_string(n), n, false};
  };
  EXPECT_EQ(predicted_seconds(ladder, point(100), {}), std::nullopt);
  EXPECT_DOUBLE_EQ(*predicted_seconds(ladder, point(100), {{point(25), 2}}), 2 + 0.5 * 2 / 25 * 75);
  const std::vector<TimedPoint> done = {{point(25), 1 + 25}, {point(50), 1 + 50}};
  EXPECT_DOUBLE_EQ(*predicted_seconds(ladder, point(200), done), 1 + 200);
  // Start-up is believed in when three runs show it.
  const std::vector<TimedPoint> flat = {{point(25), 10}, {point(50), 11}, {point(100), 13}};
  EXPECT_DOUBLE_EQ(*predicted_seconds(ladder, point(200), {flat[0], flat[1]}), 11 + 0.5 * 11 / 50 * 150);
  EXPECT_DOUBLE_EQ(*predicted_seconds(ladder, point(200), flat), 13 + 0.04 * 100);
  // The other method says nothing of it, and a knob costs what it is said to.
  EXPECT_EQ(predicted_seconds(ladder, {Method::fast, "iterations", "30", 30, false}, done), std::nullopt);
  EXPECT_EQ(predicted_seconds(ladder, {Method::construct, "method", "construct", 0, false}, done), std::nullopt);
  EXPECT_DOUBLE_EQ(*predicted_seconds(ladder, {Method::anneal, "background_features", "0", 50, false}, done), 10 * 51);
}

TEST(AccuracyBudget, IsKeptAndNoPointIsSilentlyMissing) {
  const AccuracyLadder ladder = ladder_of("stop = { iterations = 1000 }\n");
  for (const double per_iteration : {1e-5, 1e-3, 0.1, 10.0})
    for (const double budget_s : {1.0, 30.0, 600.0}) {
      std::vector<TimedPoint> done;
      const LadderStep end = climb(ladder, budget_s, per_iteration, done);
      EXPECT_EQ(done.size() + end.left_out.size(), ladder.lines.size() + ladder.knobs.size());
      for (const LeftOut& left : end.left_out) EXPECT_FALSE(left.reason.empty());
      double spent = 0;
      for (const TimedPoint& run : done) spent += run.seconds;
      // The first run of each line cannot be foreseen.
      const double unforeseen = imagined_seconds(ladder.lines.front(), per_iteration);
      EXPECT_LE(spent, std::max(budget_s * 1.5, 2 * unforeseen)) << per_iteration << " s an iteration";
    }
}

TEST(AccuracyBudget, KeepsThePlaceOfTheDefault) {
  const AccuracyLadder ladder = ladder_of("stop = { iterations = 1000 }\n");
  std::vector<TimedPoint> done;
  climb(ladder, 20, 0.01, done);  // the default takes 10 of 20 seconds; what is cheaper would use up 20
  EXPECT_TRUE(std::any_of(done.begin(), done.end(), [](const TimedPoint& run) { return run.point.is_default; }));
}

TEST(AccuracyBudget, ALongerOneGoesOnWithTheSameKnobs) {
  const AccuracyLadder ladder = ladder_of("stop = { iterations = 1000 }\n");
  std::vector<TimedPoint> done;
  climb(ladder, 30, 1e-3, done);
  const std::size_t before = done.size();
  std::set<std::int64_t> counts;
  for (const TimedPoint& run : done)
    if (run.point.setting == "cutoff") counts.insert(run.point.iterations);
  EXPECT_EQ(counts.size(), 1U);
  climb(ladder, 300, 1e-3, done);
  EXPECT_GT(done.size(), before);
  for (const TimedPoint& run : done) {
    EXPECT_TRUE(is_on_ladder(ladder, run.point)) << point_name(run.point);
    if (run.point.setting == "cutoff") {
      EXPECT_TRUE(counts.contains(run.point.iterations));
    }
  }
}

TEST(AccuracyBudget, KnobsAreNotPlacedByStartUpAlone) {
  // Start-up is all that the first runs take: doubled, it would pass the knobs' share of 0.4 s at once.
  std::vector<TimedPoint> done;
  climb(ladder_of("stop = { iterations = 1000 }\n"), 12, 1e-5, done);
  for (const TimedPoint& run : done)
    if (run.point.setting == "cutoff") {
      EXPECT_GT(run.point.iterations, 1000);
    }
}

TEST(AccuracyBudget, ADefaultThatStopsByItsScoreComesLast) {
  const AccuracyLadder ladder = ladder_of("stop = { score = 0.1 }\n");
  std::vector<TimedPoint> done;
  climb(ladder, 1000, 1e-3, done);
  EXPECT_TRUE(done.back().point.is_default);
}

TEST(AccuracyBudget, EndsTheOtherMethodsLineWhenItGetsWorseTwice) {
  const AccuracyLadder ladder = ladder_of("");
  const auto fast = [](std::int64_t n, double r) {
    return TimedPoint{{Method::fast, "iterations", std::to_string(n), n, false}, 0.01, r};
  };
  std::vector<TimedPoint> done = {fast(10, 0.5), fast(30, 0.8), fast(100, 0.9)};
  const LadderStep end = climb(ladder, 1e6, 1e-4, done);
  EXPECT_THAT(iterations_of(ladder, Method::fast), Contains(300));
  EXPECT_EQ(std::count_if(done.begin(), done.end(), [](const auto& run) { return run.point.method == Method::fast; }),
            3);
  EXPECT_THAT(end.left_out, testing::Each(testing::Field(&LeftOut::reason, HasSubstr("worse twice"))));
  EXPECT_THAT(end.left_out, Not(IsEmpty()));
}

TEST(AccuracyPrediction, CountsEveryRunOfAPoint) {
  const AccuracyLadder ladder = ladder_of("stop = { time = \"10s\" }\n", true, false, 3);
  EXPECT_DOUBLE_EQ(*predicted_seconds(ladder, ladder.default_point(), {}), 3 * 11.0);
}

TEST(AccuracyTable, FrontHoldsWhatNothingBeats) {
  EXPECT_THAT(pareto_front(some_rows()), ElementsAre(true, true, true, false, false));
  EXPECT_THAT(pareto_front({row(Method::anneal, 25, 1, 0.4), row(Method::anneal, 50, 1, 0.4)}),
              ElementsAre(true, true));
  EXPECT_THAT(pareto_front({row(Method::anneal, 25, 1, 0.4), row(Method::anneal, 50, 1, 0.3)}),
              ElementsAre(false, true));
  EXPECT_THAT(pareto_front({}), IsEmpty());
}

TEST(AccuracyTable, APointIsTheMeanOfItsRuns) {
  AccuracyRow point = row(Method::anneal, 25, 1, 0.4);
  EXPECT_EQ(error_with_spread(point), "0.4000");
  point.add({4, 0.3, 0.31, 0.32});
  point.add({1, 0.35, 0.35, std::nullopt});
  EXPECT_EQ(point.runs, 3);
  EXPECT_DOUBLE_EQ(point.seconds, 2);
  EXPECT_DOUBLE_EQ(point.relative_error, 0.35);
  EXPECT_EQ(point.least_error, 0.3);
  EXPECT_EQ(point.largest_error, 0.4);
  EXPECT_DOUBLE_EQ(*point.r_8bit, (0.404 + 0.31 + 0.35) / 3);
  EXPECT_EQ(point.r_16bit, std::nullopt);
  EXPECT_EQ(error_with_spread(point), "0.3500 (0.3000 to 0.4000)");
  EXPECT_EQ(timed({point}, 5).front().seconds, 10);
}

TEST(AccuracyTable, ReadsBackWhatItWrites) {
  std::vector<AccuracyRow> rows = some_rows();
  rows[0].add({1, 0.25, 0.26, 0.26});
  rows.push_back(row(Method::construct, 0, 0.5, 0.3));
  rows.back().point = {Method::construct, "method", "construct", 0, false};
  const std::string text = accuracy_csv(rows);
  EXPECT_THAT(text,
              testing::StartsWith("method,setting,value,iterations,seed,runs,threads,seconds,R,R_least,R_most,R_8_bit,"
                                  "R_16_bit,default,pareto,command\nanneal,iterations,25,25,7,2,2,1,0.325,0.25,0.4,"));
  EXPECT_THAT(text, HasSubstr("\"noiseloom generate \"\"my, config\"\".toml"));
  const std::vector<AccuracyRow> again = parse_accuracy_csv(text, "a.csv");
  ASSERT_EQ(again.size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(again[i].point, rows[i].point);
    EXPECT_EQ(again[i].command, rows[i].command);
    EXPECT_EQ(again[i].relative_error, rows[i].relative_error);
    EXPECT_EQ(again[i].least_error, rows[i].least_error);
    EXPECT_EQ(again[i].largest_error, rows[i].largest_error);
    EXPECT_EQ(again[i].runs, rows[i].runs);
    EXPECT_EQ(again[i].r_8bit, rows[i].r_8bit);
  }
  EXPECT_EQ(accuracy_csv(again), text);
  EXPECT_THAT(parse_accuracy_csv(accuracy_csv({}), "a.csv"), IsEmpty());
}

TEST(AccuracyTable, RefusesADamagedTableByLine) {
  const std::string text = accuracy_csv(some_rows());
  const auto fault = [](const std::string& damaged) {
    return user_error_of([&] { parse_accuracy_csv(damaged, "a.csv"); });
  };
  EXPECT_THAT(fault(""), HasSubstr("a.csv:1"));
  EXPECT_THAT(fault("a,b\n"), HasSubstr("a.csv:1"));
  EXPECT_THAT(fault(text.substr(0, text.size() - 10)), HasSubstr("a.csv:6"));
  EXPECT_THAT(fault(text + text.substr(text.find('\n') + 1)), HasSubstr("a.csv:7: the same point"));
  std::string changed = text;
  changed.replace(changed.find("0.4,"), 3, "nan");
  EXPECT_THAT(fault(changed), AllOf(HasSubstr("a.csv:2"), HasSubstr("R = \"nan\"")));
  // Cut anywhere: refused, or the rows before the cut.
  for (std::size_t end = 0; end < text.size(); ++end) {
    const bool between_lines = end > 0 && text[end - 1] == '\n';
    EXPECT_EQ(fault(text.substr(0, end)).empty(), between_lines) << end;
  }
}

TEST(AccuracyScore, StoresInBitsAsImagesDo) {
  const RunConfig config = small_config("hemisphere-cosine");
  const Texture texture = start_texture(config);
  const Texture coarse = through_bits(texture, config.problem.samples, {-1, 1}, 8);
  const Texture fine = through_bits(texture, config.problem.samples, {-1, 1}, 16);
  EXPECT_LT(largest_difference(texture, coarse), 2.0 / 256);
  EXPECT_GT(largest_difference(texture, coarse), 0.2 / 256);
  EXPECT_LT(largest_difference(texture, fine), 2.0 / 65536);
}

}  // namespace
}  // namespace noiseloom
