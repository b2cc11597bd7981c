// The settings of void and cluster, and what it asks of the others.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/config_support.h"

namespace noiseloom {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

// Two groups over x, y and t; a test replaces single parts. There is no [energy].
struct MaskText {
  std::string size = "size = { x = 7, y = 5, t = 3 }";                            // line 2
  std::string samples = "samples = \"uniform\"";                                  // line 3
  std::string combine = "combine = \"sum\"";                                      // line 5
  std::string first = "{ axes = \"xy\", kernel = \"gauss-energy\" }";             // line 7
  std::string second = "{ axes = \"t\", kernel = \"gauss-energy\", sigma = 1 }";  // line 8
  std::string optimizer;                                                          // line 12
  std::string energy;                                                             // after it

  std::string text() const {
    return "[texture]\n" + size + '\n' + samples + "\n[filter]\n" + combine + "\ngroups = [\n" + first + ",\n" +
           second + ",\n]\n[optimizer]\nmethod = \"void-and-cluster\"\n" + optimizer + '\n' + energy + '\n';
  }
};

std::vector<std::string> faults_with(std::string MaskText::*part, const std::string& written) {
  MaskText config;
  config.*part = written;
  return faults_of(config.text());
}

TEST(VoidAndClusterConfig, BecomesTheProblemOfTheAlgorithm) {
  MaskText text;
  text.size = "size = { x = 7, y = 5, view = 2, t = 3 }";
  text.second = "{ axes = [\"t\", \"view\"], kernel = \"gauss-energy\", sigma = 0.5 }";
  text.optimizer = "density = 0.25\nbounded = [\"view\", \"y\"]\nbits = 8\nequalize = \"slice\"";
  const RunConfig config = parsed(text.text(), {"texture.seed=9"});
  EXPECT_EQ(config.optimizer.method, Method::void_and_cluster);
  EXPECT_EQ(config.order.bits, 8);
  EXPECT_EQ(config.order.equalize, Equalize::slice);
  const VacSpec spec = vac_spec(config);
  EXPECT_EQ(spec.extents, Extents({7, 5, 2, 3}, {"x", "y", "view", "t"}));
  ASSERT_EQ(spec.groups.size(), 2U);
  EXPECT_THAT(spec.groups[0].axes, ElementsAre(0, 1));
  EXPECT_EQ(spec.groups[0].sigma_px, 1.9);
  EXPECT_THAT(spec.groups[1].axes, ElementsAre(3, 2));
  EXPECT_EQ(spec.groups[1].sigma_px, 0.5);
  EXPECT_THAT(spec.toroidal, ElementsAre(true, false, false, true));
  EXPECT_EQ(spec.density, 0.25);
  EXPECT_EQ(spec.seed, 9U);
}

TEST(VoidAndClusterConfig, HasNoInitialPatternUnlessAskedFor) {
  const RunConfig config = parsed(MaskText{}.text());
  const VacSpec spec = vac_spec(config);
  EXPECT_EQ(spec.density, 0);
  EXPECT_THAT(spec.toroidal, IsEmpty());
  EXPECT_EQ(config.order.bits, 0);
  EXPECT_EQ(config.order.equalize, Equalize::volume);
  EXPECT_THAT(parsed(MaskText{}.text(), {"optimizer.bounded=''"}).order.bounded, IsEmpty());
}

TEST(VoidAndClusterConfig, TextHasWhatAppliesAndRoundTrips) {
  MaskText text;
  text.optimizer = "density = 0.0\nbounded = \"ty\"\nbits = 16\nequalize = \"slice\"";
  const std::string effective = to_toml(parsed(text.text()));
  EXPECT_EQ(effective, R"([texture]
size = { x = 7, y = 5, t = 3 }
samples = "uniform"
seed = 1

[filter]
combine = "sum"
groups = [
  { axes = "xy", kernel = "gauss-energy", sigma = 1.9, weight = 0.5 },
  { axes = "t", kernel = "gauss-energy", sigma = 1.0, weight = 0.5 },
]

[optimizer]
method = "void-and-cluster"
density = 0.0
bounded = "ty"
bits = 16
equalize = "slice"
)");
  const RunConfig again = parsed(effective);
  EXPECT_EQ(to_toml(again), effective);
  EXPECT_THAT(again.order.bounded, ElementsAre(2, 1));
  EXPECT_EQ(again.order.density, 0.0);
  EXPECT_THAT(to_toml(parsed(MaskText{}.text())), HasSubstr("bounded = \"\"\nbits = 0\nequalize = \"volume\"\n"));
}

TEST(VoidAndClusterConfig, OneGroupNeedsNoCombine) {
  EXPECT_THAT(faults_of("[texture]\nsize = { x = 4, y = 4 }\n[filter]\ngroups = [ { axes = \"xy\", kernel = "
                        "\"gauss-energy\" } ]\n[optimizer]\nmethod = \"void-and-cluster\"\n"),
              IsEmpty());
  EXPECT_THAT(faults_with(&MaskText::combine, ""),
              ElementsAre("run.toml:6: filter.combine: missing; with method = \"void-and-cluster\" several groups need "
                          "combine = \"sum\""));
  EXPECT_THAT(faults_with(&MaskText::combine, "combine = \"product\""),
              ElementsAre("run.toml:5: filter.combine = \"product\": with method = \"void-and-cluster\" several groups "
                          "need combine = \"sum\""));
}

TEST(VoidAndClusterConfig, RefusesWhatDoesNotApplyAtItsLine) {
  const std::string swaps =
      ": applies only with method = \"anneal\", \"fast\", \"construct\" or \"auto\"; here it is \"void-and-cluster\"";
  EXPECT_THAT(faults_with(&MaskText::optimizer, "stop = { iterations = 11 }"),
              ElementsAre("run.toml:12: optimizer.stop = { iterations = 11 }" + swaps));
  EXPECT_THAT(faults_with(&MaskText::optimizer, "precision = \"double\""),
              ElementsAre("run.toml:12: optimizer.precision = \"double\"" + swaps));
  EXPECT_THAT(faults_with(&MaskText::optimizer, "cutoff = 0.1"),
              ElementsAre("run.toml:12: optimizer.cutoff = 0.1" + swaps));
  const std::string anneal =
      ": applies only with method = \"anneal\", \"construct\" or \"auto\"; here it is \"void-and-cluster\"";
  EXPECT_THAT(faults_with(&MaskText::optimizer, "temperature = { start = 1 }"),
              ElementsAre("run.toml:12: optimizer.temperature = { start = 1 }" + anneal));
  EXPECT_THAT(faults_with(&MaskText::optimizer, "background_features = 3"),
              ElementsAre("run.toml:12: optimizer.background_features = 3" + anneal));
  EXPECT_THAT(faults_with(&MaskText::optimizer, "fraction = 0.5"), ElementsAre(HasSubstr("with method = \"fast\"")));
  EXPECT_THAT(
      faults_with(&MaskText::energy, "[energy]\nvalue_kernel = \"stbn\"\nsigma_s = 2"),
      ElementsAre("run.toml:14: energy.value_kernel = \"stbn\": applies only with method = \"anneal\", \"fast\" or "
                  "\"auto\"; here it is \"void-and-cluster\""));
  const std::string with = "with method = \"void-and-cluster\" ";
  EXPECT_THAT(faults_with(&MaskText::samples, "samples = \"vector2\""),
              ElementsAre("run.toml:3: texture.samples = \"vector2\": " + with +
                          "they must be \"uniform\", as the order of the pixels makes the values; or vector2, vector3 "
                          "or vector4 along a curve (optimizer.curve)"));
  EXPECT_THAT(faults_with(&MaskText::first, "{ axes = \"xy\", kernel = \"box\", size = 3 }"),
              ElementsAre("run.toml:7: filter.groups[0].kernel = \"box\": " + with + "it must be \"gauss-energy\""));
  EXPECT_THAT(faults_with(&MaskText::second, "{ axes = \"t\", kernel = \"gauss-energy\", sigma = 1001 }"),
              ElementsAre("run.toml:8: filter.groups[1].sigma = 1001: " + with + "must be at most 1000"));
}

TEST(VoidAndClusterConfig, WeighsGroupsOverTheHeaviest) {
  MaskText text;
  const auto weights_of = [&](const std::string& first, const std::string& second) {
    text.first = "{ axes = \"xy\", kernel = \"gauss-energy\", weight = " + first + " }";
    text.second = "{ axes = \"t\", kernel = \"gauss-energy\", weight = " + second + " }";
    const VacSpec spec = vac_spec(parsed(text.text()));
    return std::vector<double>{spec.groups[0].weight, spec.groups[1].weight};
  };
  EXPECT_THAT(weights_of("0.25", "0.75"), ElementsAre(0.25 / 0.75, 1));
  EXPECT_THAT(weights_of("0.5", "0.5"), ElementsAre(1, 1));
  EXPECT_THAT(weights_of("0.5000004", "0.4999996"), ElementsAre(1, 1));  // as equal as thirds can be written
}

TEST(VoidAndClusterConfig, NamesValuesOutOfRange) {
  EXPECT_THAT(faults_with(&MaskText::optimizer, "density = 0.51"),
              ElementsAre("run.toml:12: optimizer.density = 0.51: must be from 0 to 0.5"));
  EXPECT_THAT(faults_with(&MaskText::optimizer, "bits = 17"),
              ElementsAre("run.toml:12: optimizer.bits = 17: must be from 0 to 16"));
  EXPECT_THAT(faults_with(&MaskText::optimizer, "bits = 8.0"),
              ElementsAre("run.toml:12: optimizer.bits = 8.0: must be an integer, from 0 to 16"));
  EXPECT_THAT(faults_with(&MaskText::optimizer, "equalize = \"frame\""),
              ElementsAre("run.toml:12: optimizer.equalize = \"frame\": unknown equalize; did you mean \"slice\"? "
                          "accepted: volume, slice"));
  EXPECT_THAT(faults_with(&MaskText::optimizer, "bounded = \"z\""),
              ElementsAre("run.toml:12: optimizer.bounded = \"z\": no axis \"z\"; the texture has x, y, t"));
  EXPECT_THAT(faults_with(&MaskText::optimizer, "bounded = \"tt\""),
              ElementsAre("run.toml:12: optimizer.bounded = \"tt\": axis \"t\" is named twice"));
  EXPECT_THAT(faults_with(&MaskText::optimizer, "bounded = true"),
              ElementsAre(StartsWith("run.toml:12: optimizer.bounded = true: must be the names of axes")));
  EXPECT_THAT(faults_with(&MaskText::optimizer, "desnity = 0.1"),
              ElementsAre("run.toml:12: optimizer.desnity: unknown key; did you mean \"density\"? accepted: method, "
                          "density, curve, bounded, bits, equalize"));
}

TEST(VoidAndClusterConfig, FaultsComeTogether) {
  MaskText text;
  text.samples = "samples = \"sphere\"";
  text.combine = "combine = \"product\"";
  text.second = "{ axes = \"t\", kernel = \"ema\", alpha = 0.1 }";
  text.optimizer = "cutoff = 0.1\ndensity = 7";
  EXPECT_THAT(faults_of(text.text()),
              ElementsAre(StartsWith("run.toml:3: texture.samples"), StartsWith("run.toml:5: filter.combine"),
                          StartsWith("run.toml:8: filter.groups[1].kernel"),
                          StartsWith("run.toml:12: optimizer.cutoff"), StartsWith("run.toml:13: optimizer.density")));
}

TEST(VoidAndClusterConfig, AnUnknownWordIsReportedOnce) {
  EXPECT_THAT(faults_with(&MaskText::first, "{ axes = \"xy\", kernel = \"boxx\" }"),
              ElementsAre(HasSubstr("unknown kernel")));
  EXPECT_THAT(faults_with(&MaskText::samples, "samples = \"spheer\""), ElementsAre(HasSubstr("unknown samples")));
  EXPECT_THAT(faults_of(MaskText{}.text(), {"optimizer.method=void-cluster", "energy.value_kernel=stbn"}),
              ElementsAre(AllOf(StartsWith("--set optimizer.method=void-cluster"),
                                HasSubstr("did you mean \"void-and-cluster\"?"))));
}

TEST(VoidAndClusterConfig, SettingsOfItBelongToNoOtherMethod) {
  for (const std::string line : {"bounded = \"t\"", "bits = 8", "equalize = \"slice\""}) {
    ConfigText config;
    config.optimizer = line;
    EXPECT_THAT(faults_of(config.text()),
                ElementsAre(AllOf(StartsWith("run.toml:14: optimizer." + line),
                                  HasSubstr("applies only with method = \"void-and-cluster\""),
                                  EndsWith("here it is \"auto\""))));
  }
  ConfigText annealed;
  annealed.optimizer = "density = 0.1\nmethod = \"anneal\"";
  EXPECT_THAT(
      faults_of(annealed.text()),
      ElementsAre(AllOf(StartsWith("run.toml:14: optimizer.density = 0.1"),
                        HasSubstr("applies only with method = \"void-and-cluster\" or \"construct\" or \"auto\""),
                        EndsWith("here it is \"anneal\""))));
  annealed.optimizer = "method = \"anneal\"";
  EXPECT_THAT(to_toml(parsed(annealed.text())), Not(HasSubstr("density")));
}

}  // namespace
}  // namespace noiseloom
