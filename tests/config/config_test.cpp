#include "noiseloom/config/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "config/config_support.h"
#include "support/source_folder.h"

namespace noiseloom {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

void expect_equal(const GroupSpec& a, const GroupSpec& b) {
  EXPECT_EQ(a.axes, b.axes);
  EXPECT_EQ(a.weight, b.weight);
  EXPECT_EQ(a.kernel.kind, b.kernel.kind);
  EXPECT_EQ(a.kernel.size, b.kernel.size);
  EXPECT_EQ(a.kernel.sigma, b.kernel.sigma);
  EXPECT_EQ(a.kernel.n, b.kernel.n);
  EXPECT_EQ(a.kernel.alpha, b.kernel.alpha);
  EXPECT_EQ(a.kernel.rejection, b.kernel.rejection);
  EXPECT_EQ(a.kernel.file, b.kernel.file);
}

// Every field, bit for bit.
void expect_equal(const RunConfig& a, const RunConfig& b) {
  EXPECT_EQ(a.problem.extents, b.problem.extents);
  EXPECT_EQ(a.problem.samples.space, b.problem.samples.space);
  EXPECT_EQ(a.problem.samples.channels, b.problem.samples.channels);
  EXPECT_EQ(a.problem.samples.file, b.problem.samples.file);
  EXPECT_EQ(a.problem.samples.distance, b.problem.samples.distance);
  EXPECT_EQ(a.problem.samples.compared_by, b.problem.samples.compared_by);
  EXPECT_EQ(a.problem.seed, b.problem.seed);
  EXPECT_EQ(a.problem.filter.combine, b.problem.filter.combine);
  ASSERT_EQ(a.problem.filter.groups.size(), b.problem.filter.groups.size());
  for (std::size_t i = 0; i < a.problem.filter.groups.size(); ++i) {
    expect_equal(a.problem.filter.groups[i], b.problem.filter.groups[i]);
  }
  EXPECT_EQ(a.problem.value_kernel.kind, b.problem.value_kernel.kind);
  EXPECT_EQ(a.problem.value_kernel.sigma_s, b.problem.value_kernel.sigma_s);
  EXPECT_EQ(a.optimizer.method, b.optimizer.method);
  EXPECT_EQ(a.optimizer.stop.iterations, b.optimizer.stop.iterations);
  EXPECT_EQ(a.optimizer.stop.time_s, b.optimizer.stop.time_s);
  EXPECT_EQ(a.optimizer.stop.score, b.optimizer.stop.score);
  EXPECT_EQ(a.optimizer.stop.improvement, b.optimizer.stop.improvement);
  EXPECT_EQ(a.start.file, b.start.file);
  EXPECT_EQ(a.start.pattern, b.start.pattern);
  EXPECT_EQ(a.optimizer.precision, b.optimizer.precision);
  EXPECT_EQ(a.optimizer.cutoff, b.optimizer.cutoff);
  EXPECT_EQ(a.optimizer.background_features, b.optimizer.background_features);
  EXPECT_EQ(a.optimizer.sieve_features, b.optimizer.sieve_features);
  EXPECT_EQ(a.optimizer.temperature_start, b.optimizer.temperature_start);
  EXPECT_EQ(a.optimizer.temperature_end, b.optimizer.temperature_end);
  EXPECT_EQ(a.optimizer.fraction, b.optimizer.fraction);
  EXPECT_EQ(a.optimizer.grow_fraction, b.optimizer.grow_fraction);
  EXPECT_EQ(a.order.density, b.order.density);
  EXPECT_EQ(a.order.bounded, b.order.bounded);
  EXPECT_EQ(a.order.bits, b.order.bits);
  EXPECT_EQ(a.order.equalize, b.order.equalize);
}

void expect_round_trip(const RunConfig& config, const std::string& folder = "") {
  const std::string text = to_toml(config);
  const RunConfig again = parse_config(text, "effective", folder, {});
  expect_equal(config, again);
  EXPECT_EQ(to_toml(again), text);
}

TEST(Config, ReadsEveryKindOfSetting) {
  const RunConfig config = parsed(R"(
[texture]
size = { t = 3, x = 7, z = 2, y = 5 }
samples = "vector3"
seed = 9223372036854775807
[filter]
combine = "sum"
[[filter.groups]]
axes = "yx"
kernel = "gauss"
sigma = 1.3435
weight = 0.25
[[filter.groups]]
axes = ["z", "t"]
kernel = "ema"
alpha = 1
weight = 0.75
[energy]
value_kernel = "stbn"
sigma_s = 2
[optimizer]
method = "fast"
stop = { improvement = 0.001 }
precision = "double"
cutoff = 1e-4
fraction = 0.5
grow_fraction = false
)");
  EXPECT_EQ(config.problem.extents, Extents({7, 5, 3, 2}, {"x", "y", "t", "z"}));
  EXPECT_EQ(config.problem.samples.space, "vector3");
  EXPECT_EQ(config.problem.seed, 9223372036854775807U);
  EXPECT_EQ(config.problem.filter.combine, Combine::sum);
  ASSERT_EQ(config.problem.filter.groups.size(), 2U);
  EXPECT_EQ(config.problem.filter.groups[0].axes, (std::vector<int>{1, 0}));
  EXPECT_EQ(config.problem.filter.groups[0].kernel.kind, KernelKind::gauss);
  EXPECT_EQ(config.problem.filter.groups[0].kernel.sigma, 1.3435);
  EXPECT_EQ(config.problem.filter.groups[0].weight, 0.25);
  EXPECT_EQ(config.problem.filter.groups[1].axes, (std::vector<int>{3, 2}));
  EXPECT_EQ(config.problem.filter.groups[1].kernel.alpha, 1.0);
  EXPECT_EQ(config.problem.value_kernel.kind, ValueKernelKind::stbn);
  EXPECT_EQ(config.problem.value_kernel.sigma_s, 2.0);
  EXPECT_EQ(config.optimizer.method, Method::fast);
  EXPECT_EQ(config.optimizer.stop.iterations, 0);
  EXPECT_EQ(config.optimizer.stop.improvement, 0.001);
  EXPECT_EQ(config.optimizer.precision, Precision::float64);
  EXPECT_EQ(config.optimizer.cutoff, 1e-4);
  EXPECT_EQ(config.optimizer.fraction, 0.5);
  EXPECT_FALSE(config.optimizer.grow_fraction);
  expect_round_trip(config);
}

TEST(Config, LeftOutSettingsHaveTheDefaultsOfTheSpecs) {
  const RunConfig config = parsed(
      "[texture]\nsize = { x = 7, y = 5 }\n[filter]\ngroups = [{ axes = \"xy\", kernel = "
      "\"gauss-energy\" }]\n");
  RunConfig expected;
  expected.problem.extents = Extents({7, 5});
  GroupSpec group;
  group.axes = {0, 1};
  group.kernel.kind = KernelKind::gauss_energy;
  group.kernel.sigma = 1.9;
  expected.problem.filter.groups = {group};
  expected.optimizer.method = Method::construct;  // what auto stands for
  expected.optimizer.stop = StopSpec::none();
  expect_equal(config, expected);
  expect_round_trip(config);
}

TEST(Config, SliceAxesKeepTheOrderInWhichTheyAreWritten) {
  for (const std::vector<std::string>& names :
       std::vector<std::vector<std::string>>{{"t"}, {"z", "t"}, {"w", "a", "t"}, {"view", "t", "b", "a"}, {}}) {
    ConfigText config;
    std::string size = "size = { y = 5, x = 7";
    std::vector<std::int64_t> sizes = {7, 5};
    std::vector<std::string> all = {"x", "y"};
    for (const std::string& name : names) {
      sizes.push_back(static_cast<std::int64_t>(sizes.size() * 2 + 1));
      all.push_back(name);
      size += ", " + name + " = " + std::to_string(sizes.back());
    }
    config.size = size + " }";
    config.second = "";
    const RunConfig read = parsed("[texture]\n" + config.size + "\n[filter]\ngroups = [" + config.first + "]\n");
    EXPECT_EQ(read.problem.extents, Extents(sizes, all));
    expect_round_trip(read);
  }
}

TEST(Config, SliceAxesMayBeWrittenAsATable) {
  const RunConfig config = parsed(
      "[texture.size]\nx = 7\ny = 5\nz = 3\nb = 2\n[filter]\ngroups = [{ axes = \"b\", kernel = "
      "\"binomial\", n = 2 }]\n");
  EXPECT_EQ(config.problem.extents, Extents({7, 5, 3, 2}, {"x", "y", "z", "b"}));
  EXPECT_EQ(config.problem.filter.groups[0].axes, std::vector<int>{3});
}

TEST(Config, EqualSharesWhereNoGroupHasAWeight) {
  ConfigText text;
  text.combine = "combine = \"sum\"";
  text.second += ",\n{ axes = \"xyt\", kernel = \"box\", size = 2 }";
  const RunConfig config = parsed(text.text());
  for (const GroupSpec& group : config.problem.filter.groups) EXPECT_EQ(group.weight, 1.0 / 3);
  expect_round_trip(config);
}

TEST(Config, RoundTripsExactlyForEverySampleSpaceKernelAndNumber) {
  const std::vector<std::string> samples = {"uniform", "tent",    "gauss",      "circle",  "vector2",
                                            "vector3", "vector4", "vector5",    "vector6", "vector7",
                                            "vector8", "sphere",  "hemisphere", "disk",    "hemisphere-cosine"};
  const std::vector<std::string> kernels = {"box\", size = 65536", "gauss\", sigma = 0.1", "binomial\", n = 1000",
                                            "ema\", alpha = 1e-6, rejection = 0.3333333333333333",
                                            "gauss-energy\", sigma = 1e4"};
  const std::vector<std::string> stops = {"iterations = 1000000000", "time = \"1h30m0.1s\"", "time = 0.1",
                                          "score = 0.06", "improvement = 1e-300"};
  for (std::size_t i = 0; i < samples.size() * kernels.size() * stops.size(); ++i) {
    ConfigText text;
    text.samples = "samples = \"" + samples[i % samples.size()] + '"';
    text.combine = i % 2 == 0 ? "combine = \"sum\"" : "combine = \"product\"";
    text.first = "{ axes = \"xy\", kernel = \"" + kernels[i / samples.size() % kernels.size()] +
                 (i % 2 == 0 ? ", weight = 0.1 }" : " }");
    text.second =
        "{ axes = \"t\", kernel = \"" + kernels[i % kernels.size()] + (i % 2 == 0 ? ", weight = 0.9 }" : " }");
    text.energy = i % 3 == 0 ? "value_kernel = \"stbn\"\nsigma_s = 0.7" : "";
    text.optimizer =
        "stop = { " + stops[i / samples.size() / kernels.size()] + " }\n" +
        (i % 4 == 0
             ? "method = \"fast\"\nfraction = 0.3\ngrow_fraction = false"
             : "cutoff = 0.1\nbackground_features = 5\nsieve_features = 7\ntemperature = { start = 3, end = 1e-7 }");
    expect_round_trip(parsed(text.text()));
  }
}

TEST(Config, StartsFromAPattern) {
  ConfigText text;
  const auto read = [&](const char* optimizer) {
    text.optimizer = optimizer;
    const RunConfig config = parse_config(text.text(), "run.toml", "", {});
    expect_round_trip(config);
    return config.start;
  };
  EXPECT_EQ(read("start = { pattern = \"lattice\" }").pattern, StartPattern::lattice);
  EXPECT_FALSE(read("start = { pattern = \"none\" }").is_given());
  EXPECT_FALSE(read("").is_given());
  // What the command line says takes the place of what the file does.
  text.optimizer = "start = { file = \"a.h5\" }";
  const RunConfig other = parse_config(text.text(), "run.toml", "", {"optimizer.start.pattern=lattice"});
  EXPECT_EQ(other.start.pattern, StartPattern::lattice);
  EXPECT_TRUE(other.start.file.empty());
  text.optimizer = "start = { pattern = \"lattice\" }";
  EXPECT_FALSE(parse_config(text.text(), "run.toml", "", {"optimizer.start.pattern=none"}).start.is_given());
}

TEST(Config, EveryConfigOfTheRepositoryRoundTrips) {
  int count = 0;
  const std::string folder = testing_support::source_folder() + "/configs";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (entry.path().extension() != ".toml" || name.starts_with("gallery")) continue;  // lists of what varies
    SCOPED_TRACE(entry.path());
    expect_round_trip(load_config(entry.path().string(), {}), folder);
    ++count;
  }
  EXPECT_GE(count, 10);
}

TEST(Config, TextIsStableAndReadable) {
  ConfigText annealed;
  annealed.optimizer = "method = \"anneal\"\n" + annealed.optimizer;
  EXPECT_EQ(to_toml(parsed(annealed.text())), R"([texture]
size = { x = 7, y = 5, t = 3 }
samples = "uniform"
seed = 1
stratify = "slice"

[filter]
combine = "product"
groups = [
  { axes = "xy", kernel = "box", size = 3 },
  { axes = "t", kernel = "ema", alpha = 0.1, rejection = 0.0 },
]

[energy]
value_kernel = "distance"

[optimizer]
method = "anneal"
stop = { iterations = 11 }
precision = "float"
background_features = 8
sieve_features = 16
)");
}

TEST(Config, AutoStandsForWhatTheSamplesAskFor) {
  ConfigText text;
  const auto with = [&](const std::string& samples, const std::string& optimizer, const std::string& energy = "") {
    text.samples = "samples = " + samples;
    text.optimizer = optimizer;
    text.energy = energy;
    return parsed(text.text()).optimizer;
  };
  for (const char* scalars : {"\"uniform\"", "\"tent\"", "\"gauss\"", "\"circle\""}) {
    EXPECT_EQ(with(scalars, "").method, Method::construct) << scalars;
    EXPECT_TRUE(with(scalars, "method = \"auto\"").stop.is_none()) << scalars;
  }
  EXPECT_EQ(with("\"uniform\"", "stop = { time = 3 }").method, Method::construct);
  EXPECT_EQ(with("\"uniform\"", "stop = { time = 3 }").stop.time_s, 3);
  for (const char* others : {"\"vector2\"", "\"sphere\"", "\"disk\""}) {
    EXPECT_EQ(with(others, "").method, Method::anneal) << others;
    EXPECT_EQ(with(others, "").stop.iterations, 1000) << others;
  }
  EXPECT_EQ(with("\"uniform\"", "", "value_kernel = \"stbn\"").method, Method::anneal);
  EXPECT_EQ(with("\"uniform\"", "method = \"construct\"").method, Method::construct);
  EXPECT_EQ(with("\"uniform\"", "method = \"anneal\"").stop.iterations, 1000);
  text.samples = "samples = \"sphere\"";
  text.energy = "";
  text.optimizer = "sharpness = 1.2";
  EXPECT_THAT(faults_of(text.text()),
              ElementsAre("run.toml:14: optimizer.sharpness = 1.2: is for construction alone, but method = \"auto\" "
                          "anneals here"));
  // A circle starts from half of the pixels.
  text.samples = "samples = \"circle\"";
  for (const char* method : {"", "method = \"construct\"\n"}) {
    text.optimizer = std::string(method) + "density = 0.1";
    EXPECT_THAT(faults_of(text.text()), ElementsAre(HasSubstr("optimizer.density = 0.1: is for samples that are "
                                                              "compared by their difference")));
  }
  text.optimizer = "sharpness = 3";
  const RunConfig circle = parsed(text.text());
  EXPECT_EQ(parsed(to_toml(circle)).construct.sharpness, 3) << "what is stored is read again";
}

TEST(Config, FormerKeysAreReadAsTheirPresentNames) {
  ConfigText former;
  former.optimizer = "stop = { iterations = 11 }\nbackground_rank = 5";
  ConfigText present;
  present.optimizer = "stop = { iterations = 11 }\nbackground_features = 5";
  const std::string stored = to_toml(parsed(former.text()));
  EXPECT_EQ(stored, to_toml(parsed(present.text())));
  EXPECT_THAT(stored, HasSubstr("\nbackground_features = 5\n"));
  // A run file of that time goes on with the config of today.
  EXPECT_THAT(config_differences(former.text(), present.text()), IsEmpty());
  EXPECT_EQ(parsed(former.text(), {"optimizer.background_features=7"}).optimizer.background_features, 7);
  EXPECT_EQ(parsed(present.text(), {"optimizer.background_rank=7"}).optimizer.background_features, 7);
}

TEST(Config, AFormerKeyBesideItsPresentNameIsAFault) {
  ConfigText both;
  both.optimizer = "stop = { iterations = 11 }\nbackground_rank = 5\nbackground_features = 6";
  try {
    parsed(both.text());
    FAIL() << "nothing was thrown";
  } catch (const UserError& error) {
    EXPECT_THAT(error.what(), HasSubstr("optimizer.background_rank: is what older files call background_features, "
                                        "which stands here too"));
  }
}

TEST(Config, OverridesReplaceAddAndAppend) {
  const RunConfig config =
      parsed(ConfigText{}.text(),
             {"texture.seed=5", "texture.size.t=11", "texture.size.z=2", "texture.samples=vector4",
              "filter.groups[0].size = 5", "filter.groups[1]={ axes = 't', kernel = 'gauss', sigma = 0.5 }",
              "filter.groups[2]={ axes = \"z\", kernel = \"box\", size = 1 }", "optimizer.precision=double"});
  EXPECT_EQ(config.problem.seed, 5U);
  EXPECT_EQ(config.problem.extents, Extents({7, 5, 11, 2}));
  EXPECT_EQ(config.problem.samples.space, "vector4");
  EXPECT_EQ(config.problem.filter.groups[0].kernel.size, 5);
  EXPECT_EQ(config.problem.filter.groups[1].kernel.sigma, 0.5);
  EXPECT_EQ(config.problem.filter.groups[2].axes, std::vector<int>{3});
  EXPECT_EQ(config.optimizer.precision, Precision::float64);
}

TEST(Config, StopRuleOfAnOverrideReplacesThatOfTheFile) {
  const RunConfig config = parsed(ConfigText{}.text(), {"optimizer.stop.time=1h30m"});
  EXPECT_EQ(config.optimizer.stop.iterations, 0);
  EXPECT_EQ(config.optimizer.stop.time_s, 5400.0);
  EXPECT_EQ(parsed(ConfigText{}.text(), {"optimizer.stop.iterations=3"}).optimizer.stop.iterations, 3);
  EXPECT_THAT(faults_of(ConfigText{}.text(), {"optimizer.stop.time=1h", "optimizer.stop.score=0.5"}),
              ElementsAre(HasSubstr("must have exactly one of")));
}

TEST(Config, SamplesOfASpaceMayBeComparedByAnotherDistance) {
  const auto samples = [](const std::string& value) {
    ConfigText text;
    text.samples = "samples = " + value;
    return text.text();
  };
  const std::string manhattan = "{ space = \"vector2\", distance = \"manhattan\" }";
  const RunConfig config = parsed(samples(manhattan));
  EXPECT_EQ(config.problem.samples.compared_by, ComparedBy::manhattan);
  EXPECT_THAT(to_toml(config), HasSubstr("samples = " + manhattan));
  expect_round_trip(config, "");
  EXPECT_THAT(to_toml(parsed(samples("{ space = \"ring\", inner = 0.25, distance = \"chebyshev\" }"))),
              HasSubstr("samples = { space = \"ring\", distance = \"chebyshev\", inner = 0.25 }"));
  EXPECT_THAT(to_toml(parsed(samples("{ space = \"vector2\", distance = \"own\" }"))),
              HasSubstr("samples = \"vector2\""));
  // Another space is compared by its own distance again.
  EXPECT_EQ(parsed(samples(manhattan), {"texture.samples=sphere"}).problem.samples.compared_by, ComparedBy::own);
  EXPECT_EQ(parsed(samples("\"sphere\""), {"texture.samples.distance=cosine"}).problem.samples.compared_by,
            ComparedBy::cosine);
  EXPECT_THAT(faults_of(samples("{ space = \"vector2\", distance = \"L1\" }")),
              ElementsAre(HasSubstr("did you mean \"manhattan\"?")));
  EXPECT_THAT(faults_of(samples("{ space = \"vector2\", distance = \"cosine\" }")),
              ElementsAre(HasSubstr("accepted: own, euclidean, manhattan, chebyshev")));
  for (const char* space : {"uniform", "circle", "rotation", "axis"})
    EXPECT_THAT(faults_of(samples(std::string("{ space = \"") + space + "\", distance = \"manhattan\" }")),
                ElementsAre(HasSubstr("applies only with space = ")));
}

TEST(Config, FileNamesAreOpenedFromTheFolderOfTheConfigAndStoredAsWritten) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "config_test \"folder\"";
  std::filesystem::create_directories(folder / "taps");
  for (const char* file : {"mine.npy", "taps/t.npy"}) std::ofstream(folder / file) << "bytes";
  ConfigText text;
  text.samples = "samples = { file = \"mine.npy\", distance = \"angle\" }";
  text.second = "{ axes = \"t\", kernel = \"table\", file = \"./taps/../taps/t.npy\" }";
  std::ofstream(folder / "run.toml") << text.text();

  const RunConfig config = load_config((folder / "run.toml").string(), {});
  EXPECT_EQ(config.problem.samples.space, "file");
  EXPECT_EQ(config.problem.samples.distance, DistanceKind::angle);
  EXPECT_TRUE(std::filesystem::equivalent(config.problem.samples.file, folder / "mine.npy"));
  EXPECT_TRUE(std::filesystem::equivalent(config.problem.filter.groups[1].kernel.file, folder / "taps/t.npy"));
  EXPECT_THAT(to_toml(config), HasSubstr("samples = { file = \"mine.npy\", distance = \"angle\" }"));
  EXPECT_THAT(to_toml(config), HasSubstr("file = \"./taps/../taps/t.npy\""));
  expect_round_trip(config, folder.string());

  text.samples = "samples = { file = '" + (folder / "mine.npy").string() + "' }";  // absolute paths stay so
  const RunConfig absolute = parse_config(text.text(), "run.toml", folder.string(), {});
  EXPECT_EQ(absolute.problem.samples.file, (folder / "mine.npy").string());
  EXPECT_THAT(to_toml(absolute), HasSubstr("config_test \\\"folder\\\"/mine.npy\""));
  expect_round_trip(absolute, folder.string());
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace noiseloom
