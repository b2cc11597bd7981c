// What accuracy costs: the ladder, what fits into a budget, the table on disk and what it says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "accuracy/accuracy_command.h"
#include "accuracy/accuracy_score.h"
#include "noiseloom/accuracy/accuracy_ladder.h"
#include "noiseloom/accuracy/accuracy_report.h"
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

RunConfig config_with(const std::string& optimizer) {
  return parse_config(
      "[texture]\nsize = { x = 11, y = 7, t = 3 }\nsamples = \"uniform\"\n[filter]\ncombine = \"product\"\n"
      "groups = [ { axes = \"xy\", kernel = \"box\", size = 3 }, { axes = \"t\", kernel = \"box\", size = 3 } ]\n"
      "[optimizer]\n" +
          optimizer,
      "test.toml", "", {});
}

AccuracyLadder ladder_of(const std::string& optimizer, bool background = true) {
  return accuracy_ladder(config_with(optimizer), {background, background ? 10.0 : 1.0});
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

const AccuracyPoint& default_of(const AccuracyLadder& ladder) {
  return *std::find_if(ladder.lines.begin(), ladder.lines.end(), [](const auto& point) { return point.is_default; });
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
  EXPECT_EQ(default_of(ladder).iterations, 1000);
  EXPECT_EQ(std::count_if(ladder.lines.begin(), ladder.lines.end(), [](const auto& p) { return p.is_default; }), 1);
  EXPECT_THAT(iterations_of(ladder_of("stop = { iterations = 200 }\n"), Method::anneal),
              ElementsAre(25, 50, 100, 200, 400, 800, 1600, 3200, 6400, 12800, 25600));
}

TEST(AccuracyLadder, ChangesEachSettingAwayFromTheConfigs) {
  const AccuracyLadder ladder = ladder_of("cutoff = 0.01\nbackground_features = 8\n");
  EXPECT_THAT(values_of(ladder, "cutoff"), ElementsAre("0", "0.001", "0.05"));
  EXPECT_THAT(values_of(ladder, "background_features"), ElementsAre("0", "4", "16", "32"));
  EXPECT_THAT(values_of(ladder, "precision"), ElementsAre("double"));
  EXPECT_THAT(values_of(ladder_of("", false), "background_features"), IsEmpty());
  EXPECT_THAT(values_of(ladder_of("precision = \"double\"\n"), "precision"), ElementsAre("float"));
  EXPECT_EQ(ladder_of("method = \"fast\"\n", false).method, Method::fast);
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

AccuracyRow row(Method method, std::int64_t n, double seconds, double r) {
  AccuracyRow result{
      {method, "iterations", std::to_string(n), n, false}, n, 7, 2, seconds, r, r * 1.01, r * 1.0001, ""};
  result.command = "noiseloom generate \"my, config\".toml --set 'optimizer.stop.iterations=" + std::to_string(n) + "'";
  return result;
}

std::vector<AccuracyRow> some_rows() {
  std::vector<AccuracyRow> rows = {row(Method::anneal, 25, 1, 0.4), row(Method::anneal, 50, 2, 0.21),
                                   row(Method::anneal, 100, 10, 0.2), row(Method::fast, 10, 3, 0.5)};
  rows[1].point = {Method::anneal, "", "", 50, true};
  rows.push_back(row(Method::anneal, 50, 4, 0.22));
  rows.back().point = {Method::anneal, "cutoff", "0.05", 50, false};
  rows.back().r_8bit.reset();
  rows.back().r_16bit.reset();
  return rows;
}

TEST(AccuracyTable, FrontHoldsWhatNothingBeats) {
  EXPECT_THAT(pareto_front(some_rows()), ElementsAre(true, true, true, false, false));
  EXPECT_THAT(pareto_front({row(Method::anneal, 25, 1, 0.4), row(Method::anneal, 50, 1, 0.4)}),
              ElementsAre(true, true));
  EXPECT_THAT(pareto_front({row(Method::anneal, 25, 1, 0.4), row(Method::anneal, 50, 1, 0.3)}),
              ElementsAre(false, true));
  EXPECT_THAT(pareto_front({}), IsEmpty());
}

TEST(AccuracyTable, ReadsBackWhatItWrites) {
  const std::vector<AccuracyRow> rows = some_rows();
  const std::string text = accuracy_csv(rows);
  EXPECT_THAT(text, testing::StartsWith("method,setting,value,iterations,seed,threads,seconds,R,R_8_bit,R_16_bit,"
                                        "default,pareto,command\nanneal,iterations,25,25,7,2,1,0.4,"));
  EXPECT_THAT(text, HasSubstr("\"noiseloom generate \"\"my, config\"\".toml"));
  const std::vector<AccuracyRow> again = parse_accuracy_csv(text, "a.csv");
  ASSERT_EQ(again.size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(again[i].point, rows[i].point);
    EXPECT_EQ(again[i].command, rows[i].command);
    EXPECT_EQ(again[i].relative_error, rows[i].relative_error);
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

TEST(AccuracySentences, SayWhatTheLastPerCentsCost) {
  const std::vector<std::string> sentences = accuracy_sentences(some_rows());
  EXPECT_THAT(sentences.front(), HasSubstr("The last 5 % of error cost 80 % of the time: R = 0.2100 is reached after "
                                           "2.00 s"));
  EXPECT_THAT(sentences, Contains(AllOf(HasSubstr("The default (anneal, 50 iterations)"), HasSubstr("4.8 % less"),
                                        HasSubstr("5 times the seconds"))));
  EXPECT_THAT(sentences, Contains(HasSubstr("Nothing that was measured is clearly both")));
  EXPECT_THAT(sentences, Contains(AllOf(HasSubstr("R = 0.5000 at best"), HasSubstr("anneal has R = 0.4000"))));
  EXPECT_THAT(sentences, Contains(HasSubstr("in 8 bits the best leaves R = 0.2020 (1 % more)")));
}

TEST(AccuracySentences, AreHonestAboutTheDefault) {
  std::vector<AccuracyRow> rows = some_rows();
  rows[1].relative_error = 0.19;  // now the best of all
  EXPECT_THAT(accuracy_sentences(rows), Contains(HasSubstr("The default (anneal, 50 iterations) is the best")));
  rows = some_rows();
  rows[1].relative_error = 0.45;
  EXPECT_THAT(accuracy_sentences(rows), Contains(HasSubstr("The default is not the best use of its time: anneal, 25")));
  rows[0].iterations = 60;  // more of the same, which a noisy clock calls shorter
  EXPECT_THAT(accuracy_sentences(rows), Contains(HasSubstr("Nothing that was measured is clearly both")));
  rows[1].point = {Method::anneal, "iterations", "50", 50, false};
  EXPECT_THAT(accuracy_sentences(rows), Contains(HasSubstr("The default did not run")));
  EXPECT_THAT(accuracy_sentences({rows[0]}), Not(IsEmpty()));
}

TEST(AccuracyPage, ShowsEveryPointAndNeedsNothingElse) {
  AccuracyStudy study{"folder/<my>.toml", config_with(""), some_rows(), {}, 60, 20, "Complete"};
  study.left_out.push_back({{Method::anneal, "precision", "double", 50, false}, "expected to take 3 h", false});
  const std::string page = accuracy_html(study);
  EXPECT_THAT(page, AllOf(HasSubstr("&lt;my&gt;.toml"), HasSubstr("<svg"), HasSubstr("Pareto front"),
                          HasSubstr("cutoff 0.05"), HasSubstr("precision double"), HasSubstr("expected to take 3 h"),
                          HasSubstr("The last 5 % of error"), HasSubstr("iterations=100")));
  EXPECT_THAT(page, AllOf(Not(HasSubstr("<script")), Not(HasSubstr("src=")), Not(HasSubstr("href=")),
                          Not(HasSubstr("url(")), Not(HasSubstr("nan"))));
  study.rows.clear();
  EXPECT_THAT(accuracy_html(study), HasSubstr("expected to take 3 h"));
}

TEST(AccuracyCommand, IsWhatAShellTakes) {
  EXPECT_EQ(shell_word("a/b_c-1.5=2"), "a/b_c-1.5=2");
  EXPECT_EQ(shell_word("filter.groups[0].size=3"), "'filter.groups[0].size=3'");
  EXPECT_EQ(shell_word("it's"), "'it'\\''s'");
  EXPECT_EQ(shell_word(""), "''");
}

TEST(AccuracyCommand, ChangesTheMethodOfAConfigWithKeysOfItsOwn) {
  const TemporaryFolder folder;
  const std::string path = folder / "c.toml";
  write_bytes(
      path,
      "[texture]\nsize = { x = 8, y = 8 }\n[filter]\ngroups = [ { axes = \"xy\", kernel = \"box\", size = 3 } ]\n"
      "[optimizer]\nbackground_features = 8\ncutoff = 0.01\nstop = { time = \"10s\" }\n");
  AccuracyOptions options;
  options.config = path;
  options.folder = "out";
  options.overrides = {"texture.seed=5"};
  const RunConfig config = load_config(path, options.overrides);
  const AccuracyLadder ladder = accuracy_ladder(config, {});
  const PointCommands commands(options, config);
  commands.check(ladder);
  const PointCommand fast = commands.command({Method::fast, "iterations", "30", 30, false});
  EXPECT_EQ(fast.shown, "noiseloom generate " + path +
                            " --set texture.seed=5 --set 'optimizer={ method = \"fast\", stop = { iterations = 30 }, "
                            "precision = \"float\", cutoff = 0.01 }' -o out/runs/fast-30.h5 --progress none");
  EXPECT_EQ(commands.command(default_of(ladder)).shown,
            "noiseloom generate " + path + " --set texture.seed=5 -o out/runs/default.h5 --progress none");
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
