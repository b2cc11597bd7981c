#include "noiseloom/render/scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "noiseloom/core/error.h"
#include "noiseloom/render/expectation.h"

namespace noiseloom::render {
namespace {

using testing::HasSubstr;

constexpr const char* plain =
    "[[noise]]\nkind = \"white\"\n[effects.integrand]\n[filter.time]\nkernels = [\"ema\"]\n[[filter.space]]\nkernel = "
    "\"box\"\nsize = 3\n";

std::string faults_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    parse_scene(text, "test.toml", "", overrides);
  } catch (const UserError& error) {
    return error.what();
  }
  return "";
}

TEST(Scene, NoisesAndFiltersAreNamedAfterWhatTheyAre) {
  const Scene scene = parse_scene(plain, "test.toml", "");
  EXPECT_EQ(scene.noises[0].name, "white");
  EXPECT_EQ(scene.space[0].name, "box3");
  std::vector<std::string> stages;
  for (const Stage& stage : stages_of(scene)) stages.push_back(stage.to_string());
  EXPECT_EQ(stages, (std::vector<std::string>{"frame", "box3", "ema", "ema + box3"}));
}

TEST(Scene, AnEffectIsOnWhereItIsWritten) {
  EXPECT_EQ(effects_of(parse_scene(plain, "test.toml", "")), std::vector{Effect::integrand});
  const Scene more = parse_scene(plain, "test.toml", "", {"effects.dither.bits=2"});
  EXPECT_EQ(effects_of(more), (std::vector{Effect::integrand, Effect::dither}));
  EXPECT_EQ(more.dither.bits, 2);
}

TEST(Scene, StoredTextReadsBackAsTheSame) {
  const Scene scene = parse_scene(std::string(plain) +
                                      "[effects.dither]\n[volume]\nseed = 3\n[[expect]]\norder = \"white = "
                                      "white\"\neffect = \"dither\"\n",
                                  "test.toml", "");
  const std::string text = to_toml(scene);
  EXPECT_EQ(to_toml(parse_scene(text, "stored.toml", "")), text);
}

TEST(Scene, AllFaultsAreToldAtOnceWithTheirLines) {
  const std::string found = faults_of(
      "[[noise]]\nkind = \"wite\"\n[[noise]]\nkind = \"ign\"\nsize = 3\n[effects.dither]\nbit = 1\n[[filter.space]]\n"
      "kernel = \"box\"\nsize = 4\n[[expect]]\norder = \"ign < fats\"\nframe = 65\n");
  EXPECT_THAT(found, HasSubstr("test.toml:2: noise[0].kind = \"wite\": unknown kind; did you mean \"white\"?"));
  EXPECT_THAT(found, HasSubstr("test.toml:5: noise[1].size"));
  EXPECT_THAT(found, HasSubstr("test.toml:7: effects.dither.bit"));
  EXPECT_THAT(found, HasSubstr("test.toml:10: filter.space[0].size = 4: must be odd"));
  EXPECT_THAT(found, HasSubstr("the scene has no noise \"fats\""));
  EXPECT_THAT(found, HasSubstr("expect[0].frame = 65: the scene has 64 frames"));
}

TEST(Scene, ExpectationsAskForWhatTheSceneHas) {
  const std::string base = plain;
  EXPECT_EQ(faults_of(base + "[[noise]]\nkind = \"ign\"\n[[expect]]\norder = \"ign = white\"\ntime = \"ema\"\nspace = "
                             "\"box3\"\n"),
            "");
  EXPECT_THAT(faults_of(base + "[[expect]]\norder = \"white <\"\n"), HasSubstr("must be names with < or ="));
  EXPECT_THAT(faults_of(base + "[[expect]]\nnoise = \"white\"\n"), HasSubstr("needs an order, or a noise with"));
  EXPECT_THAT(faults_of(base + "[[expect]]\nnoise = \"white\"\nrmse = 0.1\ntime = \"mc\"\n"),
              HasSubstr("no filter over time \"mc\""));
  EXPECT_THAT(faults_of(base + "[[expect]]\nnoise = \"white\"\nrmse = 0.1\nspace = \"box5\"\n"),
              HasSubstr("did you mean \"box3\"?"));
  EXPECT_THAT(faults_of(base + "[[expect]]\norder = \"white = white\"\n", {"image.repeats=1"}),
              HasSubstr("needs image.repeats"));
}

TEST(Scene, NamesOfNoisesAreOfFilesTooAndDiffer) {
  EXPECT_THAT(faults_of("[[noise]]\nkind = \"white\"\nname = \"../up\"\n[effects.integrand]\n"),
              HasSubstr("must be a word"));
  EXPECT_THAT(faults_of("[[noise]]\nkind = \"white\"\n[[noise]]\nkind = \"white\"\n[effects.integrand]\n"),
              HasSubstr("a second noise of the name"));
}

TEST(Scene, WithoutEffectsOrNoisesThereIsNothingToDo) {
  EXPECT_THAT(faults_of("[[noise]]\nkind = \"white\"\n[effects]\n"), HasSubstr("names no effect"));
  EXPECT_THAT(faults_of("[effects.dither]\n"), HasSubstr("noise"));
}

TEST(Expectation, OrdersAreReadAsTheyAreWritten) {
  const auto terms = parse_order("a < b = c-1");
  ASSERT_EQ(terms.size(), 3U);
  EXPECT_EQ(terms[1].noise, "b");
  EXPECT_EQ(terms[1].relation, '<');
  EXPECT_EQ(terms[2].relation, '=');
  for (const char* const wrong : {"", "a", "a <", "< a", "a < < b", "a b", "a > b"})
    EXPECT_TRUE(parse_order(wrong).empty());
}

TEST(Expectation, TwoStandardErrorsDecide) {
  EXPECT_EQ(outcome_of_less({-1, -1.1, -0.9}), Outcome::holds);
  EXPECT_EQ(outcome_of_less({1, 1.1, 0.9}), Outcome::fails);
  EXPECT_EQ(outcome_of_less({-1, 1, -0.1}), Outcome::undecided);
  EXPECT_EQ(outcome_of_less({-1}), Outcome::undecided);
  EXPECT_EQ(outcome_of_less({0, 0}), Outcome::undecided);
  EXPECT_EQ(outcome_of_equal({-1, 1, -0.1}, 0), Outcome::holds);
  EXPECT_EQ(outcome_of_equal({0, 0}, 0), Outcome::holds);
  EXPECT_EQ(outcome_of_equal({-1, -1.1, -0.9}, 0.5), Outcome::fails);
  EXPECT_EQ(outcome_of_equal({-1, -1.1, -0.9}, 1.5), Outcome::holds);
}

}  // namespace
}  // namespace noiseloom::render
