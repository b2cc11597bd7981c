// Sample spaces with parameters: what a config says of them, and what it may not say.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "config_support.h"
#include "noiseloom/samples/space.h"

namespace noiseloom {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;
using ::testing::UnorderedElementsAre;

std::string with_samples(const std::string& samples) {
  ConfigText text;
  text.size = "size = { x = 8, y = 4, t = 2 }";  // powers of two, as nets want them
  text.samples = "samples = " + samples;
  return text.text();
}

SampleSpec samples_of(const std::string& samples, const std::vector<std::string>& overrides = {}) {
  return parsed(with_samples(samples), overrides).problem.samples;
}

TEST(ConfigSamples, TakeParametersBesideTheSpace) {
  EXPECT_EQ(samples_of(R"({ space = "cone", angle = 12.5 })").space, "cone");
  EXPECT_THAT(samples_of(R"({ space = "cone", angle = 12.5 })").parameters, ElementsAre(12.5));
  EXPECT_THAT(samples_of(R"({ angle = 12, space = "cone" })").parameters, ElementsAre(12));
}

TEST(ConfigSamples, AWordStandsForTheSpaceWithItsInitialParameters) {
  for (const SampleSpace* space : sample_spaces()) {
    const std::string& name = space->traits().name;
    const SampleSpec word = samples_of('"' + name + '"');
    const SampleSpec table = samples_of("{ space = \"" + name + "\" }");
    EXPECT_EQ(word.space, name);
    EXPECT_EQ(table.space, name);
    EXPECT_EQ(word.parameters, initial_parameters(space->traits()));
    EXPECT_EQ(table.parameters, initial_parameters(space->traits()));
  }
}

// Every bound of every parameter is accepted and stored, and what lies beyond it is not.
TEST(ConfigSamples, HoldParametersWithinTheBoundsThatTheSpaceDeclares) {
  for (const SampleSpace* space : sample_spaces()) {
    const SpaceTraits& traits = space->traits();
    for (std::size_t i = 0; i < traits.parameters.size(); ++i) {
      const SpaceParameter& parameter = traits.parameters[i];
      const auto with = [&](double value) {
        const std::string text = parameter.whole ? std::to_string(static_cast<int>(value)) : std::to_string(value);
        return "{ space = \"" + traits.name + "\", " + parameter.name + " = " + text + " }";
      };
      for (const double bound : {parameter.least, parameter.most}) {
        const RunConfig config = parsed(with_samples(with(bound)));
        EXPECT_NEAR(config.problem.samples.parameters.at(i), bound, 1e-6) << traits.name;
        EXPECT_EQ(parsed(to_toml(config)).problem.samples.parameters, config.problem.samples.parameters) << traits.name;
        const double beyond = bound + (bound == parameter.least ? -1 : 1);
        EXPECT_THAT(faults_of(with_samples(with(beyond))),
                    ElementsAre(StartsWith("run.toml:3: texture.samples." + parameter.name + " = ")))
            << traits.name;
      }
    }
  }
}

TEST(ConfigSamples, AreStoredWithAllTheirParameters) {
  EXPECT_THAT(to_toml(parsed(with_samples("\"cone\""))), HasSubstr("\nsamples = { space = \"cone\", angle = 30.0 }\n"));
  EXPECT_THAT(to_toml(parsed(with_samples("{ space = \"vector2\" }"))), HasSubstr("\nsamples = \"vector2\"\n"));
}

TEST(ConfigSamples, AreOverriddenByTheKeysOfTheirParameters) {
  EXPECT_THAT(samples_of("\"cone\"", {"texture.samples.angle=7"}).parameters, ElementsAre(7));
  EXPECT_THAT(samples_of("{ space = \"cone\", angle = 12 }", {"texture.samples.angle=7"}).parameters, ElementsAre(7));
  EXPECT_EQ(samples_of("{ space = \"cone\", angle = 12 }", {"texture.samples=sphere"}).space, "sphere");
  EXPECT_EQ(samples_of("\"cone\"", {"texture.samples.space=sphere"}).space, "sphere");
}

TEST(ConfigSamples, FaultsNameTheKeyAndWhatItBelongsTo) {
  const auto fault = [](const std::string& samples) { return faults_of(with_samples(samples)); };
  EXPECT_THAT(fault("{ space = \"cone\", angel = 3 }"),
              ElementsAre("run.toml:3: texture.samples.angel: unknown key; did you mean \"angle\"? accepted: space, "
                          "distance, angle"));
  EXPECT_THAT(fault("{ space = \"coone\", angle = 3 }"),
              ElementsAre(StartsWith("run.toml:3: texture.samples.space = \"coone\": unknown space; did you mean "
                                     "\"cone\"? accepted: uniform, ")));
  EXPECT_THAT(fault("{ space = \"sphere\", angle = 3 }"),
              ElementsAre(StartsWith("run.toml:3: texture.samples.angle = 3: applies only with space = ")));
  EXPECT_THAT(fault("{ space = \"cone\", angle = \"wide\" }"),
              ElementsAre("run.toml:3: texture.samples.angle = \"wide\": must be a number, from 0.01 to 180"));
  EXPECT_THAT(fault("{ space = \"cone\", file = \"mine.npy\" }"),
              ElementsAre("run.toml:3: texture.samples.file = \"mine.npy\": applies only with space = \"file\"; here "
                          "it is \"cone\""));
  EXPECT_THAT(fault("\"file\""), ElementsAre("run.toml:3: texture.samples.file: missing; must be the name of a file"));
  EXPECT_THAT(fault("3"), ElementsAre(HasSubstr("or a table, such as { file = \"mine.npy\" }")));
}

TEST(ConfigSamples, HelpDescribesEveryParameterAndListsTheSpacesOnce) {
  const std::string help = describe_settings();
  EXPECT_THAT(help, HasSubstr("\n  texture.samples.angle\n"));
  EXPECT_THAT(help, HasSubstr("degrees; default 30.0; with space = \"cone\""));
  EXPECT_THAT(help, HasSubstr("\n  texture.samples.space\n      one of the words of texture.samples;"));
  EXPECT_THAT(help, testing::Not(HasSubstr("one of the words of texture.samples.distance"))) << "lists that differ";
  const std::string line = "\n        vector3 ";
  EXPECT_EQ(help.find(line), help.rfind(line));
  EXPECT_NE(help.find(line), std::string::npos);
}

TEST(ConfigCurve, MakesVectorsToBeConstructed) {
  ConfigText text;
  text.samples = "samples = \"vector2\"";
  text.optimizer = "curve = \"hilbert\"";
  const RunConfig config = parsed(text.text());
  EXPECT_EQ(config.problem.samples.curve, Curve::hilbert);
  EXPECT_EQ(config.optimizer.method, Method::construct);
  EXPECT_TRUE(config.optimizer.stop.is_none());
  EXPECT_THAT(to_toml(config), HasSubstr("\ncurve = \"hilbert\"\n"));
  EXPECT_EQ(to_toml(parsed(to_toml(config))), to_toml(config));
  text.optimizer = "";
  EXPECT_EQ(parsed(text.text()).optimizer.method, Method::anneal);
  EXPECT_THAT(to_toml(parsed(text.text())), Not(HasSubstr("curve")));
}

TEST(ConfigCurve, FaultsSayWhatItIsFor) {
  ConfigText text;
  text.optimizer = "curve = \"hilbert\"";
  EXPECT_THAT(
      faults_of(text.text()),
      ElementsAre("run.toml:14: optimizer.curve = \"hilbert\": is for samples vector2, vector3 and vector4; here "
                  "they are uniform"));
  text.samples = "samples = \"vector3\"";
  text.optimizer = "method = \"anneal\"\ncurve = \"hilbert\"";
  EXPECT_THAT(faults_of(text.text()),
              ElementsAre(HasSubstr("applies only with method = \"construct\", \"auto\" or \"void-and-cluster\"")));
  text.optimizer = "curve = \"hilber\"";
  EXPECT_THAT(faults_of(text.text()), ElementsAre(HasSubstr("did you mean \"hilbert\"?")));
}

TEST(ConfigCurve, DealsOutTheSamplesOfEachSliceByTheOrderOfVoidAndCluster) {
  ConfigText text;
  text.first = "{ axes = \"xy\", kernel = \"gauss-energy\" }";
  text.second = "{ axes = \"t\", kernel = \"gauss-energy\" }";
  text.combine = "combine = \"sum\"";
  text.samples = "samples = \"vector2\"";
  text.energy = "";
  text.optimizer = "method = \"void-and-cluster\"\ncurve = \"morton\"\nequalize = \"slice\"";
  const RunConfig config = parsed(text.text());
  EXPECT_EQ(config.problem.samples.curve, Curve::morton);
  EXPECT_EQ(to_toml(parsed(to_toml(config))), to_toml(config));
  text.optimizer = "method = \"void-and-cluster\"\ncurve = \"morton\"\nbits = 8";
  EXPECT_THAT(faults_of(text.text()), UnorderedElementsAre(HasSubstr("add equalize = \"slice\""),
                                                           HasSubstr("optimizer.bits = 8: is for scalars")));
  text.optimizer = "method = \"void-and-cluster\"";
  EXPECT_THAT(faults_of(text.text()), ElementsAre(HasSubstr("along a curve (optimizer.curve)")));
}

TEST(ConfigEye, IsAFilterOverTimeWithTwoNumbers) {
  ConfigText text;
  text.second = "{ axes = \"t\", kernel = \"eye\", frames_per_second = 72, pixels_per_degree = 25.5 }";
  const RunConfig config = parsed(text.text());
  EXPECT_EQ(config.problem.filter.groups[1].kernel.frames_per_second, 72);
  EXPECT_EQ(config.problem.filter.groups[1].kernel.pixels_per_degree, 25.5);
  EXPECT_EQ(to_toml(parsed(to_toml(config))), to_toml(config));
  text.second = "{ axes = \"t\", kernel = \"eye\", frames_per_second = 72 }";
  EXPECT_THAT(faults_of(text.text()), ElementsAre(HasSubstr("filter.groups[1].pixels_per_degree: missing")));
  text.first = "{ axes = \"xy\", kernel = \"eye\", frames_per_second = 72, pixels_per_degree = 20 }";
  text.second = "{ axes = \"t\", kernel = \"box\", size = 2 }";
  EXPECT_THAT(faults_of(text.text()), ElementsAre(HasSubstr("filter.groups[0].axes = \"xy\": the kernel \"eye\" is a "
                                                            "filter over time")));
}

TEST(ConfigSamples, FaultsOfImages) {
  const std::pair<std::string, std::string> cases[] = {
      {"{ image = \"sky.exr\" }", "run.toml:3: texture.samples.image = \"sky.exr\": no such file"},
      {"\"image\"", "run.toml:3: texture.samples.image: missing; must be the name of a file"},
      {"{ space = \"uniform\", onto = \"sphere\" }",
       "run.toml:3: texture.samples.onto = \"sphere\": applies only with space = \"image\"; here it is \"uniform\""},
  };
  for (const auto& [samples, message] : cases) {
    EXPECT_THAT(faults_of(with_samples(samples)), ElementsAre(message)) << samples;
  }
}

}  // namespace
}  // namespace noiseloom
