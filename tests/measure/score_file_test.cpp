// R of files: published textures, and the same texture in every form.
#include "noiseloom/measure/score_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>
#include <tuple>

#include "noiseloom/image/naming.h"
#include "support/run_files.h"
#include "support/sanitizers.h"

namespace noiseloom {
namespace {

using testing::HasSubstr;

RunConfig config_of(const std::string& size, const std::string& samples, const std::string& groups) {
  return parse_config("[texture]\nsize = { " + size + " }\nsamples = \"" + samples +
                          "\"\n[filter]\ncombine = \"product\"\ngroups = [ " + groups + " ]\n",
                      "test.toml", "", {});
}

double score_of(const Texture& texture, const RunConfig& config) {
  ThreadPool pool(2);
  return score_texture(texture, distance_kind(config.problem.samples, texture.channels), config.problem.filter, {},
                       pool)
      .relative_error;
}

struct Published {
  const char* file;
  const char* size;
  const char* samples;
  const char* groups;
  double relative_error;
  double tolerance;
};

class PublishedTexture : public testing::TestWithParam<Published> {};

// What an independent program found for the textures that come with [FAST24].
TEST_P(PublishedTexture, HasTheKnownScore) {
  const std::string folder = published_folder();
  if (folder.empty()) GTEST_SKIP() << "the published textures are not there (NOISELOOM_PUBLISHED names their folder)";
  const Published& p = GetParam();
  if (testing_support::under_sanitizers && std::string(p.size).find("t =") != std::string::npos) {
    GTEST_SKIP() << "64 slices take two minutes under sanitizers";
  }
  const RunConfig config = config_of(p.size, p.samples, p.groups);
  const TextureFile file = load_texture(folder + "/" + p.file, config);
  EXPECT_NEAR(score_of(file.texture, config), p.relative_error, p.tolerance);
}

INSTANTIATE_TEST_SUITE_P(
    FAST24, PublishedTexture,
    testing::Values(Published{"real_uniform_box_5.png", "x = 128, y = 128", "uniform",
                              "{ axes = \"xy\", kernel = \"box\", size = 5 }", 0.1110, 0.0002},
                    Published{"real_uniform_gauss_1.0.png", "x = 128, y = 128", "uniform",
                              "{ axes = \"xy\", kernel = \"gauss\", sigma = 1.0 }", 0.1221, 0.0002},
                    Published{"vector2_uniform_gauss_1.0.png", "x = 128, y = 128", "vector2",
                              "{ axes = \"xy\", kernel = \"gauss\", sigma = 1.0 }", 0.2263, 0.0002},
                    Published{"sphere_cosine_box_5.png", "x = 128, y = 128", "hemisphere-cosine",
                              "{ axes = \"xy\", kernel = \"box\", size = 5 }", 0.3150, 0.0005},
                    Published{"real_uniform_gauss_1.3435_exponential_0.1_0.1_product.png", "x = 128, y = 128, t = 64",
                              "uniform",
                              "{ axes = \"xy\", kernel = \"gauss\", sigma = 1.3435 }, "
                              "{ axes = \"t\", kernel = \"ema\", alpha = 0.1, rejection = 0.1 }",
                              0.0840, 0.0001}));

TEST(Score, OfPublishedTexturesIsFoundByTheNamesOfTheirFilters) {
  for (const auto& [samples, groups, expected] :
       {std::tuple{"uniform", "{ axes = \"xy\", kernel = \"gauss\", sigma = 1.0 }", 0.1221},
        {"vector2", "{ axes = \"xy\", kernel = \"gauss\", sigma = 1.0 }", 0.2263},
        {"hemisphere-cosine", "{ axes = \"xy\", kernel = \"box\", size = 5 }", 0.3150},
        {"uniform",
         "{ axes = \"xy\", kernel = \"gauss\", sigma = 1.3435 }, { axes = \"t\", kernel = \"ema\", alpha = 0.1 }",
         0.0840}}) {
    const RunConfig config = config_of("x = 16, y = 16, t = 4", samples, groups);
    const auto published =
        published_score(config.problem.samples, describe_filter(config.problem.extents, config.problem.filter));
    ASSERT_TRUE(published) << samples << " " << groups;
    EXPECT_EQ(*published, expected);
  }
  EXPECT_FALSE(published_score(small_config("tent").problem.samples, "gauss 1 over xy"));
  SampleSpec vectors = small_config("vector2").problem.samples;
  EXPECT_TRUE(published_score(vectors, "gauss 1 over xy"));
  vectors.compared_by = ComparedBy::manhattan;
  EXPECT_FALSE(published_score(vectors, "gauss 1 over xy")) << "R of another distance";
}

TEST(Score, IsOneForWhiteNoiseAndTheMeanOfItsSlices) {
  const RunConfig config =
      config_of("x = 61, y = 53, t = 5", "uniform",
                "{ axes = \"xy\", kernel = \"box\", size = 3 }, { axes = \"t\", kernel = \"ema\", alpha = 0.1 }");
  const Texture texture = start_texture(config);
  ThreadPool pool(2);
  const TextureScore score =
      score_texture(texture, DistanceKind::absolute, config.problem.filter, standard_filters(texture.extents), pool);
  EXPECT_NEAR(score.relative_error, 1, 0.05);  // one standard error is about 0.01
  EXPECT_TRUE(score.exact);
  ASSERT_EQ(score.per_slice.size(), 5U);
  EXPECT_NEAR(std::accumulate(score.per_slice.begin(), score.per_slice.end(), 0.0) / 5, score.relative_error, 1e-12);
  ASSERT_EQ(score.others.size(), 5U);
  EXPECT_EQ(score.others[0].filter, "box 3 over xy");
  EXPECT_EQ(score.others[4].filter, "ema 0.1 (rejection 0.1) over t");
}

TEST(Score, DoesNotDependOnTheUnitOfScalars) {
  const RunConfig config = small_config("uniform");
  Texture texture = start_texture(config);
  const double before = score_of(texture, config);
  for (float& v : texture.values) v = 8 * v - 3;
  EXPECT_NEAR(score_of(texture, config), before, 1e-6);
}

TEST(Score, RefusesATextureOfEqualValues) {
  const RunConfig config = small_config("uniform");
  Texture texture = make_texture(config.problem.extents, 1);
  EXPECT_THAT(user_error_of([&] { score_of(texture, config); }), HasSubstr("all values of the texture are equal"));
}

TEST(DescribeFilter, SaysWhatTheConfigSays) {
  const RunConfig config = config_of("x = 5, y = 3, t = 2", "uniform",
                                     "{ axes = \"xy\", kernel = \"gauss\", sigma = 1.5 }, "
                                     "{ axes = \"t\", kernel = \"ema\", alpha = 0.1, rejection = 0.2 }");
  EXPECT_EQ(describe_filter(config.problem.extents, config.problem.filter),
            "gauss 1.5 over xy x ema 0.1 (rejection 0.2) over t");
}

}  // namespace
}  // namespace noiseloom
