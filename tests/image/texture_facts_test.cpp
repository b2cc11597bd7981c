// Images and textures that were exported here say themselves what they hold.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "image/texture_readings.h"
#include "noiseloom/image/export.h"
#include "noiseloom/image/texture_file.h"

namespace noiseloom {
namespace {

using testing::HasSubstr;

class OwnExports : public testing::Test {
 protected:
  // The files of an export of five slices of 6 x 4.
  std::vector<std::string> exported(const std::string& samples, ExportOptions options) {
    config_ = small_config(samples, "x = 6, y = 4, t = 5");
    texture_ = start_texture(config_);
    write_run_file(folder_ / "run.h5", config_, texture_, true);
    options.overwrite = true;
    options.output = folder_ / options.output;
    return export_run_file(folder_ / "run.h5", options, posix_file_ops()).files;
  }

  const TemporaryFolder folder_;
  RunConfig config_;
  Texture texture_;
};

TEST_F(OwnExports, AreReadWithoutAConfig) {
  struct Case {
    const char* output;
    const char* layout;
    const char* depth;
  };
  // Six cells for five slices; a row and a column; a file a slice; parts; layers.
  const std::vector<Case> cases = {
      {"a.png", "atlas:3x2", "8"},       {"a.png", "row", "16"},       {"a.png", "strip", "8"},
      {"s_{}.png", "slices", "8"},       {"a.exr", "strip", "32f"},    {"a.exr", "atlas:2x3", "16f"},
      {"p.exr", "exr-multipart", "32f"}, {"a.tif", "atlas:3x2", "16"}, {"a.tif", "strip", "32f"},
      {"a.ktx2", "array", "8"},          {"v.ktx2", "volume", "16f"},  {"s_{}.ktx2", "slices", "16"}};
  for (const char* const samples : {"hemisphere-cosine", "uniform"})
    for (const Case& one : cases) {
      SCOPED_TRACE(fmt::format("{} {} {} {}", samples, one.output, one.layout, one.depth));
      ExportOptions options;
      options.output = one.output;
      options.layout = one.layout;
      options.depth = one.depth;
      const std::vector<std::string> files = exported(samples, options);
      const TextureFile file = load_texture(files.front(), std::nullopt);
      ASSERT_TRUE(file.config);
      EXPECT_EQ(to_toml(*file.config), to_toml(config_));
      EXPECT_LT(largest_difference(file.texture, texture_), one.depth == std::string("8") ? 1.01 / 128 : 1e-3);
      EXPECT_EQ(suggested_extents(files.front(), 0, {}), config_.problem.extents);
    }
}

TEST_F(OwnExports, SayTheRangeOfUnboundedSamples) {
  ExportOptions options;
  options.output = "a.png";
  options.layout = "strip";
  options.depth = "16";
  options.range = "-8:8";
  const std::vector<std::string> files = exported("gauss", options);
  EXPECT_LT(largest_difference(load_texture(files.front(), std::nullopt).texture, texture_), 16.1 / 65536);
  EXPECT_LT(largest_difference(load_texture(files.front(), config_).texture, texture_), 16.1 / 65536);
}

TEST_F(OwnExports, SayWhichSlicesTheyHold) {
  ExportOptions options;
  options.output = "a.png";
  options.layout = "strip";
  options.slices = "1:4";
  const TextureFile file = load_texture(exported("uniform", options).front(), std::nullopt);
  ASSERT_TRUE(file.config);
  EXPECT_EQ(file.config->problem.extents, Extents({6, 4, 3}));
  for (std::size_t i = 0; i < file.texture.values.size(); ++i)
    EXPECT_NEAR(file.texture.values[i], texture_.values[i + texture_.floats_per_slice()], 1.0 / 256);
}

TEST_F(OwnExports, AreChangedByOverrides) {
  ExportOptions options;
  options.output = "a.png";
  options.layout = "strip";
  const std::string path = exported("uniform", options).front();
  const auto config = config_in_images(path, {"filter.groups[0].size=5"});
  ASSERT_TRUE(config);
  EXPECT_EQ(config->problem.filter.groups[0].kernel.size, 5);
  EXPECT_EQ(config->problem.extents, config_.problem.extents);
}

// An image that was cropped keeps what it said of itself.
TEST_F(OwnExports, ThatWereCroppedAreLookedAtAsTheyAre) {
  for (const char* const layout : {"strip", "slices"}) {
    SCOPED_TRACE(layout);
    ImageJob job;
    job.facts = {{"layout", layout}, {"slices", "0:2"}, {"range", "0:1"}};
    job.facts.emplace_back("config", to_toml(small_config("uniform", "x = 8, y = 8, t = 2")));
    job.block = {5, 5, 1, PixelType::uint8, {}, -1};
    const std::vector<std::byte> bytes(25);
    for (const char* const name : {"c_0.png", "c_1.png"})
      write_image(folder_ / name, job, [&](int) { return std::span<const std::byte>(bytes); });
    const std::string path = layout == std::string("strip") ? folder_ / "c_0.png" : folder_ / "c_{}.png";
    const StoredTexture stored = load_stored_texture(path, std::nullopt, {});
    EXPECT_FALSE(stored.config);
    EXPECT_EQ(stored.texture.extents.num_cells(), layout == std::string("strip") ? 25 : 50);
    EXPECT_THAT(stored.notes, testing::Contains(HasSubstr("cropped")));
    EXPECT_EQ(suggested_extents(path, 1, {}), stored.texture.extents);
    EXPECT_THAT(user_error_of([&] { load_texture(path, std::nullopt); }), HasSubstr("the config is that in the file"));
  }
}

TEST_F(OwnExports, OfDensitiesAndFramesAreNoSamples) {
  ExportOptions density;
  density.output = "a.png";
  density.layout = "strip";
  density.density = "separate";
  const std::vector<std::string> both = exported("uniform", density);
  ASSERT_EQ(both.size(), 2U);
  EXPECT_TRUE(config_in_images(both[0], {}));
  EXPECT_FALSE(config_in_images(both[1], {}));
  ExportOptions frames;
  frames.output = "f.ktx2";
  frames.frames = "7";
  EXPECT_FALSE(config_in_images(exported("uniform", frames).front(), {}));
}

TEST(OwnFacts, ThatMakeNoSenseAreTold) {
  const TemporaryFolder folder;
  const std::vector<std::byte> bytes(12);
  ImageJob job;
  job.block = {4, 3, 1, PixelType::uint8, {}, -1};
  job.facts = {{"layout", "strip"}, {"slices", "0:1"}, {"range", "0:1"}, {"config", "[texture]\nsise = 3\n"}};
  const auto write = [&](const std::string& name) {
    write_image(folder / name, job, [&](int) { return std::span<const std::byte>(bytes); });
    return folder / name;
  };
  const std::string path = write("a.png");
  EXPECT_THAT(user_error_of([&] { load_texture(path, std::nullopt); }), HasSubstr("a.png: the config in it"));
  EXPECT_NO_THROW(load_texture(path, small_config("uniform", "x = 4, y = 3")));
  // Another size than that of the image, and one that no memory holds.
  for (const char* const size : {"x = 4, y = 4", "x = 32768, y = 32768, t = 32768"}) {
    job.facts.back().second = to_toml(small_config("uniform", size));
    EXPECT_THAT(user_error_of([&] { load_texture(write(fmt::format("b{}.png", size[8])), std::nullopt); }),
                HasSubstr("4 x 3 pixels, but the config says"));
  }
  for (const char* const slices : {"", "1", "2:1", "0:x", "-1:1"}) {
    job.facts[1].second = slices;
    EXPECT_FALSE(config_in_images(
        write(fmt::format("c{}.png", std::string(slices).size() * 7 + static_cast<unsigned char>(slices[0]))), {}));
  }
}

}  // namespace
}  // namespace noiseloom
