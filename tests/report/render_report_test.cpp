#include "noiseloom/report/render_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/wipe.h"

namespace noiseloom {
namespace {

using testing::HasSubstr;

// Three noises with errors 0.1, 0.2 and 0.3 in both repeats, of one stage and one frame.
render::Result three_noises() {
  render::Result result;
  result.effects = {render::Effect::dither};
  result.noises = {"white", "blue", "fast"};
  result.white = 0;
  result.stages = {{"frame", "none"}};
  result.frames = 1;
  result.repeats = 2;
  for (const double error : {0.3, 0.2, 0.1}) result.squares.insert(result.squares.end(), 2, error * error);
  result.bias = {0};
  return result;
}

TEST(RenderReport, SaysHowManySamplesEachNoiseNeeds) {
  EXPECT_THAT(
      sample_sentence(three_noises(), 0, 0),
      HasSubstr("fast has the least error, 0.100; at the same error it needs 9.0 times fewer samples than white "
                "and 4.0 times fewer samples than blue."));
}

TEST(RenderReport, ManyTimesAreTwoDigits) {
  render::Result result = three_noises();
  result.squares = {9.0, 9.0, 0.04, 0.04, 0.0003, 0.0003};
  EXPECT_THAT(sample_sentence(result, 0, 0),
              HasSubstr("30000 times fewer samples than white and 130 times fewer samples than blue."));
}

TEST(RenderReport, ANoiseAloneIsComparedWithNone) {
  render::Result result = three_noises();
  result.noises = {"white"};
  result.white = 0;
  result.squares.resize(2);
  EXPECT_THAT(sample_sentence(result, 0, 0), testing::EndsWith("white has the least error, 0.300."));
  result.squares = {0, 0};
  EXPECT_THAT(sample_sentence(result, 0, 0), testing::Not(HasSubstr("inf")));
}

// Each picture is in the page once, and either side can show any of them.
TEST(Wipe, ShowsAnyTwoPictures) {
  const std::string html = wipe_html("one", 20, 10, {{"truth", "data:a"}, {"<b>", "data:b"}, {"c", "data:c"}});
  for (const char* const source : {"data:a", "data:b", "data:c"})
    EXPECT_EQ(html.find(source), html.rfind(source)) << source;
  EXPECT_THAT(html, HasSubstr("name='one-left' class='left0' checked> truth"));
  EXPECT_THAT(html, HasSubstr("name='one-right' class='right2' checked> c"));
  EXPECT_THAT(html, HasSubstr("#one:has(.right1:checked) { --right: var(--p1); }"));
  EXPECT_THAT(html, HasSubstr("&lt;b&gt;"));
  EXPECT_THAT(html, testing::Not(HasSubstr("<script")));
}

}  // namespace
}  // namespace noiseloom
