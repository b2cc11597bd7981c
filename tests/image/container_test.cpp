// The table of containers: every row is complete and says the same as its writer.
#include "noiseloom/image/container.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <set>

#include "noiseloom/image/export.h"
#include "support/run_files.h"

namespace noiseloom {
namespace {

using testing::HasSubstr;

TEST(Containers, AreToldApartByNameAndByEnding) {
  std::set<std::pair<std::string, ContainerContent>> names;
  std::set<std::pair<std::string, ContainerContent>> endings;
  for (const Container& container : containers()) {
    EXPECT_TRUE(names.insert({container.name, container.content}).second) << container.name;
    EXPECT_FALSE(container.layouts.empty()) << container.name;
    EXPECT_NE(container.make, nullptr) << container.name;
    EXPECT_EQ(container.pixel != nullptr, container.content == ContainerContent::pixels) << container.name;
    for (const std::string& ending : container.endings) {
      EXPECT_TRUE(endings.insert({ending, container.content}).second) << ending;
      if (std::count(ending.begin(), ending.end(), '.') > 1) continue;  // read by one program, and chosen by name
      const Container* const found = container_of_file("folder.d/name" + ending);
      ASSERT_NE(found, nullptr);
      EXPECT_EQ(found->name, container.name);
    }
  }
  EXPECT_EQ(container_of_file("NAME.PNG"), container_of_file("name.png"));
  EXPECT_EQ(container_of_file("name.Tiff")->name, "tiff");
  EXPECT_EQ(container_of_file("name"), nullptr);
  EXPECT_EQ(container_of_file("name.gif"), nullptr);
}

TEST(Containers, AreListedForHelpAndMessages) {
  EXPECT_EQ(container_names(),
            "png, exr, tiff, hdr, ktx2, dds, npy, raw, header, hlsl, glsl, wgsl, godot, mpv, remix, pbrt, "
            "imagemagick, ghostscript, gimp, csv");
  EXPECT_THAT(container_depths(), HasSubstr("png: 8, 16; exr: 32f, 16f; tiff: 8, 16, 32f"));
  EXPECT_EQ(container_layouts(),
            "png: slices, strip, row, atlas; exr: slices, strip, row, atlas, exr-multipart; tiff: slices, strip, row, "
            "atlas; hdr: slices, strip, row, atlas; ktx2: array, volume, slices; dds: array, volume, slices, strip; "
            "hlsl: array, function; glsl: array, function; wgsl: array, function");
}

TEST(Containers, RefuseChannelsThatTheyDoNotHold) {
  std::string why;
  const auto holds = [&](const char* name, int channels, bool density = false) {
    return holds_channels(*find_container(name, ContainerContent::pixels), channels, density, why);
  };
  EXPECT_TRUE(holds("png", 4));
  EXPECT_FALSE(holds("png", 5));
  EXPECT_THAT(why, HasSubstr("png holds 4 channels, the samples have 5"));
  EXPECT_FALSE(holds("hdr", 4));
  EXPECT_THAT(why, HasSubstr("the samples have 4"));
  EXPECT_TRUE(holds("npy", 100));
  EXPECT_FALSE(holds("png", 4, true));
  EXPECT_FALSE(holds("hdr", 3, true));
  EXPECT_THAT(why, HasSubstr("no alpha"));
  EXPECT_FALSE(holds("raw", 1, true));
}

// Others are for compilers and programs of their own (tests/program/containers_test.py, consumers_test.py).
bool is_read_here(const Container& container) {
  static const std::set<std::string> names = {"png", "exr", "tiff", "hdr", "ktx2", "dds", "npy", "raw"};
  return names.contains(container.name);
}

// Every type and layout of every row, for as many channels as fit: what is offered can be written, and loads again.
TEST(Containers, WriteWhatTheirRowsOffer) {
  const TemporaryFolder folder;
  for (const std::string samples : {"uniform", "vector4", "vector2", "vector7"}) {
    const RunConfig config = small_config(samples);
    const Texture texture = start_texture(config);
    write_run_file(folder / (samples + ".h5"), config, texture);
    for (const Container& container : containers()) {
      std::string why;
      if (container.content != ContainerContent::pixels || !holds_channels(container, texture.channels, false, why))
        continue;
      for (const PixelType type : container.types)
        for (const ExportLayout layout : container.layouts) {
          ExportOptions options;
          options.output = folder / (samples + container.name + depth_name(type) + to_string(layout)) + "/";
          options.format = container.name;
          options.depth = depth_name(type);
          options.layout = to_string(layout);
          const auto files = export_run_file(folder / (samples + ".h5"), options, posix_file_ops()).files;
          if (!is_read_here(container)) continue;
          const TextureFile loaded =
              load_texture(layout == ExportLayout::slices ? options.output : files.back(), config);
          EXPECT_LT(largest_difference(loaded.texture, texture), 1.0 / 100) << options.output;
        }
    }
  }
}

TEST(Containers, AreNamedWhereTheyHoldWhatTheOneAskedForDoesNot) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("vector6");
  write_run_file(folder / "run.h5", config, start_texture(config));
  ExportOptions options;
  options.output = folder / "a.png";
  EXPECT_THAT(user_error_of([&] { export_run_file(folder / "run.h5", options, posix_file_ops()); }),
              HasSubstr("png holds 4 channels, the samples have 6; accepted for them: exr, tiff, npy, raw, header"));
}

}  // namespace
}  // namespace noiseloom
