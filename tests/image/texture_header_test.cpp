// KTX2 and DDS: what is read, what is refused and by which name.
#include "image/pixels/texture_header.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <fstream>

#include "image/pixels/texture_bytes.h"
#include "noiseloom/image/export.h"
#include "noiseloom/image/image_reader.h"
#include "support/run_files.h"

namespace noiseloom {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// A sound file with some of its 32-bit fields changed, read.
class ChangedFile {
 public:
  ChangedFile(const std::string& samples, const std::string& file, const std::string& depth = "",
              const std::string& layout = "")
      : path_(folder_ / file) {
    const RunConfig config = small_config(samples);
    write_run_file(folder_ / "run.h5", config, start_texture(config));
    ExportOptions options;
    options.output = path_;
    options.depth = depth;
    options.layout = layout;
    export_run_file(folder_ / "run.h5", options, posix_file_ops());
    bytes_ = read_bytes(path_);
  }
  ChangedFile& set(std::size_t at, std::uint32_t number) {
    for (std::size_t i = 0; i < 4; ++i) bytes_[at + i] = static_cast<char>(number >> (8 * i) & 255);
    return *this;
  }
  ChangedFile& cut(std::size_t bytes) {
    bytes_.resize(bytes_.size() - bytes);
    return *this;
  }
  ImageReader reader() const {
    std::ofstream(path_, std::ios::binary) << bytes_;
    return ImageReader(path_);
  }
  std::string error() const {
    return user_error_of([&] { reader(); });
  }

 private:
  TemporaryFolder folder_;
  std::string path_;
  std::string bytes_;
};

TEST(Ktx2, IsReadAsAPartForEachLayer) {
  const ImageReader reader = ChangedFile("vector2", "a.ktx2").reader();
  EXPECT_EQ(reader.num_parts(), 3);
  EXPECT_EQ(reader.shape(2).width, 11);
  EXPECT_EQ(reader.shape(2).height, 7);
  EXPECT_THAT(reader.shape(2).channel_names, ElementsAre("R", "G"));
}

TEST(Ktx2, OfOthersIsRefusedByName) {
  const auto with = [](std::size_t at, std::uint32_t number) {
    return ChangedFile("vector2", "a.ktx2").set(at, number).error();
  };
  EXPECT_THAT(with(44, 2), HasSubstr("supercompression (Zstandard)"));
  EXPECT_THAT(with(44, 1), HasSubstr("supercompression (BasisLZ)"));
  EXPECT_THAT(with(40, 8), HasSubstr("8 levels (mip maps)"));
  EXPECT_THAT(with(36, 6), HasSubstr("6 faces (a cube map)"));
  EXPECT_THAT(with(12, 145), HasSubstr("BC7 blocks"));
  EXPECT_THAT(with(12, 157), HasSubstr("ASTC blocks"));
  EXPECT_THAT(with(12, 0), HasSubstr("Basis Universal"));
  EXPECT_THAT(with(12, 99), HasSubstr("VkFormat 99"));
  EXPECT_THAT(with(20, 0), HasSubstr("0 x 7"));
  EXPECT_THAT(with(20, 12), HasSubstr("do not fit"));
  EXPECT_THAT(with(32, 70000), HasSubstr("70000 slices"));
  EXPECT_THAT(ChangedFile("vector2", "a.ktx2").cut(1).error(), HasSubstr("cannot hold so many"));
}

// The bytes of an sRGB format are read as they are, and whoever loads them is told.
TEST(Ktx2, MarkedAsColoursIsSaidToBe) {
  ChangedFile file("vector2", "a.ktx2");
  EXPECT_FALSE(file.reader().is_srgb());
  EXPECT_TRUE(file.set(12, 22).reader().is_srgb());
}

TEST(Dds, IsReadAsAPartForEachLayerOrSlice) {
  for (const char* const layout : {"array", "volume"}) {
    const ImageReader reader = ChangedFile("vector4", "a.dds", "16f", layout).reader();
    EXPECT_EQ(reader.num_parts(), 3);
    EXPECT_EQ(reader.shape(0).type, PixelType::float16);
    EXPECT_THAT(reader.shape(0).channel_names, ElementsAre("R", "G", "B", "A"));
  }
  const ImageReader strip = ChangedFile("vector2", "a.dds", "8", "strip").reader();
  EXPECT_EQ(strip.num_parts(), 1);
  EXPECT_EQ(strip.shape(0).height, 21);
}

TEST(Dds, OfOthersIsRefusedByName) {
  const auto with = [](std::size_t at, std::uint32_t number) {
    return ChangedFile("vector2", "a.dds").set(at, number).error();
  };
  EXPECT_THAT(with(28, 8), HasSubstr("8 levels (mip maps)"));
  EXPECT_THAT(with(128, 98), HasSubstr("BC7 blocks"));
  EXPECT_THAT(with(128, 24), HasSubstr("DXGI format 24"));
  EXPECT_THAT(with(112, 0x200), HasSubstr("a cube map"));
  EXPECT_THAT(with(84, 0x35545844), HasSubstr("DXT5"));
  EXPECT_THAT(with(16, 0), HasSubstr("0 x 7"));
  EXPECT_THAT(ChangedFile("vector2", "a.dds", "8", "strip").set(92, 0xff00).error(), HasSubstr("masks ff00"));
  EXPECT_THAT(ChangedFile("vector2", "a.dds").cut(1).error(), HasSubstr("cannot hold so many"));
}

// Blue first, and nothing in the fourth byte.
TEST(Dds, ChannelsOfOtherOrdersComeAsRedGreenBlue) {
  ChangedFile file("vector4", "a.dds");
  ImageReader rgba = file.reader();
  ImageReader bgrx = file.set(128, 88).reader();
  EXPECT_THAT(bgrx.shape(0).channel_names, ElementsAre("R", "G", "B"));
  std::vector<std::byte> first(rgba.shape(0).num_bytes());
  std::vector<std::byte> second(bgrx.shape(0).num_bytes());
  rgba.read_rows(0, 0, 7, first);
  bgrx.read_rows(0, 0, 7, second);
  for (std::size_t t = 0; t < 77; ++t)
    for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(second[3 * t + c], first[4 * t + 2 - c]);
}

// No value of [0, 1) reaches 1 by rounding, which would put it outside its space.
TEST(HalfFloats, StayBelowOne) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("uniform");
  Texture texture = start_texture(config);
  texture.values[5] = 0.99999F;
  texture.values[6] = 0.9997F;  // nearer to 1 than to the half below it
  write_run_file(folder / "run.h5", config, texture);
  for (const std::string format : {"exr", "ktx2", "dds", "raw"}) {
    ExportOptions options;
    options.output = folder / ("a." + format);
    options.depth = "16f";
    options.layout = format == "exr" ? "strip" : "";
    export_run_file(folder / "run.h5", options, posix_file_ops());
    const TextureFile loaded = load_texture(options.output, config);
    EXPECT_LT(largest_difference(loaded.texture, texture), 1.0 / 2048) << format;
    EXPECT_LT(loaded.texture.values[5], 1.0F) << format;
  }
}

}  // namespace
}  // namespace noiseloom
