// The names of exported files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "noiseloom/image/export.h"
#include "support/run_files.h"

namespace noiseloom {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

ExportOptions options_into(const std::string& output) {
  ExportOptions options;
  options.output = output;
  return options;
}

TEST(ExportNames, NamesFilesByScheme) {
  const TemporaryFolder folder;
  const RunConfig config = parse_config(
      "[texture]\nsize = { x = 5, y = 3, t = 11 }\nsamples = \"vector2\"\n[filter]\ncombine = \"product\"\ngroups = [\n"
      "{ axes = \"xy\", kernel = \"gauss\", sigma = 1.0 }, { axes = \"t\", kernel = \"ema\", alpha = 0.1, rejection = "
      "0.25 } ]\n",
      "test.toml", "", {});
  RunFileContent content;
  content.extents = config.problem.extents;
  content.datasets = {{"/samples", ElementType::float32, 2, true}};
  const auto targets = [&](ExportOptions options) {
    options.slices = "9:11";
    return plan_export("folder/quick.h5", content, config.problem, options).outputs.front().targets;
  };
  ExportOptions options = options_into("out/");
  EXPECT_THAT(targets(options), ElementsAre("out/quick_09.png", "out/quick_10.png"));
  options.naming = "nvidia";
  EXPECT_EQ(targets(options)[1], "out/stbn_vec2_2Dx1D_5x3x11_10.png");
  options.naming = "ea";
  EXPECT_EQ(targets(options)[0], "out/vector2_uniform_gauss1_0_exp01025_product_9.png");
  options.layout = "strip";
  EXPECT_THAT(targets(options), ElementsAre("out/vector2_uniform_gauss1_0_exp01025_product.png"));
  options = options_into("out/");
  options.naming = "n{slice:03}";
  options.format = "tiff";
  EXPECT_EQ(targets(options)[0], "out/n009.tif");
  EXPECT_EQ(targets(options_into("out/frame-%d.exr"))[1], "out/frame-10.exr");
  EXPECT_EQ(targets(options_into("some.png"))[1], "some_10.png");
  options = options_into("out/some.tiff");
  options.layout = "strip";
  EXPECT_THAT(targets(options), ElementsAre("out/some.tiff"));
  options = options_into("out/SOME.PNG");
  EXPECT_EQ(targets(options)[1], "out/SOME_10.PNG");
}

// As renderers, tools of films, shells and printf write a number.
TEST(ExportNames, FillsEveryPatternThatIsRead) {
  RunFileContent content;
  content.extents = Extents({5, 3, 11});
  content.datasets = {{"/samples", ElementType::float32, 1, true}};
  const RunConfig config = small_config("uniform", "x = 5, y = 3, t = 11");
  const auto last = [&](const ExportOptions& options) {
    return plan_export("run.h5", content, config.problem, options).outputs.front().targets.back();
  };
  const std::pair<std::string, std::string> patterns[] = {
      {"{}", "10"}, {"{slice}", "10"}, {"{slice:03}", "010"}, {"{:04}", "0010"}, {"%d", "10"},   {"%i", "10"},
      {"%u", "10"}, {"%04d", "0010"},  {"%03i", "010"},       {"#", "10"},       {"###", "010"}, {"#####", "00010"}};
  for (const auto& [place, number] : patterns) {
    EXPECT_EQ(last(options_into("d#/a_" + place + "_z.png")), "d#/a_" + number + "_z.png");
    EXPECT_EQ(last(options_into("a." + place + ".EXR")), "a." + number + ".EXR");
    EXPECT_EQ(last(options_into("a_" + place)), "a_" + number + ".png") << "a name without an ending gets one";
    ExportOptions options = options_into("out/");
    options.naming = "b" + place;
    options.format = "tiff";
    EXPECT_EQ(last(options), "out/b" + number + ".tif");
    for (const std::string& one_file : {"c_" + place + ".npy", "c_" + place + ".raw"})
      EXPECT_THAT(user_error_of([&] { last(options_into(one_file)); }),
                  testing::AllOf(HasSubstr("-o " + one_file), HasSubstr("one file")));
  }
}

TEST(ExportNames, RefusesNamesThatOnlyLookLikePlacesForTheNumber) {
  RunFileContent content;
  content.extents = Extents({5, 3, 2});
  content.datasets = {{"/samples", ElementType::float32, 1, true}};
  const RunConfig config = small_config("uniform", "x = 5, y = 3, t = 2");
  for (const std::string name : {"a_*.png", "a_?.png", "a_%x.png", "a_{slcie}.png", "a_{}_{}.png", "%d_%d.exr",
                                 "{}_####.tif", "{}_*.png", "a_*/b.png", "a_@@@@.png", "a_$F4.exr", "a_<frame>.tif"}) {
    EXPECT_THAT(user_error_of([&] { plan_export("run.h5", content, config.problem, options_into(name)); }),
                testing::AllOf(HasSubstr(name), HasSubstr("accepted"), HasSubstr("{slice:03}"), HasSubstr("####")))
        << name;
    ExportOptions options = options_into("out/");
    options.naming = name;
    EXPECT_THAT(user_error_of([&] { plan_export("run.h5", content, config.problem, options); }), HasSubstr("accepted"))
        << name;
  }
  EXPECT_THAT(user_error_of([&] { plan_export("run.h5", content, config.problem, options_into("-")); }),
              HasSubstr("standard output"));
  EXPECT_THAT(user_error_of([&] { plan_export("run.h5", content, config.problem, options_into("x.h5")); }),
              HasSubstr("\".h5\" is no ending of a container that is written; accepted: png, exr, tiff"));
}

// The names that the published archives hold, each with the config that makes such a texture.
TEST(ExportNames, GivesTheNamesOfPublishedTextures) {
  struct Published {
    std::string naming;
    std::string samples;
    std::string size;
    std::string filter;
    bool has_order;
    std::string first;
  };
  const std::string stbn =
      "combine = \"sum\"\ngroups = [ { axes = \"xy\", kernel = \"gauss-energy\", sigma = 1.9 }, "
      "{ axes = \"t\", kernel = \"gauss-energy\", sigma = 1.9 } ]";
  const std::string gauss_ema =
      "groups = [ { axes = \"xy\", kernel = \"gauss\", sigma = 1.0 }, { axes = \"t\", kernel "
      "= \"ema\", alpha = 0.1, rejection = 0.1 } ]";
  const std::string volume = "x = 128, y = 128, t = 64";
  const std::string plane = "x = 128, y = 128";
  const auto over_xy = [](const std::string& kernel) {
    return "groups = [ { axes = \"xy\", kernel = " + kernel + " } ]";
  };
  const Published cases[] = {
      {"nvidia", "uniform", volume, stbn, true, "stbn_scalar_2Dx1Dx1D_128x128x64x1_0.png"},
      {"nvidia", "uniform", volume, stbn, false, "stbn_vec1_2Dx1D_128x128x64_0.png"},
      {"nvidia", "vector2", volume, stbn, false, "stbn_vec2_2Dx1D_128x128x64_0.png"},
      {"nvidia", "sphere", volume, stbn, false, "stbn_unitvec3_2Dx1D_128x128x64_0.png"},
      {"nvidia", "hemisphere-cosine", volume, stbn, false, "stbn_unitvec3_cosine_2Dx1D_128x128x64_0.png"},
      {"ea", "uniform", volume, "combine = \"sum\"\n" + gauss_ema, false,
       "real_uniform_gauss1_0_exp0101_separate05_0.png"},
      {"ea", "hemisphere-cosine", volume, "combine = \"product\"\n" + gauss_ema, false,
       "sphere_coshemi_gauss1_0_exp0101_product_0.png"},
      {"ea", "uniform", plane, over_xy("\"box\", size = 3"), false, "real_uniform_box3x3.png"},
      {"ea", "tent", plane, over_xy("\"box\", size = 5"), false, "real_tent_box5x5.png"},
      {"ea", "circle", plane, over_xy("\"gauss\", sigma = 1.0"), false, "circle_uniform_gauss1_0.png"},
      {"ea", "vector2", plane, over_xy("\"binomial\", n = 2"), false, "vector2_uniform_binomial3x3.png"},
      {"ea", "sphere", plane, over_xy("\"binomial\", n = 4"), false, "sphere_uniform_binomial5x5.png"},
  };
  for (const Published& c : cases) {
    const RunConfig config = parse_config(
        "[texture]\nsize = { " + c.size + " }\nsamples = \"" + c.samples + "\"\n[filter]\n" + c.filter + "\n",
        "test.toml", "", {});
    RunFileContent content;
    content.extents = config.problem.extents;
    content.datasets = {{"/samples", ElementType::float32, c.samples == "vector2" ? 2 : 1, true}};
    if (c.has_order) content.datasets.push_back({"/order", ElementType::uint32, 1, false});
    ExportOptions options = options_into("out/");
    options.naming = c.naming;
    EXPECT_EQ(plan_export("run.h5", content, config.problem, options).outputs.front().targets.front(),
              "out/" + c.first);
  }
}

}  // namespace
}  // namespace noiseloom
