#include "noiseloom/image/export_importance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "noiseloom/files/npy.h"
#include "noiseloom/image/image_reader.h"
#include "support/run_files.h"

namespace noiseloom {
namespace {

TEST(ExportImportance, SamplesWhereImportanceIsAboveTheMask) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("uniform");
  const Texture texture = start_texture(config);
  write_run_file(folder / "run.h5", config, texture);
  const auto width = static_cast<std::size_t>(texture.extents.width());
  const auto height = static_cast<std::size_t>(texture.extents.height());
  // A map that is larger than the mask, which then repeats.
  const std::size_t map_width = 2 * width + 3;
  const std::size_t map_height = height + 1;
  std::vector<float> map;
  for (std::size_t i = 0; i < map_width * map_height; ++i) map.push_back(static_cast<float>(i % 11) / 10);
  write_npy(folder / "map.npy",
            std::vector<std::int64_t>{static_cast<std::int64_t>(map_height), static_cast<std::int64_t>(map_width)},
            map);
  const ImportanceResult result = export_importance(
      folder / "run.h5", {.map = folder / "map.npy", .output = folder / "out", .frames = "2"}, posix_file_ops());
  ASSERT_EQ(result.images.size(), 2U);
  ASSERT_TRUE(std::filesystem::exists(folder / "out/coverage.csv"));
  std::vector<bool> seen(map.size(), false);
  for (const SliceIndex frame : first_indices<SliceIndex>(2)) {
    ImageReader reader(result.images[static_cast<std::size_t>(frame)]);
    std::vector<std::byte> bytes(reader.shape(0).num_bytes());
    reader.read_rows(0, 0, static_cast<int>(map_height), bytes);
    ASSERT_EQ(bytes.size(), map.size());
    for (std::size_t i = 0; i < map.size(); ++i) {
      const std::size_t cell = i / map_width % height * width + i % map_width % width;
      const bool sampled = map[i] > texture.slice(frame)[cell];
      ASSERT_EQ(bytes[i] == std::byte{255}, sampled);
      if (sampled) seen[i] = true;
    }
    const double share =
        static_cast<double>(std::count(seen.begin(), seen.end(), true)) / static_cast<double>(seen.size());
    EXPECT_DOUBLE_EQ(result.coverage[static_cast<std::size_t>(frame)].so_far, share);
  }
  // Importance 0 is never sampled, 1 always; white noise samples its share of the rest.
  EXPECT_LT(result.coverage[1].white, 10.0 / 11 + 1e-9);
  EXPECT_GT(result.coverage[1].white, result.coverage[0].white);
}

TEST(ExportImportance, RefusesWhatIsNoMaskAndNoMap) {
  const TemporaryFolder folder;
  const RunConfig vectors = small_config("vector2");
  write_run_file(folder / "vectors.h5", vectors, start_texture(vectors));
  const RunConfig scalars = small_config("uniform");
  write_run_file(folder / "scalars.h5", scalars, start_texture(scalars));
  write_npy(folder / "map.npy", std::vector<std::int64_t>{1, 2}, std::vector<float>{0.5F, 1});
  write_npy(folder / "bright.npy", std::vector<std::int64_t>{1, 2}, std::vector<float>{0.5F, 1.5F});
  const auto refused = [&](const std::string& run, const std::string& map, const std::string& frames,
                           const char* words) {
    try {
      export_importance(folder / run, {.map = folder / map, .output = folder / "out", .frames = frames},
                        posix_file_ops());
      ADD_FAILURE() << words;
    } catch (const UserError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(words));
    }
    EXPECT_FALSE(std::filesystem::exists(folder / "out"));
  };
  refused("vectors.h5", "map.npy", "", "are no scalars");
  refused("scalars.h5", "bright.npy", "", "pixel 1, 0 (column, row, from 0) has 1.5");
  refused("scalars.h5", "map.npy", "-1", "--frames -1: must be from 1");
}

}  // namespace
}  // namespace noiseloom
