#include "noiseloom/run/plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "noiseloom/anneal/swap_choices.h"
#include "noiseloom/dist/halo_plan.h"
#include "run/plans/plan_filter.h"
#include "support/mpi_session.h"

namespace noiseloom {
namespace {

using testing::HasSubstr;

const char* const gauss_xy = R"({ axes = "xy", kernel = "gauss", sigma = 1.0 })";
const char* const ema_t = R"({ axes = "t", kernel = "ema", alpha = 0.1, rejection = 0.1 })";
const char* const box_t = R"({ axes = "t", kernel = "box", size = 5 })";

RunConfig config_of(const std::string& size, const std::vector<std::string>& groups,
                    const std::string& combine = "product", const std::vector<std::string>& overrides = {},
                    const std::string& samples = "\"uniform\"") {
  std::string list;
  for (const std::string& group : groups) list += (list.empty() ? "" : ", ") + group;
  const std::string text = "[texture]\nsize = { " + size + " }\nsamples = " + samples + "\n[filter]\ncombine = \"" +
                           combine + "\"\ngroups = [ " + list +
                           " ]\n[optimizer]\nmethod = \"anneal\"\nstop = { iterations = 1000 }\n";
  return parse_config(text, "test.toml", "", overrides);
}

double peak_mib_of_this_process() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

// Whatever is planned: no work and no memory of the size that it forecasts.
TEST(Plan, AnswersForTexturesThatNobodyCouldMakeHere) {
  const double before_mib = peak_mib_of_this_process();
  std::vector<RunConfig> configs;
  for (const char* size : {"x = 65536, y = 65535", "x = 32768, y = 32768, t = 1024"}) {
    for (const char* method : {"anneal", "fast"}) {
      configs.push_back(config_of(size, {gauss_xy}, "product", {std::string("optimizer.method=") + method}));
    }
  }
  for (const char* along : {ema_t, box_t}) {
    for (const char* combine : {"product", "sum"}) {
      configs.push_back(config_of("x = 128, y = 128, t = 1000000", {gauss_xy, along}, combine));
    }
  }
  configs.push_back(config_of("x = 65536, y = 65535", {gauss_xy}, "product", {}, "\"sphere\""));
  int ranks = 1;
  for (const RunConfig& config : configs) {
    const RunPlan plan = plan_run(config, {.ranks = ranks});
    const double texture = 8.0 * static_cast<double>(config.problem.extents.num_cells());
    EXPECT_GT(plan.node_bytes, texture) << plan.texture << " on " << ranks;
    EXPECT_GT(plan.run_file_bytes, texture);
    EXPECT_EQ(plan.disk_bytes, 3 * plan.run_file_bytes);
    EXPECT_TRUE(std::isfinite(plan.time.total()));
    EXPECT_GT(plan.time.total(), 100) << plan.texture;
    ranks = ranks == 1 ? 512 : 1;
  }
  EXPECT_LT(peak_mib_of_this_process() - before_mib, 400);
}

// The outline of a filter with many taps against the list of them all.
void expect_outline(const RunConfig& config, double cutoff) {
  const Extents& extents = config.problem.extents;
  const FilterOutline outline = outline_of(extents, config.problem.filter, cutoff);
  ASSERT_FALSE(outline.is_counted);
  const Footprint footprint(extents, config.problem.filter, cutoff);
  EXPECT_EQ(outline.num_taps, footprint.num_taps());
  EXPECT_EQ(outline.own_taps, std::ssize(footprint.slices()[0].taps));
  EXPECT_EQ(outline.num_coupled_slices(), std::ssize(footprint.slices()) - 1);
  EXPECT_EQ(outline.is_product, footprint.factors().has_value());
  for (int axis = 0; axis < extents.num_axes(); ++axis) {
    EXPECT_EQ((axis < 2 ? outline.plane : outline.slices).reach(axis), footprint.reach(axis)) << axis;
  }
  EXPECT_EQ(classes_for(Method::anneal, outline.slices), classes_for(Method::anneal, footprint));
}

TEST(FilterOutline, OfAProductIsThatOfAllItsTaps) {
  const char* const wide = R"({ axes = "xy", kernel = "gauss", sigma = 2.0 })";
  expect_outline(config_of("x = 101, y = 97, t = 1009", {wide, ema_t}), 0);
  expect_outline(config_of("x = 101, y = 97, t = 1009", {wide, ema_t}), 1e-3);
  expect_outline(config_of("x = 101, y = 97, t = 53, z = 47", {R"({ axes = "xyt", kernel = "box", size = 17 })",
                                                               R"({ axes = "z", kernel = "box", size = 8 })"}),
                 0);
}

TEST(FilterOutline, OfFewTapsIsTheirList) {
  const RunConfig config = config_of("x = 33, y = 31, t = 7", {gauss_xy, ema_t}, "sum");
  const FilterOutline outline = outline_of(config.problem.extents, config.problem.filter, 0);
  EXPECT_TRUE(outline.is_counted);
  EXPECT_TRUE(outline.same_pixel_only);
  EXPECT_EQ(outline.num_taps, Footprint(config.problem.extents, config.problem.filter).num_taps());
}

TEST(Plan, RanksThatAreLookedAtStandForAll) {
  const RunConfig config = config_of("x = 8, y = 8, t = 960", {gauss_xy, box_t});
  const RunPlan plan = plan_run(config, {.ranks = 240});
  EXPECT_LT(plan.ranks.size(), 100U);
  const Footprint footprint(config.problem.extents, config.problem.filter);
  std::vector<Extents::SliceCoord> offsets;
  for (const SliceTaps& slice : footprint.slices()) offsets.push_back(slice.offset);
  const Partition partition(960, 240);
  std::int64_t updates = 0;
  for (const Rank rank : first_indices<Rank>(240)) {
    updates += HaloPlan(config.problem.extents, offsets, {partition, rank}).messages_per_sweep();
  }
  EXPECT_EQ(plan.exchange.slice_updates, static_cast<double>(updates));
}

TEST(Plan, MemoryFollowsRanksThreadsAndNodes) {
  const RunConfig config = config_of("x = 512, y = 512, t = 64", {gauss_xy, ema_t});
  const RunPlan alone = plan_run(config, {});
  const RunPlan many = plan_run(config, {.ranks = 8, .threads = 1, .ranks_per_node = 4});
  const RunPlan threads = plan_run(config, {.ranks = 1, .threads = 8});
  EXPECT_LT(many.most.texture, alone.most.texture / 7);
  EXPECT_GT(many.most.halo, 0);
  EXPECT_EQ(alone.most.halo, 0);
  EXPECT_GT(threads.most.threads, 7 * alone.most.threads);
  EXPECT_GT(many.node_bytes, 2.5 * many.most.peak());  // the first rank needs more
  EXPECT_LE(many.node_bytes, 4 * many.most.peak());
  EXPECT_EQ(alone.node_bytes, alone.most.peak());
}

TEST(Plan, TimeCountsThreadsAndScores) {
  const RunConfig config = config_of("x = 64, y = 64, t = 32", {gauss_xy, box_t}, "product", {}, "\"sphere\"");
  const RunPlan one = plan_run(config, {});
  const RunPlan four = plan_run(config, {.ranks = 1, .threads = 4});
  EXPECT_LT(four.time.moves, 0.5 * one.time.moves);
  // Mean distance of 131072 directions: 8e8 pairs, each a part of a nanosecond at least; and R once.
  EXPECT_GT(one.time.start, 0.05);
  EXPECT_GT(one.time.num_scores, 0);
  EXPECT_GT(one.time.scores, 0);
  EXPECT_GT(one.time.score_s, 0);
}

TEST(Plan, NamesWhatIsOnAndOff) {
  const auto is_on = [](const RunPlan& plan, const std::string& name) {
    const auto found = std::find_if(plan.effects.begin(), plan.effects.end(),
                                    [&](const PlanEffect& effect) { return effect.name == name; });
    EXPECT_NE(found, plan.effects.end()) << name;
    return found != plan.effects.end() && found->on;
  };
  const RunPlan product = plan_run(config_of("x = 64, y = 64, t = 8", {gauss_xy, ema_t}), {});
  EXPECT_TRUE(is_on(product, "features"));
  EXPECT_TRUE(is_on(product, "coupled slices"));
  EXPECT_FALSE(is_on(product, "tiles"));
  EXPECT_FALSE(is_on(product, "sieve"));
  EXPECT_EQ(product.features.size(), 3U);
  const RunPlan vectors = plan_run(
      config_of("x = 64, y = 64, t = 8", {gauss_xy, ema_t}, "product", {"optimizer.sieve_features=16"}, "\"vector2\""),
      {});
  EXPECT_TRUE(is_on(vectors, "sieve"));
  const RunPlan judged = plan_run(
      config_of("x = 64, y = 64, t = 8", {gauss_xy, ema_t}, "product", {"optimizer.sieve_features=0"}, "\"vector2\""),
      {});
  EXPECT_FALSE(is_on(judged, "sieve"));
  // Features and pulls of 16 floats a cell.
  EXPECT_GT(vectors.most.threads, judged.most.threads + 2 * 16 * 4 * 64 * 64);
  const RunPlan plane = plan_run(config_of("x = 512, y = 512", {gauss_xy}, "product", {}, "\"tent\""), {});
  EXPECT_FALSE(is_on(plane, "features"));
  EXPECT_FALSE(is_on(plane, "coupled slices"));
  EXPECT_TRUE(is_on(plane, "tiles"));
  EXPECT_TRUE(is_on(plane, "density"));
}

TEST(Plan, OfAnOrderCountsItsPhases) {
  const RunConfig config = config_of("x = 8192, y = 8192", {R"({ axes = "xy", kernel = "gauss-energy", sigma = 1.9 })"},
                                     "sum", {"optimizer={method=\"void-and-cluster\",density=0.1}"});
  const RunPlan plan = plan_run(config, {.ranks = 2});
  EXPECT_EQ(plan.method, "void-and-cluster");
  EXPECT_EQ(plan.phases.points, std::floor(0.1 * 8192 * 8192));
  EXPECT_GT(plan.most.peak(), 8.0 * 8192 * 8192);
  EXPECT_GT(plan.time.total(), 1);
  EXPECT_EQ(plan.idle_ranks, 1);
}

// 0.29 x 100 is 28.999999999999996 in double: the run counts in decimals, and the plan as the run does.
TEST(Plan, OfAnOrderCountsTheSameStartPoints) {
  const RunConfig config = config_of("x = 10, y = 10", {R"({ axes = "xy", kernel = "gauss-energy", sigma = 1.0 })"},
                                     "sum", {"optimizer={method=\"void-and-cluster\",density=0.29}"});
  EXPECT_EQ(plan_run(config, {}).phases.points, 29);
}

// tests/bench/plan_memory.py measures the same of whole runs.
TEST(Plan, OfAConstructionHoldsPlacesAndSamplesOfWhatCountsWhenItIsScored) {
  const RunConfig config = config_of("x = 64, y = 32, t = 128", {gauss_xy, ema_t}, "product",
                                     {"optimizer={method=\"construct\",sharpness=1}"});
  const PlanMemory memory = plan_run(config, {}).most;
  EXPECT_EQ(memory.at_score, 4.0 * 64 * 32 * (2 * 128 + 2));
  EXPECT_EQ(memory.at_save, 12.0 * 64 * 32);
}

// Trials are of the whole of a texture that is as small as theirs; where the temperature is given there are none.
TEST(Plan, CountsTheTrialsThatAnArrangementIsAnnealedAfter) {
  const auto planned = [](const std::string& temperature) {
    return plan_run(
               config_of("x = 32, y = 32, t = 64", {gauss_xy, ema_t}, "product",
                         {"optimizer={method=\"construct\",sharpness=1,stop={iterations=100}" + temperature + "}"}),
               {})
        .most;
  };
  const PlanMemory with_trials = planned("");
  const PlanMemory without = planned(",temperature={start=0.01,end=0.001}");
  EXPECT_GT(with_trials.at_start, without.at_start);
  EXPECT_GE(with_trials.at_start, with_trials.texture + with_trials.filter);
}

TEST(Plan, RefusesAllThatMakesNoSenseAtOnce) {
  try {
    plan_run(config_of("x = 8, y = 8", {gauss_xy}), {.ranks = 0, .threads = -1, .ranks_per_node = -2});
    FAIL() << "accepted";
  } catch (const UserError& error) {
    EXPECT_THAT(error.what(), HasSubstr("--ranks 0"));
    EXPECT_THAT(error.what(), HasSubstr("--threads -1"));
    EXPECT_THAT(error.what(), HasSubstr("--ranks-per-node -2"));
  }
}

}  // namespace
}  // namespace noiseloom
