// What the groups of a filter may hold, how two configs differ, and what the help says of all settings.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "config/config_support.h"

namespace noiseloom {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(ConfigFilter, BoxesLieAlongSliceAxesOfTheirGroup) {
  const auto with = [](const std::string& keys) {
    return "{ axes = \"xy\", kernel = \"gauss-energy\", " + keys + " }";
  };
  const std::string group = "run.toml:8: filter.groups[0].";
  const std::pair<std::string, std::string> cases[] = {
      {with("box = \"t\""), group + "box_size: missing; how many slices in a row act as one"},
      {with("box_size = 4"), group + "box: missing; box_size says how many slices in a row act as one along it"},
      {with("box = \"t\", box_size = 4"), group + "box = \"t\": axis \"t\" is none of the group's"},
      {with("box = \"x\", box_size = 4"), group + "box = \"x\": axis \"x\" is no slice axis"},
  };
  for (const auto& [first, message] : cases) {
    ConfigText config;
    config.first = first;
    EXPECT_THAT(faults_of(config.text()), ElementsAre(message)) << first;
  }
}

TEST(ConfigFilter, TilesAndTailsAreOfOrdersAlone) {
  const std::string group = "run.toml:8: filter.groups[0].";
  const auto of_order = [](const std::string& axes, const std::string& keys) {
    ConfigText config;
    config.combine = "combine = \"sum\"";
    config.first = "{ axes = \"" + axes + "\", kernel = \"gauss-energy\", " + keys + " }";
    config.second = "{ axes = \"t\", kernel = \"gauss-energy\" }";
    config.energy = "";
    config.optimizer = "method = \"void-and-cluster\"";
    return faults_of(config.text());
  };
  EXPECT_THAT(of_order("xyt", "tiles = \"t\", tail = 0.01, tail_power = 2"), IsEmpty());
  EXPECT_THAT(of_order("xy", "tiles = \"t\""), ElementsAre(group + "tiles = \"t\": axis \"t\" is none of the group's"));
  EXPECT_THAT(of_order("xyt", "tiles = \"y\""), ElementsAre(group + "tiles = \"y\": axis \"y\" is no slice axis"));
  EXPECT_THAT(of_order("xt", "tiles = \"t\""),
              ElementsAre(group + "tiles = \"t\": the group must have x and y, whose edges the tiles share"));
  EXPECT_THAT(of_order("xyt", "tiles = \"t\", box = \"t\", box_size = 2"),
              ElementsAre(group + "tiles = \"t\": axis \"t\" is in box already"));
  EXPECT_THAT(of_order("xyt", "tail_power = 2"),
              ElementsAre(group + "tail_power = 2: is of a tail, but there is no tail"));
  EXPECT_THAT(of_order("xyt", "tail = 2"), ElementsAre(HasSubstr("filter.groups[0].tail = 2")));
  ConfigText annealed;
  annealed.first = "{ axes = \"xy\", kernel = \"gauss-energy\", tail = 0.1 }";
  EXPECT_THAT(faults_of(annealed.text()),
              ElementsAre(group + "tail = 0.1: is for method = \"void-and-cluster\" alone"));
}

TEST(ConfigDifferences, NameEachKeyWithBothValues) {
  const std::string stored = to_toml(parsed(ConfigText{}.text()));
  const auto differences = [&](const std::vector<std::string>& overrides) {
    return config_differences(stored, to_toml(parsed(ConfigText{}.text(), overrides)));
  };
  EXPECT_THAT(differences({}), IsEmpty());
  EXPECT_THAT(differences({"texture.seed=2", "texture.size.t=11", "filter.groups[0].size=5"}),
              ElementsAre("texture.size.t: 3 in the file, 11 here", "texture.seed: 1 in the file, 2 here",
                          "filter.groups[0].size: 3 in the file, 5 here"));
  EXPECT_THAT(differences({"optimizer.stop.time=10s"}),
              ElementsAre("optimizer.stop.iterations: 11 in the file, not here",
                          "optimizer.stop.time: not in the file, \"10s\" here"));
  EXPECT_THAT(differences({"filter.groups[1].axes=['t']", "optimizer.sieve_features=16"}), IsEmpty());
  EXPECT_THAT(differences({"optimizer.cutoff=0"}), ElementsAre("optimizer.cutoff: not in the file, 0.0 here"));
  EXPECT_THAT(
      differences({"filter.groups=[{ axes = 'xy', kernel = 'box', size = 3 }]"}),
      ElementsAre("filter.groups[1]: { axes = \"t\", kernel = \"ema\", alpha = 0.1, rejection = 0.0 } in the file, not "
                  "here"));
}

TEST(ConfigDifferences, SeeTheOrderOfSliceAxes) {
  ConfigText a;
  ConfigText b;
  a.size = "size = { x = 7, y = 5, t = 3, z = 3 }";
  b.size = "size = { x = 7, y = 5, z = 3, t = 3 }";
  EXPECT_THAT(
      config_differences(to_toml(parsed(a.text())), to_toml(parsed(b.text()))),
      ElementsAre("texture.size: { x = 7, y = 5, t = 3, z = 3 } in the file, { x = 7, y = 5, z = 3, t = 3 } here"));
}

TEST(DescribeSettings, NamesEveryKeyThatAConfigCanHold) {
  const std::string text = describe_settings();
  for (const char* key : {"texture.size",
                          "texture.samples",
                          "texture.samples.file",
                          "texture.samples.distance",
                          "texture.seed",
                          "filter.combine",
                          "filter.groups[].axes",
                          "filter.groups[].kernel",
                          "filter.groups[].size",
                          "filter.groups[].sigma",
                          "filter.groups[].n",
                          "filter.groups[].alpha",
                          "filter.groups[].rejection",
                          "filter.groups[].file",
                          "filter.groups[].weight",
                          "energy.value_kernel",
                          "energy.sigma_s",
                          "optimizer.method",
                          "optimizer.stop.iterations",
                          "optimizer.start.file",
                          "optimizer.start.pattern",
                          "optimizer.stop.time",
                          "optimizer.stop.score",
                          "optimizer.stop.improvement",
                          "optimizer.precision",
                          "optimizer.cutoff",
                          "optimizer.background_features",
                          "optimizer.sieve_features",
                          "optimizer.temperature.start",
                          "optimizer.temperature.end",
                          "optimizer.fraction",
                          "optimizer.grow_fraction",
                          "optimizer.density",
                          "optimizer.sharpness",
                          "optimizer.bounded",
                          "optimizer.bits",
                          "optimizer.equalize"}) {
    EXPECT_THAT(text, HasSubstr("\n  " + std::string(key) + "\n")) << key;
  }
  EXPECT_THAT(text, HasSubstr("default 1.9; with kernel = \"gauss-energy\""));
  EXPECT_THAT(text, HasSubstr("default 0.125; with method = \"fast\""));
  EXPECT_THAT(text, HasSubstr("default 0.03; with method = \"construct\""));
  EXPECT_THAT(text, HasSubstr("default \"distance\"; with method = \"anneal\", \"fast\" or \"auto\""));
}

}  // namespace
}  // namespace noiseloom
