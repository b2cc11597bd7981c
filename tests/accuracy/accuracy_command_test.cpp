#include "accuracy/accuracy_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "accuracy/ladder_support.h"
#include "support/run_files.h"

namespace noiseloom {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

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
      "[optimizer]\nmethod = \"anneal\"\nbackground_features = 8\ncutoff = 0.01\nstop = { time = \"10s\" }\n");
  AccuracyOptions options;
  options.config = path;
  options.folder = "out";
  options.overrides = {"texture.seed=5"};
  const RunConfig config = load_config(path, options.overrides);
  AccuracyLadder ladder = accuracy_ladder(config, {.constructs = true});
  const PointCommands commands(options, config);
  commands.check(ladder);
  const PointCommand fast = commands.command({Method::fast, "iterations", "30", 30, false});
  EXPECT_EQ(fast.shown, "noiseloom generate " + path +
                            " --set texture.seed=5 --set 'optimizer={ method = \"fast\", stop = { iterations = 30 }, "
                            "precision = \"float\", cutoff = 0.01 }' -o out/runs/fast-30.h5 --progress none");
  EXPECT_EQ(commands.command(ladder.default_point()).shown,
            "noiseloom generate " + path + " --set texture.seed=5 -o out/runs/default.h5 --progress none");
  EXPECT_EQ(commands.command({Method::anneal, "iterations", "50", 50, false}, 2).shown,
            "noiseloom generate " + path +
                " --set texture.seed=5 --set optimizer.method=anneal --set "
                "optimizer.stop.iterations=50 --set texture.seed=7 -o out/runs/anneal-50-seed-7.h5 --progress none");
  EXPECT_THAT(commands.command({Method::construct, "method", "construct", 0, false}).shown,
              HasSubstr(" --set 'optimizer={ method = \"construct\" }' -o out/runs/construct.h5 "));
  EXPECT_THAT(commands.command({Method::construct, "iterations", "400", 400, false}).shown,
              HasSubstr(" --set 'optimizer={ method = \"construct\", stop = { iterations = 400 } }' -o "
                        "out/runs/construct-400.h5 "));
}

TEST(AccuracyCommand, LeavesTheCutoffToTheMethodWhereTheConfigDoes) {
  const TemporaryFolder folder;
  AccuracyOptions options;
  options.config = folder / "c.toml";
  options.folder = "out";
  write_bytes(
      options.config,
      "[texture]\nsize = { x = 8, y = 8 }\nsamples = \"vector2\"\n[filter]\ngroups = [ { axes = \"xy\", kernel = "
      "\"box\", size = 3 } ]\n[optimizer]\nbackground_features = 8\n");
  const PointCommands commands(options, load_config(options.config, {}));
  EXPECT_THAT(commands.command({Method::fast, "iterations", "30", 30, false}).shown,
              HasSubstr("'optimizer={ method = \"fast\", stop = { iterations = 30 }, precision = \"float\" }'"));
}

TEST(AccuracyCommand, TakesAnnealingFromAConfigThatConstructsFirst) {
  const TemporaryFolder folder;
  AccuracyOptions options;
  options.config = folder / "c.toml";
  options.folder = "out";
  write_bytes(options.config,
              "[texture]\nsize = { x = 8, y = 8 }\n[filter]\ngroups = [ { axes = \"xy\", kernel = \"box\", size = 3 } "
              "]\n[optimizer]\ndensity = 0.1\nsharpness = 1.25\nstop = { time = \"10s\" }\n");
  const RunConfig config = load_config(options.config, {});
  AccuracyLadder ladder = accuracy_ladder(config, {.constructs = true});
  const PointCommands commands(options, config);
  commands.check(ladder);
  EXPECT_THAT(commands.command({Method::construct, "method", "construct", 0, false}).shown,
              HasSubstr("'optimizer={ method = \"construct\", density = 0.1, sharpness = 1.25 }'"));
  EXPECT_THAT(commands.command({Method::construct, "iterations", "100", 100, false}).shown,
              HasSubstr(" --set optimizer.method=construct --set optimizer.stop.iterations=100 -o "));
}

TEST(AccuracyCommand, LeavesOutMethodsThatTheConfigCannotHave) {
  const TemporaryFolder folder;
  AccuracyOptions options;
  options.config = folder / "c.toml";
  options.folder = "out";
  const auto checked = [&](const std::string& text) {
    write_bytes(options.config, text);
    const RunConfig config = load_config(options.config, {});
    AccuracyLadder ladder = accuracy_ladder(config, {.constructs = true});
    PointCommands(options, config).check(ladder);
    return ladder;
  };
  const std::string plane =
      "[texture]\nsize = { x = 8, y = 8 }\n[filter]\ngroups = [ { axes = \"xy\", kernel = \"box\", size = 3 } ]\n";
  EXPECT_THAT(checked(plane).incomparable, IsEmpty());
  EXPECT_THAT(checked(order_config).incomparable, IsEmpty());
  const AccuracyLadder stbn = checked(plane + "[energy]\nvalue_kernel = \"stbn\"\n");
  EXPECT_THAT(names_of(stbn.lines), AllOf(Contains("anneal-25"), Not(Contains("construct"))));
  ASSERT_EQ(stbn.incomparable.size(), 1U);
  EXPECT_THAT(stbn.incomparable.front().reason, HasSubstr("energy.value_kernel"));
}

}  // namespace
}  // namespace noiseloom
