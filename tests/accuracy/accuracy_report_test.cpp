// What accuracy says of its table, in sentences and on its page.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "accuracy/ladder_support.h"
#include "noiseloom/accuracy/accuracy_report.h"

namespace noiseloom {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

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
  rows[1].relative_error = rows[1].least_error = rows[1].largest_error = 0.45;
  EXPECT_THAT(accuracy_sentences(rows), Contains(HasSubstr("The default is not the best use of its time: anneal, 25")));
  rows[1].least_error = 0.35;  // one of its seeds was as good
  EXPECT_THAT(accuracy_sentences(rows), Contains(HasSubstr("Nothing that was measured is clearly both")));
  rows[1].least_error = 0.45;
  rows[0].iterations = 60;  // more of the same, which a noisy clock calls shorter
  EXPECT_THAT(accuracy_sentences(rows), Contains(HasSubstr("Nothing that was measured is clearly both")));
  rows[1].point = {Method::anneal, "iterations", "50", 50, false};
  EXPECT_THAT(accuracy_sentences(rows), Contains(HasSubstr("The default did not run")));
  EXPECT_THAT(accuracy_sentences({rows[0]}), Not(IsEmpty()));
}

TEST(AccuracySentences, CompareAMethodWithoutIterations) {
  std::vector<AccuracyRow> rows = some_rows();
  rows.push_back(row(Method::construct, 0, 0.5, 0.3));
  EXPECT_THAT(accuracy_sentences(rows),
              Contains("construct has R = 0.3000 after 0.50 s; anneal has R = 0.2100 after 2.00 s."));
  rows.back() = row(Method::construct, 0, 0.5, 0.1);
  EXPECT_THAT(accuracy_sentences(rows),
              Contains("construct has R = 0.1000 after 0.50 s; no run of anneal comes as low."));
}

TEST(AccuracyPage, ShowsHowFarSeedsSpread) {
  AccuracyStudy study{"my.toml", config_with(""), some_rows(), {}, 60, 20, "Complete"};
  const auto uprights = [&] {
    const std::string page = accuracy_html(study);
    int count = 0;
    for (std::size_t at = 0; (at = page.find("<line class='nl-main'", at)) != std::string::npos; ++at) ++count;
    return count;
  };
  const int others = uprights();  // of the legend
  study.rows[0].add({1, 0.3, 0.3, 0.3});
  EXPECT_EQ(uprights(), others + 1);
  const std::string page = accuracy_html(study);
  EXPECT_THAT(page, AllOf(HasSubstr("anneal, 25 iterations: R 0.3500 (0.3000 to 0.4000)"), HasSubstr("2 of each point"),
                          HasSubstr("texture.seed=2")));
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

}  // namespace
}  // namespace noiseloom
