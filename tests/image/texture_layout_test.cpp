// Slices that lie in rows and atlases, in several files, or in the datasets of a run file.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "image/texture_readings.h"
#include "noiseloom/image/image_io.h"
#include "noiseloom/image/texture_file.h"

namespace noiseloom {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

int tile_code(int x, int y, int slice) { return (7 * x + 31 * y + 83 * slice) % 256; }

void expect_tiles(const Texture& texture) {
  const int width = static_cast<int>(texture.extents.width());
  const int height = static_cast<int>(texture.extents.height());
  for (const SliceIndex s : texture.extents.slices())
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        ASSERT_FLOAT_EQ(texture.slice(s)[y * width + x], static_cast<float>((tile_code(x, y, s.value()) + 0.5) / 256))
            << s << " " << x << " " << y;
}

TEST(Layout, RowsAndAtlasesAreFoundFromTheSize) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("uniform", "x = 5, y = 3, t = 6");
  write_codes(folder / "row.png", 30, 3, 1, [](int x, int y, int) { return tile_code(x % 5, y, x / 5); });
  expect_tiles(load_texture(folder / "row.png", config).texture);
  write_codes(folder / "atlas.png", 15, 6, 1,
              [](int x, int y, int) { return tile_code(x % 5, y % 3, x / 5 + 3 * (y / 3)); });
  const TextureFile atlas = load_texture(folder / "atlas.png", config);
  expect_tiles(atlas.texture);
  EXPECT_THAT(atlas.notes, Contains(HasSubstr("left to right, then down (atlas:3x2)")));
  write_codes(folder / "down.png", 15, 6, 1,
              [](int x, int y, int) { return tile_code(x % 5, y % 3, y / 3 + 2 * (x / 5)); });
  expect_tiles(load_texture(folder / "down.png", config, {.layout = "atlas-down:3x2"}).texture);
  EXPECT_THAT(error_of(folder / "row.png", config, {.layout = "strip"}),
              HasSubstr("30 x 3 pixels, but the config says"));
  for (const char* const layout : {"atlas", "atlas:3", "atlas:3x", "atlas:0x2", "rows", "atlas:3x2x1"})
    EXPECT_THAT(error_of(folder / "row.png", config, {.layout = layout}), HasSubstr("--layout")) << layout;
}

TEST(Layout, AnAtlasMayHavePlacesLeft) {
  const TemporaryFolder folder;
  write_codes(folder / "atlas.png", 15, 6, 1,
              [](int x, int y, int) { return tile_code(x % 5, y % 3, x / 5 + 3 * (y / 3)); });
  const RunConfig config = small_config("uniform", "x = 5, y = 3, t = 5");
  EXPECT_THAT(error_of(folder / "atlas.png", config),
              AllOf(HasSubstr("the first 5 of 6 cells"), HasSubstr("--layout atlas:3x2")));
  expect_tiles(load_texture(folder / "atlas.png", config, {.layout = "atlas:3x2"}).texture);
}

TEST(Layout, OfAnUnknownSizeIsAskedForWhereTwoFit) {
  const TemporaryFolder folder;
  write_codes(folder / "wide.png", 12, 4, 1, [](int x, int y, int) { return tile_code(x, y, 0); });
  EXPECT_THAT(user_error_of([&] { suggested_extents(folder / "wide.png", 1, {}); }),
              AllOf(HasSubstr("--layout image"), HasSubstr("3 slices of 4 x 4"), HasSubstr("--layout row")));
  EXPECT_EQ(suggested_extents(folder / "wide.png", 1, {.layout = "image"}), Extents({12, 4}));
  EXPECT_EQ(suggested_extents(folder / "wide.png", 1, {.layout = "row"}), Extents({4, 4, 3}));
  EXPECT_EQ(suggested_extents(folder / "wide.png", 1, {.layout = "atlas:3x2"}), Extents({4, 2, 6}));
  write_codes(folder / "tall.png", 4, 12, 1, [](int x, int y, int) { return tile_code(x, y, 0); });
  EXPECT_EQ(suggested_extents(folder / "tall.png", 1, {}), Extents({4, 4, 3}));
}

TEST(Mates, OfAnotherSizeAreRefusedLargerOnesToo) {
  const TemporaryFolder folder;
  const auto code = [](int x, int y, int) { return tile_code(x, y, 0); };
  const RunConfig config = small_config("uniform", "x = 5, y = 3, t = 3");
  for (const auto& [width, height] : {std::pair{5, 4}, {6, 3}, {5, 2}}) {
    for (int s = 0; s < 3; ++s) write_codes(folder / fmt::format("n{}.png", s), 5, s == 1 ? height : 3, 1, code);
    write_codes(folder / "n1.png", width, height, 1, code);
    EXPECT_THAT(
        error_of(folder.path(), config),
        AllOf(HasSubstr("n1.png"), HasSubstr(fmt::format("{} x {} pixels", width, height)), HasSubstr("5 x 3 pixels")));
  }
}

TEST(Mates, AGapIsNamed) {
  const TemporaryFolder folder;
  const auto code = [](int x, int y, int) { return tile_code(x, y, 0); };
  const RunConfig config = small_config("uniform", "x = 5, y = 3, t = 6");
  for (const int s : {0, 1, 3, 4, 5}) write_codes(folder / fmt::format("n_{}.png", s), 5, 3, 1, code);
  EXPECT_THAT(error_of(folder / "n_0.png", config),
              AllOf(HasSubstr("number 2 is missing, but 3 to 5 are there"), HasSubstr("6 slices of 5 x 3")));
  EXPECT_THAT(error_of(folder / "n_{}.png", config), HasSubstr("number 2 is missing"));
}

TEST(Mates, AreFoundByTheNumberThatHasThem) {
  const TemporaryFolder folder;
  for (int s = 0; s < 4; ++s)
    write_codes(folder / fmt::format("f_{}.0.png", s), 5, 3, 1, [s](int x, int y, int) { return tile_code(x, y, s); });
  write_codes(folder / "f_0.1.png", 5, 3, 1, [](int, int, int) { return 1; });
  expect_tiles(load_texture(folder / "f_0.0.png", small_config("uniform", "x = 5, y = 3, t = 4")).texture);
  EXPECT_THAT(
      error_of(folder / "f_0.0.png", small_config("uniform", "x = 5, y = 3, t = 9")),
      AllOf(HasSubstr("2 images as"), HasSubstr("f_0.{}.png"), HasSubstr("4 images as"), HasSubstr("f_{}.0.png")));
}

TEST(RunFiles, TakeAFilterOfOtherSizesByTheNamesOfItsAxes) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("uniform", "x = 11, y = 7, z = 2, t = 3");
  write_run_file(folder / "run.h5", config, start_texture(config));
  const RunConfig other = parse_config(
      "[texture]\nsize = { x = 64, y = 64, t = 5 }\nsamples = \"uniform\"\n[filter]\n"
      "groups = [ { axes = \"yt\", kernel = \"box\", size = 3 } ]\n",
      "other.toml", "", {});
  EXPECT_THAT(load_texture(folder / "run.h5", other).config->problem.filter.groups[0].axes, ElementsAre(1, 3));
  const RunConfig foreign = parse_config(
      "[texture]\nsize = { x = 64, y = 64, w = 5 }\nsamples = \"uniform\"\n[filter]\n"
      "groups = [ { axes = \"xw\", kernel = \"box\", size = 3 } ]\n",
      "other.toml", "", {});
  EXPECT_THAT(error_of(folder / "run.h5", foreign), AllOf(HasSubstr("axis w"), HasSubstr("x, y, z, t")));
}

TEST(RunFiles, AreReadAsArraysByTheNamesOfTheirDatasets) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("vector2");
  const Texture texture = start_texture(config);
  write_run_file(folder / "run.h5", config, texture);
  const TextureFile file = load_texture(folder / "run.h5:/samples", config);
  EXPECT_EQ(file.source, "HDF5 dataset");
  EXPECT_EQ(file.texture.values, texture.values);
  EXPECT_THAT(error_of(folder / "run.h5:/none", config), HasSubstr("/samples (3 x 7 x 11 x 2)"));
}

}  // namespace
}  // namespace noiseloom
