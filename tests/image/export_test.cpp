// Run files to files that load back as the same values.
#include "noiseloom/image/export.h"
#include "noiseloom/image/image_reader.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "noiseloom/files/npy.h"
#include "support/failing_file_ops.h"
#include "support/run_files.h"

namespace noiseloom {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::UnorderedElementsAre;

ExportOptions options_for(const std::string& output) {
  ExportOptions options;
  options.output = output;
  return options;
}

struct ExportCase {
  std::string samples;
  std::string format;
  std::string depth;
  std::string layout;
  double error;  // largest that the format may add
};

class ExportedTexture : public testing::TestWithParam<ExportCase> {};

TEST_P(ExportedTexture, LoadsAsTheValuesOfTheRunFile) {
  const ExportCase& c = GetParam();
  const TemporaryFolder folder;
  const RunConfig config = small_config(c.samples);
  const Texture texture = start_texture(config);
  write_run_file(folder / "run.h5", config, texture);
  ExportOptions options = options_for(folder / "out/");
  options.format = c.format;
  options.depth = c.depth;
  options.layout = c.layout;
  const std::vector<std::string> files = export_run_file(folder / "run.h5", options, posix_file_ops()).files;
  const bool one_file = c.layout != "slices" && !c.layout.empty();
  const bool array = c.format == "npy" || c.format == "raw";
  EXPECT_EQ(files.size(), array ? (c.format == "raw" ? 2U : 1U) : one_file ? 1U : 3U);
  const TextureFile loaded = load_texture(array || one_file ? files.back() : folder / "out", config);
  EXPECT_LE(largest_difference(loaded.texture, texture), c.error);
}

// Integers: half a step of values that span 1 or 2 (then normalised: at most twice that). hdr: 8 bits of the largest.
INSTANTIATE_TEST_SUITE_P(
    Formats, ExportedTexture,
    testing::Values(
        ExportCase{"uniform", "png", "8", "slices", 0.5 / 256},
        ExportCase{"uniform", "png", "16", "strip", 0.5 / 65536 + 1e-7},
        ExportCase{"vector2", "png", "8", "", 0.5 / 256},
        ExportCase{"vector4", "png", "16", "slices", 0.5 / 65536 + 1e-7},
        ExportCase{"sphere", "png", "8", "strip", 4.0 / 256},
        ExportCase{"disk", "tiff", "16", "strip", 1.0 / 65536 + 1e-7},
        ExportCase{"tent", "tiff", "8", "slices", 0.5 / 256}, ExportCase{"gauss", "tiff", "32f", "strip", 0},
        ExportCase{"vector7", "tiff", "32f", "slices", 0}, ExportCase{"gauss", "exr", "", "slices", 0},
        ExportCase{"vector2", "exr", "32f", "exr-multipart", 0}, ExportCase{"vector8", "exr", "", "strip", 0},
        ExportCase{"disk", "exr", "", "exr-multipart", 0}, ExportCase{"circle", "hdr", "", "slices", 1.0 / 256},
        ExportCase{"disk", "hdr", "32f", "strip", 2.0 / 256}, ExportCase{"gauss", "npy", "", "", 0},
        ExportCase{"sphere", "npy", "32f", "", 1e-7}, ExportCase{"gauss", "raw", "", "", 0},
        ExportCase{"disk", "raw", "8", "", 1.0 / 256}, ExportCase{"vector5", "raw", "16", "", 0.5 / 65536 + 1e-7}));

TEST(Export, QuantisesByTheFloor) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("vector3");
  const Texture texture = start_texture(config);
  write_run_file(folder / "run.h5", config, texture);
  ExportOptions options = options_for(folder / "run.raw");
  options.depth = "16";
  export_run_file(folder / "run.h5", options, posix_file_ops());
  const std::string bytes = read_bytes(folder / "run.raw");
  ASSERT_EQ(bytes.size(), texture.values.size() * 2);
  std::size_t i = 0;
  for (const SliceIndex s : first_indices<SliceIndex>(3))
    for (const float v : interleaved_slice(texture, s)) {
      const int code = static_cast<unsigned char>(bytes[2 * i]) + 256 * static_cast<unsigned char>(bytes[2 * i + 1]);
      EXPECT_EQ(code, static_cast<int>(std::floor(65536 * static_cast<double>(v))));
      ++i;
    }
}

TEST(Export, WritesNpyOfTheRunFilesShape) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("vector2", "x = 5, y = 3, t = 2, z = 7");
  write_run_file(folder / "run.h5", config, start_texture(config));
  export_run_file(folder / "run.h5", options_for(folder / "a.npy"), posix_file_ops());
  EXPECT_THAT(read_npy(folder / "a.npy").shape, ElementsAre(7, 2, 3, 5, 2));
  ExportOptions some = options_for(folder / "b.npy");
  some.slices = "3:5";
  export_run_file(folder / "run.h5", some, posix_file_ops());
  EXPECT_THAT(read_npy(folder / "b.npy").shape, ElementsAre(2, 3, 5, 2));
}

TEST(Export, PutsDensityOverItsMaximumIntoAlpha) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("tent");
  const Texture texture = start_texture(config);
  write_run_file(folder / "run.h5", config, texture, true);
  ExportOptions options = options_for(folder / "out/");
  options.density = "alpha";
  options.naming = "plain";
  export_run_file(folder / "run.h5", options, posix_file_ops());
  for (const SliceIndex s : first_indices<SliceIndex>(3)) {
    ImageReader reader(folder / fmt::format("out/run_{}.png", s.value()));
    ASSERT_EQ(reader.shape(0).channels, 4);
    std::vector<std::byte> bytes(reader.shape(0).num_bytes());
    reader.read_rows(0, 0, 7, bytes);
    for (std::size_t i = 0; i < 77; ++i) {
      const auto byte = [&](std::size_t c) { return std::to_integer<int>(bytes[4 * i + c]); };
      EXPECT_EQ(byte(3), quantise(static_cast<double>(test_density(s, i)) / 13, 8));
      EXPECT_EQ(byte(0), quantise(static_cast<double>(texture.slice(s)[i]), 8));
      EXPECT_EQ(byte(1), byte(0));
      EXPECT_EQ(byte(2), byte(0));
    }
  }
}

TEST(Export, PutsDensityIntoImagesBeside) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("tent");
  const Texture texture = start_texture(config);
  write_run_file(folder / "run.h5", config, texture, true);
  ExportOptions options = options_for(folder / "out/");
  options.density = "separate";
  export_run_file(folder / "run.h5", options, posix_file_ops());
  for (const SliceIndex s : first_indices<SliceIndex>(3)) {
    for (const bool density : {false, true}) {
      ImageReader reader(folder / fmt::format("out/run_{}{}.png", s.value(), density ? "_pdf" : ""));
      ASSERT_EQ(reader.shape(0).channels, 1);
      std::vector<std::byte> bytes(reader.shape(0).num_bytes());
      reader.read_rows(0, 0, 7, bytes);
      for (std::size_t i = 0; i < 77; ++i) {
        const double expected =
            density ? static_cast<double>(test_density(s, i)) / 13 : static_cast<double>(texture.slice(s)[i]);
        EXPECT_EQ(std::to_integer<int>(bytes[i]), quantise(expected, 8));
      }
    }
  }
  options.density = "beside";
  EXPECT_THROW(export_run_file(folder / "run.h5", options, posix_file_ops()), UserError);
}

TEST(Export, WritesFramesAsAShaderReadsThem) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("vector2");
  const Texture texture = start_texture(config);
  write_run_file(folder / "run.h5", config, texture);
  ExportOptions options = options_for(folder / "frames.npy");
  options.frames = "8";
  options.values = "2";
  export_run_file(folder / "run.h5", options, posix_file_ops());
  const NpyArray frames = read_npy(folder / "frames.npy");
  const std::int64_t width = texture.extents.width();
  const std::int64_t height = texture.extents.height();
  ASSERT_THAT(frames.shape, ElementsAre(8, 2, height, width, 2));
  const TextureRead read = {.width = width, .height = height, .num_slices = texture.extents.num_slices(), .values = 2};
  std::size_t at = 0;
  for (std::int64_t frame = 0; frame < 8; ++frame) {
    for (int value = 0; value < 2; ++value) {
      const TextureRead::Place place = read.place(frame, value);
      for (std::int64_t y = 0; y < height; ++y) {
        for (std::int64_t x = 0; x < width; ++x) {
          const auto cell = static_cast<std::size_t>((y + place.dy) % height * width + (x + place.dx) % width);
          for (std::size_t c = 0; c < 2; ++c) {
            const auto plane = c * static_cast<std::size_t>(width * height);
            ASSERT_EQ(frames.values[at++], static_cast<double>(texture.slice(place.slice)[plane + cell]));
          }
        }
      }
    }
  }
  options.frames = "0";
  options.values = "many";
  options.read = "rows";
  try {
    export_run_file(folder / "run.h5", options, posix_file_ops());
    ADD_FAILURE();
  } catch (const UserError& error) {
    EXPECT_EQ(error.faults().size(), 3U) << error.what();
  }
}

TEST(Export, ClampsUnboundedValuesToTheRangeGiven) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("gauss");
  const Texture texture = start_texture(config);
  write_run_file(folder / "run.h5", config, texture);
  ExportOptions options = options_for(folder / "run.raw");
  options.depth = "8";
  EXPECT_THAT(user_error_of([&] { export_run_file(folder / "run.h5", options, posix_file_ops()); }),
              HasSubstr("--range LO:HI"));
  options.range = "-1:1";
  export_run_file(folder / "run.h5", options, posix_file_ops());
  const TextureFile loaded = load_texture(folder / "run.raw", std::nullopt);
  for (std::size_t i = 0; i < texture.values.size(); ++i)
    EXPECT_NEAR(loaded.texture.values[i], std::clamp(texture.values[i], -1.0F, 1.0F), 1.0 / 256 + 1e-6);
}

TEST(Export, NvidiasVectorsAreOpaqueRgba) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("vector2");
  const Texture texture = start_texture(config);
  write_run_file(folder / "run.h5", config, texture);
  ExportOptions options = options_for(folder / "out/");
  options.naming = "nvidia";
  export_run_file(folder / "run.h5", options, posix_file_ops());
  for (const SliceIndex s : first_indices<SliceIndex>(3)) {
    ImageReader reader(folder / fmt::format("out/stbn_vec2_2D_11x7x3_{}.png", s.value()));
    ASSERT_EQ(reader.shape(0).channels, 4);
    std::vector<std::byte> bytes(reader.shape(0).num_bytes());
    reader.read_rows(0, 0, 7, bytes);
    for (std::size_t i = 0; i < 77; ++i) {
      const auto byte = [&](std::size_t c) { return std::to_integer<int>(bytes[4 * i + c]); };
      EXPECT_EQ(byte(0), quantise(static_cast<double>(texture.slice(s)[i]), 8));
      EXPECT_EQ(byte(1), quantise(static_cast<double>(texture.slice(s)[77 + i]), 8));
      EXPECT_EQ(byte(2), 0);
      EXPECT_EQ(byte(3), 255);
    }
  }
}

TEST(Export, OfAnUnfinishedRunSaysSo) {
  const TemporaryFolder folder;
  RunConfig config = small_config("uniform");
  config.optimizer.stop = {200, 0, 0, 0};
  for (const std::string finished : {"", "iterations"}) {
    RunFileContent content;
    content.extents = config.problem.extents;
    content.config = to_toml(config);
    content.datasets = {{"/samples", ElementType::float32, 1, true}};
    content.history = {{"iterations", {0, 64, 128}}};
    content.state = {{"finished", finished}};
    const std::string name = finished.empty() ? "half" : "whole";
    RunFileWriter writer(posix_file_ops(), folder / (name + ".h5"), content);
    const std::vector<float> slice(77, 0.5F);
    for (const SliceIndex s : first_indices<SliceIndex>(3)) writer.write_slice(0, s, std::as_bytes(std::span(slice)));
    writer.publish();
    const ExportResult result =
        export_run_file(folder / (name + ".h5"), options_for(folder / (name + ".raw")), posix_file_ops());
    EXPECT_EQ(result.unfinished, finished.empty() ? "not finished: 128 of 200 iterations done" : "");
    const std::string line = "\"unfinished\": \"not finished: 128 of 200 iterations done\"";
    EXPECT_THAT(read_bytes(folder / (name + ".json")),
                finished.empty() ? testing::Matcher<std::string>(HasSubstr(line)) : Not(HasSubstr("unfinished")));
  }
}

TEST(Export, TellsAllFaultsAtOnceAndWritesNothing) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("uniform");
  write_run_file(folder / "run.h5", config, start_texture(config));
  ExportOptions options = options_for(folder / "out");
  options.depth = "32f";
  options.layout = "volume";
  options.slices = "2:9";
  options.density = "alpha";
  const std::string error = user_error_of([&] { export_run_file(folder / "run.h5", options, posix_file_ops()); });
  EXPECT_THAT(error, HasSubstr("--depth 32f: png does not hold it; accepted for png: 8, 16"));
  EXPECT_THAT(error, HasSubstr("--layout volume: accepted for png: slices, strip"));
  EXPECT_THAT(error, HasSubstr("0 <= A < B <= 3"));
  EXPECT_THAT(error, HasSubstr("constant"));
  for (const char* const format : {"ktx", "dds2", "gif"}) {
    options = options_for(folder / "out");
    options.format = format;
    EXPECT_THAT(user_error_of([&] { export_run_file(folder / "run.h5", options, posix_file_ops()); }),
                HasSubstr("accepted: png, exr, tiff, hdr, ktx2, dds, npy, raw"));
  }
  EXPECT_THAT(user_error_of([&] { export_run_file(folder / "run.h5", options_for("a.jpg"), posix_file_ops()); }),
              HasSubstr("\".jpg\""));
  EXPECT_THAT(folder.names(), ElementsAre("run.h5"));
}

TEST(Export, OverwritesOnlyWhenAsked) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("uniform");
  write_run_file(folder / "run.h5", config, start_texture(config));
  write_bytes(folder / "run_1.png", "precious");
  ExportOptions options = options_for(folder.path() + "/");
  EXPECT_THAT(user_error_of([&] { export_run_file(folder / "run.h5", options, posix_file_ops()); }),
              HasSubstr("run_1.png: exists; --overwrite replaces it"));
  EXPECT_EQ(read_bytes(folder / "run_1.png"), "precious");
  EXPECT_THAT(folder.names(), UnorderedElementsAre("run.h5", "run_1.png"));
  options.overwrite = true;
  export_run_file(folder / "run.h5", options, posix_file_ops());
  EXPECT_THAT(folder.names(), UnorderedElementsAre("run.h5", "run_0.png", "run_1.png", "run_2.png"));
  EXPECT_NE(read_bytes(folder / "run_1.png"), "precious");
}

TEST(Export, GivesTheSameBytesEveryTime) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("vector3");
  write_run_file(folder / "run.h5", config, start_texture(config));
  for (const char* const name : {"a.png", "a.exr", "a.tif", "a.hdr", "a.npy", "a.raw"}) {
    std::string first;
    for (int i = 0; i < 2; ++i) {
      ExportOptions options = options_for(folder / name);
      options.slices = "0:1";
      options.overwrite = true;
      const std::vector<std::string> files = export_run_file(folder / "run.h5", options, posix_file_ops()).files;
      const std::string bytes = read_bytes(files.back());
      EXPECT_NE(bytes, "");
      if (i == 0) first = bytes;
      EXPECT_TRUE(bytes == first) << name;
    }
  }
}

TEST(Export, LeavesNothingBehindWhenAnOperationFails) {
  const RunConfig config = small_config("uniform");
  const Texture texture = start_texture(config);
  for (const std::string name : {"out/a.raw", "out/{}.png"}) {
    int fail_at = 0;
    for (bool failed = true; failed && fail_at < 100; ++fail_at) {
      const TemporaryFolder folder;
      write_run_file(folder / "run.h5", config, texture);
      FailingFileOps ops(posix_file_ops(), fail_at, FailingFileOps::Mode::fail_once);
      failed = false;
      try {
        export_run_file(folder / "run.h5", options_for(folder / name), ops);
      } catch (const EnvironmentError&) {
        failed = true;
      }
      if (!failed) break;
      for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path()))
        EXPECT_THAT(entry.path().string(), testing::Not(HasSubstr("partial"))) << "operation " << fail_at;
    }
    EXPECT_GT(fail_at, 5) << "the operations did not go through the interface";
  }
}

}  // namespace
}  // namespace noiseloom
