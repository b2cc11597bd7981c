#include "run/jobs/joining.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/run_files.h"

namespace noiseloom {
namespace {

RunConfig scalars_under(const std::string& kernel, const std::string& iterations,
                        const std::string& samples = "\"uniform\"") {
  return parse_config("[texture]\nsize = { x = 64, y = 64 }\nsamples = " + samples +
                          "\n[filter]\ngroups = [ { axes = \"xy\", kernel = " + kernel +
                          " } ]\n[optimizer]\nmethod = \"construct\"\nstop = { iterations = " + iterations + " }\n",
                      "test.toml", "", {}, MissingFiles::accepted);
}

Joining joining_for(const RunConfig& config, double given_error, int threads = 1) {
  const Extents& extents = config.problem.extents;
  const SampleSource source(config.problem.samples, extents.cells_per_slice(), extents.num_slices(), 1);
  ThreadPool pool(threads);
  return find_joining(config, source, {.given_error = given_error}, pool);
}

TEST(Joining, FollowsWhatAnnealingWouldComeTo) {
  EXPECT_FALSE(joining_of(0.8).cold);
  EXPECT_EQ(joining_of(0.8).fraction, 0);
  EXPECT_NEAR(joining_of(1).fraction, 0.35, 1e-12);
  EXPECT_EQ(joining_of(0.97).fraction, 0.35) << "what trials foretell is lower than what comes";
  EXPECT_GT(joining_of(1.03).fraction, joining_of(1).fraction);
  EXPECT_LT(joining_of(1.03).fraction, 0.5);
  EXPECT_TRUE(joining_of(1.3).cold);
  EXPECT_TRUE(joining_of(std::nan("")).cold) << "where nothing is known nothing is risked";
}

TEST(Joining, ExtrapolatesByALawOfFallingGains) {
  EXPECT_EQ(extrapolated_error(0.2, 0.1, 100, 100), 0.1);
  EXPECT_EQ(extrapolated_error(0.1, 0.1, 100, 1e6), 0.1) << "where nothing was gained nothing will be";
  EXPECT_EQ(extrapolated_error(0.1, 0.2, 100, 1e6), 0.2);
  // The last four times as many gained a half, the next gain that half to the power of 3/4, those after of 9/16.
  EXPECT_NEAR(extrapolated_error(0.2, 0.1, 100, 400), 0.1 * std::pow(0.5, 0.75), 1e-6);
  EXPECT_NEAR(extrapolated_error(0.2, 0.1, 100, 1600), 0.1 * std::pow(0.5, 0.75 + 0.5625), 1e-6);
}

TEST(Joining, OfAConstructedCircleIsInTheScheduleUnlessThereIsNoTime) {
  const auto joining = [](const std::string& iterations) {
    return joining_for(scalars_under("\"gauss\", sigma = 0.7", iterations, "\"circle\""), 0.044);
  };
  EXPECT_TRUE(joining("100").cold);
  EXPECT_FALSE(joining("1000").cold);
  EXPECT_EQ(joining("1000").fraction, 0.4);
  EXPECT_EQ(joining("8000").fraction, 0.3);
}

// R of constructions, and what annealing comes to in as many iterations: 64x64, box 3: 0.136 in 4,000; gauss 1.0: 0.112
// in 400.
TEST(Joining, BeginsAnewWhereAnnealingComesLowerAndInTheColdWhereItDoesNot) {
  const Joining box = joining_for(scalars_under("\"box\", size = 3", "6000"), 0.1517);
  EXPECT_FALSE(box.cold);
  EXPECT_LT(box.fraction, 0.2);
  EXPECT_LT(box.expected_ratio, 1);
  const Joining gauss = joining_for(scalars_under("\"gauss\", sigma = 1.0", "400"), 0.089);
  EXPECT_TRUE(gauss.cold);
  EXPECT_GT(gauss.expected_ratio, 1.1);
}

TEST(Joining, IsTheSameOnAnyThreads) {
  const RunConfig config = scalars_under("\"binomial\", n = 2", "1500");
  EXPECT_EQ(joining_for(config, 0.163, 1).expected_ratio, joining_for(config, 0.163, 3).expected_ratio);
}

TEST(Joining, ThinsAListOfTheUsers) {
  RunConfig config = scalars_under("\"gauss\", sigma = 1.0", "400", "{ file = \"none.npy\" }");
  std::vector<float> values(64 * 64);
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = static_cast<float>(k);
  config.problem.samples.array = std::make_shared<const InputArray>(InputArray{{64 * 64}, std::move(values)});
  EXPECT_GT(joining_for(config, 0.089).expected_ratio, 1.1);
}

// A file may say what each slice has. What the first one has tells nothing of the others.
TEST(Joining, ThinsTheListsOfAllSlices) {
  const auto expected_ratio = [](std::size_t odd_slice) {
    RunConfig config = scalars_under("\"gauss\", sigma = 1.0", "400", "{ file = \"none.npy\" }");
    config.problem.extents = Extents({64, 64, 4});
    std::vector<float> values(4 * 64 * 64);
    for (std::size_t k = 0; k < values.size(); ++k) {
      values[k] = k / (64 * 64) == odd_slice ? 1 : static_cast<float>(k % (64 * 64));
    }
    config.problem.samples.array = std::make_shared<const InputArray>(InputArray{{4, 64, 64}, std::move(values)});
    return joining_for(config, 0.089).expected_ratio;
  };
  EXPECT_NEAR(expected_ratio(0), expected_ratio(3), 0.1);
}

TEST(Joining, IsGivenUpWhereItIsStopped) {
  const RunConfig config = scalars_under("\"gauss\", sigma = 1.0", "400");
  const SampleSource source(config.problem.samples, 64 * 64, 1, 1);
  ThreadPool pool(1);
  int looks = 0;
  const JoiningQuestion question{.given_error = 0.089, .is_stopped = [&] { return ++looks == 3; }};
  EXPECT_THROW(find_joining(config, source, question, pool), TrialsStopped);
  EXPECT_EQ(looks, 3);
}

}  // namespace
}  // namespace noiseloom
