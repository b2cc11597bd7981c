// Lines of the published programs: what they mean, and what is wrong with them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "noiseloom/config/config.h"
#include "noiseloom/core/index.h"
#include "noiseloom/problem/value_kernel.h"
#include "noiseloom/published/line.h"
#include "noiseloom/run/generate.h"
#include "noiseloom/samples/sample_space.h"
#include "support/mpi_session.h"
#include "support/sample_run_file.h"
#include "support/sanitizers.h"

namespace noiseloom {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

PublishedLine read_line(const std::string& program, const std::string& line) {
  return find_published_program(program)->read(words_of(line));
}

RunConfig meaning(const PublishedLine& line) {
  return parse_config(line.config, "line", "", {}, MissingFiles::accepted);
}

std::string faults_of_line(const std::string& program, const std::string& line) {
  try {
    read_line(program, line);
  } catch (const UserError& error) {
    return error.what();
  }
  return "";
}

// The lines of the batch file that is published with the program, at W x H x D: the size of what has slices.
std::vector<std::string> batch_lines(const std::string& size, const std::string& folder) {
  struct Kind {
    const char* words;
    const char* name;
    const char* folder;
  };
  const std::vector<Kind> kinds = {
      {"real Uniform", "real_uniform", "real"},          {"circle Uniform", "circle_uniform", "real"},
      {"vector2 Uniform", "vector2_uniform", "vector2"}, {"vector3 Uniform", "vector3_uniform", "vector3"},
      {"sphere Uniform", "sphere_uniform", "sphere"},    {"sphere Cosine", "sphere_coshemi", "sphere"}};
  const std::vector<std::pair<const char*, const char*>> filters = {{"Box 3", "box3x3"},
                                                                    {"Box 5", "box5x5"},
                                                                    {"Gauss 1.0", "gauss1_0"},
                                                                    {"Binomial 2", "binomial3x3"},
                                                                    {"Binomial 4", "binomial5x5"}};
  const std::string flat = size.substr(0, size.rfind(' ')) + " 1";
  std::vector<std::string> lines;
  const auto add_plane = [&](const Kind& kind) {
    for (const auto& [words, name] : filters)
      lines.push_back(fmt::format("{} {} Box 1 product {} {}/{}/{}_{} -seed 5489", kind.words, words, flat, folder,
                                  kind.folder, kind.name, name));
  };
  for (const Kind& kind : kinds) add_plane(kind);
  add_plane({"real Tent", "real_tent", "real"});
  for (const Kind& kind : kinds)
    for (const auto& [time, time_name] :
         {std::pair("exponential 0.1 0.1", "exp0101"), std::pair("gauss 1.0", "Gauss10")})
      for (const auto& [combine, combine_name] :
           {std::pair("product", "product"), std::pair("separate 0.5", "separate05")})
        for (const auto& [words, name] : filters)
          lines.push_back(fmt::format("{} {} {} {} {} {}/{}/{}_{}_{}_{} -split -seed 5489", kind.words, words, time,
                                      combine, size, folder, kind.folder, kind.name, name, time_name, combine_name));
  for (const auto& [time, time_name] : {std::pair("gauss 1.0", "Gauss10"), std::pair("exponential 0.1 0.1", "exp0101")})
    lines.push_back(
        fmt::format("sphere Cosine Box 1 {} separate 0.5 {} {}/sphere/sphere_coshemi_box1x1_{}_separate05 "
                    "-split -seed 5489",
                    time, size, folder, time_name));
  return lines;
}

TEST(PublishedLines, EveryLineOfTheBatchFilesMakesItsImages) {
  const TemporaryFolder folder;
  std::vector<std::string> lines = batch_lines("16 16 4", folder / "out");
  EXPECT_EQ(lines.size(), 157U);
  for (const int number : {0, 999})
    lines.push_back(fmt::format("real Gauss Gauss 1.0 Box 1 product 32 32 1 {}/gauss/real_gauss_gauss1_0_{}",
                                folder / "out", number));
  // All of them, but some under sanitizers.
  for (std::size_t i = 0; i < lines.size();
       i += lines.size() / testing_support::tried(narrow<unsigned>(lines.size()))) {
    const std::string& text = lines[i];
    SCOPED_TRACE(text);
    const PublishedLine line = read_line("fastnoise", text + " -numsteps 2");
    std::ofstream(folder / "line.toml") << line.config;
    Progress progress(ProgressKind::silent);
    GenerateRequest request;
    request.config = folder / "line.toml";
    request.output = folder / "line.h5";
    request.overwrite = true;
    request.threads = 1;
    EXPECT_TRUE(generate(request, Communicator::self(), progress).finished);
    const ExportResult result = export_run_file(folder / "line.h5", images_of_step(line, 0), posix_file_ops());
    EXPECT_EQ(result.files, published_files(line, 0));
    EXPECT_EQ(result.files.size(), text.find("-split") == std::string::npos ? 1U : 4U);
    for (const std::string& file : result.files) EXPECT_TRUE(std::filesystem::exists(file)) << file;
  }
}

TEST(PublishedLines, FilterAdaptedNoise) {
  const PublishedLine line = read_line(
      "fastnoise", "REAL tent BOX 3 EXPONENTIAL 0.1 0.2 Separate 0.25 8 16 4 a/n%d -split -seed 7 -NumSteps 9");
  const RunConfig config = meaning(line);
  EXPECT_EQ(config.problem.samples.space, "tent");
  EXPECT_EQ(config.problem.seed, 7U);
  EXPECT_EQ(config.optimizer.stop.iterations, 9);
  EXPECT_EQ(config.problem.extents.to_string(), "8 x 16 x 4");
  ASSERT_EQ(config.problem.filter.groups.size(), 2U);
  EXPECT_EQ(config.problem.filter.combine, Combine::sum);
  EXPECT_EQ(config.problem.filter.groups[0].kernel.size, 3);
  EXPECT_DOUBLE_EQ(config.problem.filter.groups[0].weight, 0.25);
  EXPECT_DOUBLE_EQ(config.problem.filter.groups[1].kernel.alpha, 0.1);
  EXPECT_DOUBLE_EQ(config.problem.filter.groups[1].kernel.rejection, 0.2);
  EXPECT_THAT(published_files(line, 0), ElementsAre("a/n_d_0.png", "a/n_d_1.png", "a/n_d_2.png", "a/n_d_3.png"));
  EXPECT_EQ(line.images.channels, "RGBA");
}

TEST(PublishedLines, OneWeightAloneIsOneGroup) {
  for (const auto& [weight, axis] : {std::pair("1", 0), std::pair("0", 2)}) {
    const RunConfig config =
        meaning(read_line("fastnoise", fmt::format("Real Uniform Box 3 Box 5 Separate {} 8 8 4 n", weight)));
    ASSERT_EQ(config.problem.filter.groups.size(), 1U);
    EXPECT_EQ(config.problem.filter.groups[0].axes.front(), axis);
  }
}

TEST(PublishedLines, WithoutASeedEachLineIsAnotherTexture) {
  const char* const text = "Real Uniform Box 3 Box 1 Product 8 8 1 n";
  EXPECT_NE(meaning(read_line("fastnoise", text)).problem.seed, meaning(read_line("fastnoise", text)).problem.seed);
}

TEST(PublishedLines, NamesOfKindsAndSteps) {
  EXPECT_THAT(published_files(read_line("fastnoise", "Real Gauss Box 3 Box 1 Product 8 8 4 n"), 0),
              ElementsAre("n.hdr"));
  EXPECT_THAT(published_files(read_line("fastnoise", "Real Uniform Box 3 Box 1 Product 8 8 1 n -split"), 0),
              ElementsAre("n.png"));
  const PublishedLine line =
      read_line("fastnoise", "Circle Uniform Box 3 Box 1 Product 8 8 2 n -split -output csv -numsteps 10 -progress 3");
  EXPECT_THAT(line.steps, ElementsAre(3, 6, 10));
  EXPECT_THAT(published_files(line, 6), ElementsAre("n_0.6.csv", "n_1.6.csv"));
}

TEST(PublishedLines, WhatIsWrongIsToldWithItsPlaceAllAtOnce) {
  const std::string faults =
      faults_of_line("fastnoise", "Reel Tent Box 3.5 Gauss 1x Product 8 0 1 n -sed 5 -numsteps -output bmp");
  EXPECT_THAT(faults, HasSubstr("word 1 \"Reel\": unknown SPACE; did you mean Real? accepted: Real, Circle"));
  EXPECT_THAT(faults, HasSubstr("word 4 \"3.5\": XY Box SIZE must be an integer from 1 to 65536"));
  EXPECT_THAT(faults, HasSubstr("word 6 \"1x\": Z Gauss SIGMA must be a number"));
  EXPECT_THAT(faults, HasSubstr("word 9 \"0\": H must be"));
  EXPECT_THAT(faults, HasSubstr("word 12 \"-sed\": unknown option; did you mean -seed?"));
  EXPECT_THAT(faults, HasSubstr("word 15 \"-output\": -numsteps N must be an integer"));
  EXPECT_THAT(faults_of_line("fastnoise", "Circle Tent Box 3 Box 1 Product 8 8 1 n"),
              HasSubstr("word 2 \"Tent\": unknown DIST of Circle; accepted: Uniform"));
  EXPECT_THAT(faults_of_line("fastnoise", "Real Uniform Box"), HasSubstr("the line ends where XY Box SIZE must stand"));
  EXPECT_THAT(faults_of_line("fastnoise", "Real Uniform Exponential 0.1 0.1 Box 1 Product 8 8 1 n"),
              HasSubstr("unknown XY"));
  EXPECT_THAT(faults_of_line("fastnoise", "Real Uniform Box 3 Box 1 Product 8 8 1 n_{}"),
              HasSubstr("FILE must hold no"));
  EXPECT_THAT(faults_of_line("stbn-vector", "--dimX 3 -t Flat"),
              testing::AllOf(HasSubstr("word 1 \"--dimX\": unknown option; did you mean --dimsX?"),
                             HasSubstr("word 4 \"Flat\": unknown --type; did you mean Float?"), HasSubstr("2")));
  EXPECT_THAT(faults_of_line("stbn-vector", "-t Float2 -d NegativeDot"), HasSubstr("is for Float3, not Float2"));
  EXPECT_THAT(faults_of_line("stbn-scalar", "--sX 1.9 --sY 2.5"), HasSubstr("must be the same"));
  EXPECT_THAT(faults_of_line("stbn-scalar", "--dimsX=1e3"), HasSubstr("word 2 \"1e3\": --dimsX must be an integer"));
}

TEST(PublishedLines, StartsFromTheNumbersOfAFile) {
  const TemporaryFolder folder;
  std::vector<float> numbers;
  for (int i = 0; i < 4 * 8 * 4 * 2; ++i) numbers.push_back(static_cast<float>(i) / 512);
  const auto bytes = static_cast<std::streamsize>(numbers.size() * sizeof(float));
  std::ofstream(folder / "init", std::ios::binary).write(reinterpret_cast<const char*>(numbers.data()), bytes);
  const PublishedLine line = read_line(
      "fastnoise", fmt::format("Vector2 Uniform Box 3 Box 1 Product 8 4 2 {} -init {}", folder / "n", folder / "init"));
  ASSERT_EQ(line.inputs.size(), 1U);
  EXPECT_THAT(line.inputs[0].shape, ElementsAre(2, 4, 8, 2));
  const std::vector<float> taken = line.inputs[0].values();
  for (std::size_t texel = 0; texel < 64; ++texel)
    for (std::size_t c = 0; c < 2; ++c) EXPECT_EQ(taken[2 * texel + c], numbers[4 * texel + c]);
  EXPECT_EQ(meaning(line).start.file, "n.unfinished.npy");
  EXPECT_THAT(
      faults_of_line("fastnoise", fmt::format("Real Uniform Box 3 Box 1 Product 8 8 2 n -init {}", folder / "init")),
      HasSubstr("1024 bytes; -init takes 4 floats for each of 8x8x2 texels: 2048 bytes"));
}

TEST(PublishedLines, MasksOfScalars) {
  const PublishedLine line =
      read_line("stbn-scalar", "--dimsX 16 --dimsY=8 --dimsZ 4 --dimsW 2 -i r22 -o m --ibpd 0.2");
  const RunConfig config = meaning(line);
  EXPECT_EQ(config.problem.extents.to_string(), "16 x 8 x 4 x 2");
  ASSERT_EQ(config.problem.filter.groups.size(), 2U);
  EXPECT_THAT(config.problem.filter.groups[1].axes, ElementsAre(2, 3));
  EXPECT_EQ(published_files(line, 0).back(), "m/stbn_scalar_Reference_2Dx2D_16x8x4_7.png");
  const PublishedLine plain = read_line("stbn-scalar", "");
  EXPECT_EQ(published_files(plain, 0).back(), "output/stbn_scalar_Splice_Cache_2Dx1Dx1D_128x128x64_63.png");
  EXPECT_EQ(meaning(plain).problem.seed, 0x1337FEEDU);
}

TEST(PublishedLines, BlueNoiseOfVectors) {
  const PublishedLine line = read_line("stbn-vector", "");
  const RunConfig config = meaning(line);
  EXPECT_EQ(config.problem.samples.space, "vector2");
  EXPECT_EQ(config.optimizer.stop.iterations, 2097);
  EXPECT_EQ(config.problem.filter.groups[0].kernel.sigma, 1.9);
  EXPECT_EQ(published_files(line, 0).front(), "out/VectorSTBN_128x128x64_128x128x64_0.png");
  EXPECT_EQ(meaning(read_line("stbn-vector", "-t Float")).problem.samples.space, "uniform");
  const PublishedLine unit = read_line("stbn-vector", "-g Unit -x 8 -y 4 -z 2");
  ASSERT_EQ(unit.inputs.size(), 1U);
  EXPECT_THAT(unit.inputs[0].shape, ElementsAre(32, 2));
  EXPECT_EQ(unit.images.range, "-1:1");
  EXPECT_EQ(unit.inputs[0].values().size(), 64U);
  // The same on every machine: quarters of a turn are exact.
  EXPECT_THAT(read_line("stbn-vector", "-g Unit -x 2 -y 1 -z 2").inputs[0].values(), ElementsAre(0, 1, 0, -1));
  // Made when they are written, and not before anybody has looked at the size.
  EXPECT_NO_THROW(read_line("stbn-vector", "-x 1048576 -y 1048576 -g Unit"));
}

TEST(PublishedLines, VectorsAreComparedByTheDistanceOfTheLine) {
  struct Case {
    const char* line;
    DistanceKind distance;
    int channels;
  };
  for (const Case& c :
       {Case{"", DistanceKind::manhattan, 2}, Case{"-d L2", DistanceKind::euclidean, 2},
        Case{"-d LInfinity", DistanceKind::chebyshev, 2}, Case{"-t Float3", DistanceKind::manhattan, 3},
        Case{"-t Float3 -d L2", DistanceKind::euclidean, 3}, Case{"-t Float3 -g Unit", DistanceKind::manhattan, 3},
        Case{"-t Float3 -g Unit -d L2", DistanceKind::euclidean, 3},
        Case{"-t Float3 -g Unit -d LInfinity", DistanceKind::chebyshev, 3},
        Case{"-t Float3 -g Unit -d NegativeDot", DistanceKind::cosine, 3}, Case{"-g Unit", DistanceKind::manhattan, 2},
        Case{"-g Unit -d L2", DistanceKind::euclidean, 2}, Case{"-g Unit -d LInfinity", DistanceKind::chebyshev, 2},
        Case{"-t Float -d Abs", DistanceKind::absolute, 1}}) {
    const PublishedLine line = read_line("stbn-vector", c.line);
    EXPECT_EQ(distance_kind(meaning(line).problem.samples, c.channels), c.distance) << c.line;
    EXPECT_THAT(line.notes, testing::IsEmpty()) << c.line;
  }
  EXPECT_THAT(read_line("stbn-vector", "-t Float3 -d NegativeDot").notes,
              ElementsAre(HasSubstr("compared by their Euclidean distance")));
  EXPECT_THAT(read_line("stbn-vector", "--coolingFactor 0.1").notes, ElementsAre(HasSubstr("0.1 N^2")));
}

// In the published program a pair of pixels counts k(dx) k(dy) in a plane and k(dz) along the slices, where k is a
// Gaussian over the sum of one half of it; and samples count exp(-d^(D/3) / (2 S^2)), of points between -1 and 1.
TEST(PublishedLines, VectorsHaveTheKernelsOfThePublishedProgram) {
  for (const auto& [text, channels, unit, asked] :
       {std::tuple("-x 64 -y 32 -z 8 --energySigma 1.7 --valueSigma 0.8", 2, false, 0.8),
        std::tuple("-x 64 -y 32 -z 8 -d L2 --valueSigma 0.8", 2, false, 0.8),
        std::tuple("-x 64 -y 32 -z 8 -d LInfinity", 2, false, 1.0),
        std::tuple("-z 1 -t Float3 --valueSigma 1.3", 3, false, 1.3), std::tuple("-t Float", 1, false, 1.0),
        std::tuple("-t Float3 -g Unit --valueSigma 0.9", 3, true, 0.9)}) {
    SCOPED_TRACE(text);
    const RunConfig config = meaning(read_line("stbn-vector", text));
    const ProblemSpec& problem = config.problem;
    ASSERT_EQ(problem.extents.num_axes(), 3);
    const ValueKernel kernel = make_value_kernel(problem, channels, distance_kind(problem.samples, channels));
    const std::vector<float> a = {0, 0, 1};
    const std::vector<float> b = {0, 1, 0};
    const double d = distance(kernel.distance, channels, a.data(), b.data()) * (unit ? 1 : 2);
    EXPECT_NEAR(kernel(a.data(), b.data()), std::exp(-std::pow(d, channels / 3.0) / (2 * asked * asked)), 1e-12);
    if (problem.extents.num_slices() == 1) continue;
    const double sigma = problem.filter.groups[0].kernel.sigma;
    const auto k = [&](int axis, double at) {
      double sum = 1;
      const auto reach = static_cast<std::int64_t>(3.2552 * sigma);
      for (std::int64_t i = 1; i <= std::min<std::int64_t>(reach, problem.extents.size(axis) / 2); ++i)
        sum += std::exp(-static_cast<double>(i * i) / (2 * sigma * sigma));
      return std::exp(-at * at / (2 * sigma * sigma)) / sum;
    };
    const double found = problem.filter.groups[1].weight / problem.filter.groups[0].weight;
    EXPECT_NEAR(found / (k(2, 0) / (k(0, 0) * k(1, 0))), 1, 1e-3);
  }
}

}  // namespace
}  // namespace noiseloom
