// Each kind of bad input ends in the message that names the place, what was found and what is accepted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "config/config_support.h"

namespace noiseloom {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

constexpr const char* kernels = "accepted: box, gauss, binomial, ema, table, gauss-energy, eye";

struct Case {
  std::string ConfigText::*part;
  std::string written;
  std::string message;
};

// Every case alone, so that no message depends on another fault.
void expect_messages(const std::vector<Case>& cases) {
  for (const Case& item : cases) {
    ConfigText config;
    config.*item.part = item.written;
    EXPECT_THAT(faults_of(config.text()), ElementsAre(item.message)) << item.written;
  }
}

TEST(ConfigFaults, SoundConfigHasNone) { EXPECT_THAT(faults_of(ConfigText{}.text()), IsEmpty()); }

TEST(ConfigFaults, NameUnknownKeysAtEveryLevel) {
  expect_messages({
      {&ConfigText::seed, "sead = 1",
       "run.toml:4: texture.sead: unknown key; did you mean \"seed\"? accepted: size, samples, seed, stratify"},
      {&ConfigText::energy, "[energi]",
       "run.toml:12: energi: unknown key; did you mean \"energy\"? accepted: texture, filter, energy, optimizer"},
      {&ConfigText::second, "{ axes = \"t\", kernel = \"ema\", alpha = 1, regection = 0 }",
       "run.toml:9: filter.groups[1].regection: unknown key; did you mean \"rejection\"? accepted: axes, kernel, "
       "alpha, "
       "rejection"},
      {&ConfigText::optimizer, "stop = { iteration = 5 }",
       "run.toml:14: optimizer.stop.iteration: unknown key; did you mean \"iterations\"? accepted: iterations, time, "
       "score, improvement"},
      {&ConfigText::optimizer, "quux = 5",
       "run.toml:14: optimizer.quux: unknown key; accepted: method, stop, start, precision, cutoff, "
       "background_features, sieve_features, temperature, density, sharpness, curve"},
      {&ConfigText::optimizer, "quux = 5\nmethod = \"anneal\"",
       "run.toml:14: optimizer.quux: unknown key; accepted: method, stop, start, precision, cutoff, "
       "background_features, sieve_features, temperature"},
  });
}

TEST(ConfigFaults, SuggestWhatPeopleCallItElsewhere) {
  const auto kernel = [](const std::string& word) { return "{ axes = \"t\", kernel = \"" + word + "\" }"; };
  const auto message = [](const std::string& word, const std::string& meant) {
    return "run.toml:9: filter.groups[1].kernel = \"" + word + "\": unknown kernel; did you mean \"" + meant + "\"? " +
           kernels;
  };
  for (const auto& [word, meant] : std::vector<std::pair<std::string, std::string>>{{"expontial", "ema"},
                                                                                    {"exponential", "ema"},
                                                                                    {"Gaussian", "gauss"},
                                                                                    {"bluenoise", "gauss-energy"},
                                                                                    {"gauss_energy", "gauss-energy"},
                                                                                    {"BOX", "box"}}) {
    expect_messages({{&ConfigText::second, kernel(word), message(word, meant)}});
  }
  for (const auto& [word, meant] :
       std::vector<std::pair<std::string, std::string>>{{"cosine", "hemisphere-cosine"},
                                                        {"vec2", "vector2"},
                                                        {"real", "uniform"},
                                                        {"hemisphere_cosine", "hemisphere-cosine"}}) {
    ConfigText config;
    config.samples = "samples = \"" + word + '"';
    EXPECT_THAT(
        faults_of(config.text()),
        ElementsAre(AllOf(StartsWith("run.toml:3: texture.samples = \"" + word +
                                     "\": unknown samples; did you mean \"" + meant + "\"? accepted: uniform, "),
                          HasSubstr("vector8"))));
  }
}

TEST(ConfigFaults, NameWrongTypes) {
  expect_messages({
      {&ConfigText::seed, "seed = \"one\"", "run.toml:4: texture.seed = \"one\": must be an integer, at least 0"},
      {&ConfigText::seed, "seed = 1.5", "run.toml:4: texture.seed = 1.5: must be an integer, at least 0"},
      {&ConfigText::size, "size = 128",
       "run.toml:2: texture.size = 128: must be a table such as { x = 128, y = 128, t = 32 }"},
      {&ConfigText::size, "size = { x = 7, y = \"5\", t = 3 }",
       "run.toml:2: texture.size.y = \"5\": must be an integer, at least 1"},
      {&ConfigText::combine, "combine = true", "run.toml:6: filter.combine = true: must be one of product, sum"},
      {&ConfigText::second, "3", "run.toml:9: filter.groups[1] = 3: must be a table"},
      {&ConfigText::energy, "value_kernel = 2020-02-29",
       "run.toml:12: energy.value_kernel = 2020-02-29: must be one of distance, stbn"},
      {&ConfigText::optimizer, "stop = \"10s\"", "run.toml:14: optimizer.stop = \"10s\": must be a table"},
      {&ConfigText::optimizer, "stop = { time = \"10 parsecs\" }",
       "run.toml:14: optimizer.stop.time = \"10 parsecs\": must be a duration greater than 0: \"10s\", \"5m\", "
       "\"1h30m\", or a number of seconds"},
      {&ConfigText::optimizer, "method = \"fast\"\ngrow_fraction = 1",
       "run.toml:15: optimizer.grow_fraction = 1: must be true or false"},
  });
}

TEST(ConfigFaults, NameValuesOutOfRange) {
  const std::string sigma = "run.toml:8: filter.groups[0].sigma = ";
  expect_messages({
      {&ConfigText::size, "size = { x = 7, y = 5, t = 0 }", "run.toml:2: texture.size.t = 0: must be at least 1"},
      {&ConfigText::size, "size = { x = 7, y = 5, t = 4294967296 }",
       "run.toml:2: texture.size.t = 4294967296: must be at most 2147483647"},
      {&ConfigText::seed, "seed = -1", "run.toml:4: texture.seed = -1: must be at least 0"},
      {&ConfigText::first, "{ axes = \"xy\", kernel = \"box\", size = 0 }",
       "run.toml:8: filter.groups[0].size = 0: must be from 1 to 65536"},
      {&ConfigText::first, "{ axes = \"xy\", kernel = \"gauss\", sigma = -1.5 }",
       sigma + "-1.5: must be from 0.001 to 65536"},
      {&ConfigText::first, "{ axes = \"xy\", kernel = \"gauss\", sigma = nan }", sigma + "nan: must be finite"},
      {&ConfigText::first, "{ axes = \"xy\", kernel = \"gauss\", sigma = inf }", sigma + "inf: must be finite"},
      {&ConfigText::second, "{ axes = \"t\", kernel = \"ema\", alpha = 0 }",
       "run.toml:9: filter.groups[1].alpha = 0: must be greater than 0 and at most 1"},
      {&ConfigText::second, "{ axes = \"t\", kernel = \"ema\", alpha = 1, rejection = 1.25 }",
       "run.toml:9: filter.groups[1].rejection = 1.25: must be from 0 to 1"},
      {&ConfigText::optimizer, "stop = { iterations = 0 }",
       "run.toml:14: optimizer.stop.iterations = 0: must be from 1 to 1000000000"},
      {&ConfigText::optimizer, "stop = { time = \"0s\" }",
       "run.toml:14: optimizer.stop.time = \"0s\": must be greater than 0"},
      {&ConfigText::optimizer, "temperature = { start = 0.5, end = 2.5 }",
       "run.toml:14: optimizer.temperature = { start = 0.5, end = 2.5 }: end must not be above start"},
  });
}

TEST(ConfigFaults, NameTexturesThatNoIndexCanCount) {
  expect_messages({
      {&ConfigText::size, "size = { x = 65536, y = 65536, t = 1 }",
       "run.toml:2: texture.size = { x = 65536, y = 65536, t = 1 }: 4294967296 pixels in a slice; at most 4294967295"},
      {&ConfigText::size, "size = { x = 1, y = 1, t = 65536, z = 65536 }",
       "run.toml:2: texture.size = { x = 1, y = 1, t = 65536, z = 65536 }: 4294967296 slices; at most 2147483647"},
      {&ConfigText::size, "size = { x = 16384, y = 32768, t = 1048576 }",
       "run.toml:2: texture.size = { x = 16384, y = 32768, t = 1048576 }: 562949953421312 pixels; at most "
       "281474976710656"},
      {&ConfigText::size, "size = { x = 2, y = 2, t = 1, a = 1, b = 1, c = 1, d = 1, e = 1, f = 1 }",
       "run.toml:2: texture.size = { x = 2, y = 2, t = 1, a = 1, b = 1, c = 1, d = 1, e = 1 ...: 9 axes; at most 8, x "
       "and y "
       "included"},
  });
}

TEST(ConfigFaults, NameMissingKeys) {
  EXPECT_THAT(faults_of(""), ElementsAre("run.toml: texture: missing; a config needs the table [texture]",
                                         "run.toml: filter: missing; a config needs the table [filter]"));
  expect_messages({
      {&ConfigText::size, "size = { x = 7, t = 3 }", "run.toml:2: texture.size.y: missing"},
      {&ConfigText::size, "size = { x = 7, Y = 5, t = 3 }",
       "run.toml:2: texture.size.y: missing; did you mean it by Y?"},
      {&ConfigText::first, "{ axes = \"xy\", kernel = \"box\" }",
       "run.toml:8: filter.groups[0].size: missing; must be an integer, from 1 to 65536"},
      {&ConfigText::second, "{ axes = \"t\" }",
       std::string("run.toml:9: filter.groups[1].kernel: missing; must be one of ") + (kernels + sizeof("accepted:"))},
      {&ConfigText::samples, "samples = { distance = \"angle\" }",
       "run.toml:3: texture.samples.file: missing; must be the name of a file"},
  });
}

TEST(ConfigFaults, NameKeysOfOtherKernelsAndMethods) {
  expect_messages({
      {&ConfigText::first, "{ axes = \"xy\", kernel = \"box\", size = 3, sigma = 2 }",
       "run.toml:8: filter.groups[0].sigma = 2: applies only with kernel = \"gauss\" or \"gauss-energy\"; here it is "
       "\"box\""},
      {&ConfigText::energy, "sigma_s = 2",
       "run.toml:12: energy.sigma_s = 2: applies only with value_kernel = \"stbn\"; here it is \"distance\""},
      {&ConfigText::optimizer, "fraction = 0.5",
       "run.toml:14: optimizer.fraction = 0.5: applies only with method = \"fast\"; here it is \"auto\""},
      {&ConfigText::optimizer, "method = \"fast\"\ntemperature = { start = 1 }",
       "run.toml:15: optimizer.temperature = { start = 1 }: applies only with method = \"anneal\", \"construct\" or "
       "\"auto\"; here it is \"fast\""},
      {&ConfigText::optimizer, "start = { pattern = \"lattice\", file = \"a.h5\" }",
       "run.toml:14: optimizer.start = { pattern = \"lattice\", file = \"a.h5\" }: must have exactly one of file, "
       "pattern"},
      {&ConfigText::optimizer, "method = \"fast\"\nstart = { file = \"a.h5\" }",
       "run.toml:15: optimizer.start = { file = \"a.h5\" }: applies only with method = \"anneal\" or \"auto\"; here it "
       "is \"fast\""},
      {&ConfigText::first, "{ axes = \"xy\", kernel = \"box\", size = 3, weight = 0.5 }",
       "run.toml:8: filter.groups[0].weight = 0.5: applies only with combine = \"sum\"; here it is \"product\""},
  });
}

TEST(ConfigFaults, NameAxesThatDoNotExistOrRepeat) {
  const std::string ema = ", kernel = \"ema\", alpha = 1 }";
  expect_messages({
      {&ConfigText::second, "{ axes = \"tz\"" + ema,
       "run.toml:9: filter.groups[1].axes = \"tz\": no axis \"z\"; the texture has x, y, t"},
      {&ConfigText::second, "{ axes = [\"time\"]" + ema,
       "run.toml:9: filter.groups[1].axes = [\"time\"]: no axis \"time\"; the texture has x, y, t"},
      {&ConfigText::second, "{ axes = \"tt\"" + ema,
       "run.toml:9: filter.groups[1].axes = \"tt\": axis \"t\" is named twice"},
      {&ConfigText::second, "{ axes = \"xt\"" + ema,
       "run.toml:9: filter.groups[1].axes = \"xt\": axis \"x\" is in filter.groups[0] already; with combine = "
       "\"product\" "
       "an axis belongs to one group"},
      {&ConfigText::second, "{ axes = \"\"" + ema,
       "run.toml:9: filter.groups[1].axes = \"\": must be the names of axes: \"xy\", or [\"time\"] where names are "
       "longer "
       "than a letter"},
      {&ConfigText::size, "size = { x = 7, y = 5, t = 3, channel = 2 }",
       "run.toml:2: texture.size.channel: this name is reserved: in a run file it labels the last dimension, the "
       "components of a sample; choose another"},
      {&ConfigText::size, "size = { x = 7, y = 5, t = 3, \"2nd\" = 2 }",
       "run.toml:2: texture.size.2nd: not the name of an axis; accepted: letters, digits and _, beginning with a "
       "letter"},
  });
  ConfigText config;
  config.size = "size = { x = 7, y = 5, time = 3 }";
  config.second = "{ axes = \"time\"" + ema;
  EXPECT_THAT(faults_of(config.text()),
              ElementsAre("run.toml:9: filter.groups[1].axes = \"time\": a string is read letter "
                          "by letter; did you mean [\"time\"]?"));
}

TEST(ConfigFaults, SuggestHowAxesAreWritten) {
  const auto fault_of = [](const std::string& axes, const std::string& slice_axis) {
    ConfigText config;
    config.size = "size = { x = 7, y = 5, " + slice_axis + " = 3 }";
    config.second = "{ axes = " + axes + ", kernel = \"ema\", alpha = 1 }";
    const auto faults = faults_of(config.text());
    return faults.size() == 1 ? faults.front() : std::to_string(faults.size()) + " faults";
  };
  const std::string head = "run.toml:9: filter.groups[1].axes = ";
  EXPECT_EQ(fault_of("\"time\"", "t"), head +
                                           "\"time\": no axes \"i\", \"m\", \"e\"; the texture has x, y, t; a name "
                                           "longer than a letter is written [\"time\"]");
  EXPECT_EQ(fault_of("\"tmie\"", "time"), head +
                                              "\"tmie\": no axes \"t\", \"m\", \"i\", \"e\"; the texture has x, y, "
                                              "time; did you mean [\"time\"]?");
  EXPECT_EQ(
      fault_of("\"Time\"", "time"),
      head + "\"Time\": no axes \"T\", \"i\", \"m\", \"e\"; the texture has x, y, time; did you mean [\"time\"]?");
  EXPECT_EQ(fault_of("\"T\"", "t"), head + "\"T\": no axis \"T\"; the texture has x, y, t; did you mean \"t\"?");
  EXPECT_EQ(fault_of("\"t, \"", "t"),
            head + "\"t, \": no axes \",\", \" \"; the texture has x, y, t; did you mean \"t\"?");
  EXPECT_EQ(fault_of("[\"t\", 3]", "t"), head +
                                             "[\"t\", 3]: must be the names of axes: \"xy\", or [\"time\"] where names "
                                             "are longer than a letter");
}

TEST(ConfigFaults, SuggestTheTableThatAKeyBelongsTo) {
  const std::string sound = ConfigText{}.text();
  const std::string tables = " accepted: texture, filter, energy, optimizer";
  EXPECT_THAT(faults_of(sound, {"seed=3"}),
              ElementsAre("--set seed=3: seed: unknown key; did you mean \"texture.seed\"?" + tables));
  EXPECT_THAT(faults_of(sound, {"sede=3"}),
              ElementsAre("--set sede=3: sede: unknown key; did you mean \"texture.seed\"?" + tables));
  EXPECT_THAT(faults_of(sound, {"stop.time=10s"}), ElementsAre(HasSubstr("did you mean \"optimizer.stop\"?")));
  EXPECT_THAT(faults_of(sound, {"time=10s"}), ElementsAre(HasSubstr("did you mean \"optimizer.stop.time\"?")));
  EXPECT_THAT(faults_of(sound, {"groups[1].alpha=1"}), ElementsAre(HasSubstr("did you mean \"filter.groups\"?")));
  EXPECT_THAT(faults_of(sound, {"filter.sigma=1"}),
              ElementsAre(HasSubstr("filter.sigma: unknown key; did you mean \"filter.groups[0].sigma\"?")));
  EXPECT_THAT(faults_of(sound, {"filter.grups[1].sigma=1"}),
              ElementsAre(HasSubstr("filter.grups: unknown key; did you mean \"groups\"?")));
  ConfigText config;
  config.seed = "method = \"fast\"";
  EXPECT_THAT(faults_of(config.text()),
              ElementsAre("run.toml:4: texture.method: unknown key; did you mean \"optimizer.method\"? accepted: size, "
                          "samples, seed, stratify"));
}

TEST(ConfigFaults, FollowFromNoWordThatIsKnown) {
  // The method is in fault; the value kernel is not, so that sigma_s belongs to it.
  ConfigText config;
  config.energy = "value_kernel = \"stbn\"\nsigma_s = 0.5";
  EXPECT_THAT(faults_of(config.text(), {"optimizer.method=annael"}), ElementsAre(HasSubstr("unknown method")));
}

TEST(ConfigFaults, NameWeightsThatDoNotAddUp) {
  const auto with_weights = [](const std::string& first, const std::string& second) {
    ConfigText config;
    config.combine = "combine = \"sum\"";
    config.first = "{ axes = \"xy\", kernel = \"gauss-energy\"" + first + " }";
    config.second = "{ axes = \"xt\", kernel = \"gauss-energy\"" + second + " }";
    return faults_of(config.text());
  };
  EXPECT_THAT(with_weights("", ""), IsEmpty());
  EXPECT_THAT(with_weights(", weight = 0.3", ", weight = 0.7000005"), IsEmpty());
  EXPECT_THAT(with_weights(", weight = 0.3", ", weight = 0.700002"),
              ElementsAre("run.toml:7: filter.groups: weights add up to 1.000002; must add up to 1"));
  EXPECT_THAT(with_weights(", weight = 0.3", ""),
              ElementsAre("run.toml:7: filter.groups: 1 of 2 groups have a weight; all must, or none (equal shares)"));
  EXPECT_THAT(with_weights(", weight = 0", ", weight = 1"),
              ElementsAre("run.toml:8: filter.groups[0].weight = 0: must be greater than 0 and at most 1"));
}

TEST(ConfigFaults, AskForExactlyOneStopRule) {
  const std::string rule = "must have exactly one of iterations, time, score, improvement";
  expect_messages({
      {&ConfigText::optimizer, "stop = { iterations = 3, time = \"10s\" }",
       "run.toml:14: optimizer.stop = { iterations = 3, time = \"10s\" }: " + rule},
      {&ConfigText::optimizer, "stop = {}", "run.toml:14: optimizer.stop = {}: " + rule},
  });
}

TEST(ConfigFaults, NameMissingFilesRelativeToTheConfig) {
  ConfigText config;
  config.samples = "samples = { file = \"mine.npy\" }";
  try {
    parse_config(config.text(), "run.toml", "no/such/folder", {});
    FAIL();
  } catch (const UserError& error) {
    EXPECT_STREQ(error.what(),
                 "run.toml:3: texture.samples.file = \"mine.npy\": no such file: no/such/folder/mine.npy");
  }
  EXPECT_NO_THROW(parse_config(config.text(), "run.toml", "no/such/folder", {}, MissingFiles::accepted));
  expect_messages({{&ConfigText::first, "{ axes = \"xy\", kernel = \"table\", file = \"none.npy\" }",
                    "run.toml:8: filter.groups[0].file = \"none.npy\": no such file"}});
}

TEST(ConfigFaults, NameMissingConfigsAndFolders) {
  EXPECT_THROW(
      {
        try {
          load_config("no/such/run.toml", {});
        } catch (const UserError& error) {
          EXPECT_STREQ(error.what(), "no/such/run.toml: no such file");
          throw;
        }
      },
      UserError);
  EXPECT_THROW(load_config(testing::TempDir(), {}), UserError);
}

TEST(ConfigFaults, NameTheLineOfSyntaxErrors) {
  EXPECT_THAT(faults_of("[texture]\nseed = 1\nsize = {\n"),
              ElementsAre(AllOf(StartsWith("run.toml:"), HasSubstr("not valid TOML: "))));
  EXPECT_THAT(faults_of("[texture]\nseed = 1\nseed = 2\n"), ElementsAre(StartsWith("run.toml:3: not valid TOML: ")));
  EXPECT_THAT(faults_of("seed = 1\n[=]\n"), ElementsAre(StartsWith("run.toml:2: not valid TOML: ")));
  EXPECT_THAT(faults_of("\xff\xfe"), ElementsAre(StartsWith("run.toml:1: not valid TOML: ")));
}

TEST(ConfigFaults, CutLongValuesBetweenCharacters) {
  for (std::size_t before = 0; before < 4; ++before) {
    std::string name(before, 'a');
    for (int i = 0; i < 40; ++i) name += "\u00e9";
    ConfigText config;
    config.combine = "combine = \"" + name + '"';
    const std::size_t kept = (55 - before) / 2;  // whole characters of two bytes after the quote
    EXPECT_THAT(faults_of(config.text()), ElementsAre(StartsWith("run.toml:6: filter.combine = \"" +
                                                                 name.substr(0, before + 2 * kept) + " ...: ")));
  }
}

TEST(ConfigFaults, AreAllReportedInTheOrderOfTheLines) {
  ConfigText config;
  config.size = "size = { x = 7, y = 0, t = 0 }";
  config.seed = "sead = 2";
  config.first = "{ axes = \"xyw\", kernel = \"boxx\", size = 3 }";
  config.second = "{ axes = \"t\", kernel = \"ema\", alpha = 7 }";
  config.optimizer = "cutoff = 2";
  EXPECT_THAT(
      faults_of(config.text(), {"optimizer.precision=half", "nonsense"}),
      ElementsAre(
          StartsWith("run.toml:2: texture.size.y"), StartsWith("run.toml:2: texture.size.t"),
          StartsWith("run.toml:4: texture.sead"), StartsWith("run.toml:8: filter.groups[0].axes"),
          StartsWith("run.toml:8: filter.groups[0].kernel"), StartsWith("run.toml:9: filter.groups[1].alpha"),
          StartsWith("run.toml:14: optimizer.cutoff"),
          "--set optimizer.precision=half: optimizer.precision = \"half\": unknown precision; accepted: float, double",
          StartsWith("--set nonsense: must be KEY=VALUE")));
}

TEST(ConfigFaults, NameTheOverrideThatIsWrong) {
  const auto fault = [](const std::string& text) { return faults_of(ConfigText{}.text(), {text}); };
  EXPECT_THAT(fault("texture.seed=x"),
              ElementsAre("--set texture.seed=x: texture.seed = \"x\": must be an integer, at least 0"));
  EXPECT_THAT(fault("texture.sead=3"),
              ElementsAre("--set texture.sead=3: texture.sead: unknown key; did you mean \"seed\"? "
                          "accepted: size, samples, seed, stratify"));
  EXPECT_THAT(fault("filter.groups[3].size=3"),
              ElementsAre("--set filter.groups[3].size=3: the list has 2 elements, counted from 0"));
  EXPECT_THAT(fault("texture.seed[0]=3"), ElementsAre("--set texture.seed[0]=3: not a list"));
  EXPECT_THAT(fault("texture.samples.file=3"),
              ElementsAre("--set texture.samples.file=3: texture.samples.file = 3: applies only with space = \"file\"; "
                          "here it is \"uniform\""));
  EXPECT_THAT(fault("texture.seed.low=3"), ElementsAre("--set texture.seed.low=3: 1 has no key low"));
  EXPECT_THAT(fault("texture.size={ x = 1"), ElementsAre(StartsWith("--set texture.size={ x = 1: not valid TOML: ")));
  EXPECT_THAT(fault("texture.seed=1\ncutoff=2"),
              ElementsAre(StartsWith("--set texture.seed=1\ncutoff=2: more than one value")));
  for (const char* text : {"", "=3", "texture.=3", "texture..seed=3", "filter.groups[x]=3", "filter.groups[0=3"}) {
    EXPECT_THAT(fault(text), ElementsAre(HasSubstr("must be KEY=VALUE"))) << text;
  }
}

}  // namespace
}  // namespace noiseloom
