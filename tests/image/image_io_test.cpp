// Image files hold the numbers that were handed in. (tests/program/study_images_test.py reads them with other
// programs.)
#include "noiseloom/image/image_io.h"
#include "noiseloom/image/image_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <numeric>

#include "support/run_files.h"

#ifdef NOISELOOM_SANITIZE_ADDRESS
// OpenImageIO 2.4 loses the text of libpng's error when a PNG is cut short.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libOpenImageIO"; }
#endif

namespace noiseloom {
namespace {

using testing::HasSubstr;

// Bytes that differ in every row, column, channel and block; alpha is often 0 or small.
std::vector<std::byte> pattern(const ImageShape& shape, int block) {
  std::vector<std::byte> bytes(shape.num_bytes());
  const std::size_t count = bytes.size() / bytes_per_number(shape.type);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t n = i * 37 + static_cast<std::size_t>(block) * 101;
    const std::uint8_t b = static_cast<std::uint8_t>(n % 256 < 60 ? 0 : n % 256);
    const std::uint16_t w = static_cast<std::uint16_t>(n * 523 % 65536);
    const float f = static_cast<float>(n % 997) / 499.0F - 1.0F;
    const void* const from = shape.type == PixelType::uint8    ? static_cast<const void*>(&b)
                             : shape.type == PixelType::uint16 ? static_cast<const void*>(&w)
                                                               : &f;
    const std::size_t width = bytes_per_number(shape.type);
    std::memcpy(bytes.data() + i * width, from, width);
  }
  return bytes;
}

struct ImageCase {
  ImageFormat format;
  const char* extension;
  PixelType type;
  int channels;
};

class WrittenImage : public testing::TestWithParam<ImageCase> {};

TEST_P(WrittenImage, GivesBackItsBytes) {
  const ImageCase& c = GetParam();
  const TemporaryFolder folder;
  const std::string path = folder / (std::string("image") + c.extension);
  ImageJob job;
  job.format = c.format;
  const PixelLayout layout = c.format == ImageFormat::exr   ? exr_pixel(c.channels, false)
                             : c.format == ImageFormat::png ? png_pixel(c.channels, false)
                                                            : tiff_pixel(c.channels, false);
  job.block = {13, 5, static_cast<int>(layout.source.size()), c.type, layout.names, layout.alpha};
  job.num_blocks = 3;
  std::vector<std::byte> block;
  write_image(path, job, [&](int b) {
    block = pattern(job.block, b);
    return std::span<const std::byte>(block);
  });
  ImageReader reader(path);
  ASSERT_EQ(reader.num_parts(), 1);
  EXPECT_EQ(reader.shape(0).width, 13);
  EXPECT_EQ(reader.shape(0).height, 15);
  EXPECT_EQ(reader.shape(0).channels, job.block.channels);
  EXPECT_EQ(reader.shape(0).type, c.type);
  for (int b = 2; b >= 0; --b) {
    std::vector<std::byte> read(job.block.num_bytes());
    reader.read_rows(0, 5 * b, 5, read);
    EXPECT_EQ(read, pattern(job.block, b)) << "block " << b;
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, WrittenImage,
                         testing::Values(ImageCase{ImageFormat::png, ".png", PixelType::uint8, 1},
                                         ImageCase{ImageFormat::png, ".png", PixelType::uint8, 2},
                                         ImageCase{ImageFormat::png, ".png", PixelType::uint8, 3},
                                         ImageCase{ImageFormat::png, ".png", PixelType::uint8, 4},
                                         ImageCase{ImageFormat::png, ".png", PixelType::uint16, 1},
                                         ImageCase{ImageFormat::png, ".png", PixelType::uint16, 4},
                                         ImageCase{ImageFormat::tiff, ".tif", PixelType::uint8, 1},
                                         ImageCase{ImageFormat::tiff, ".tif", PixelType::uint8, 4},
                                         ImageCase{ImageFormat::tiff, ".tif", PixelType::uint16, 3},
                                         ImageCase{ImageFormat::tiff, ".tif", PixelType::float32, 4},
                                         ImageCase{ImageFormat::tiff, ".tif", PixelType::float32, 7},
                                         ImageCase{ImageFormat::exr, ".exr", PixelType::float32, 1},
                                         ImageCase{ImageFormat::exr, ".exr", PixelType::float32, 2},
                                         ImageCase{ImageFormat::exr, ".exr", PixelType::float32, 4},
                                         ImageCase{ImageFormat::exr, ".exr", PixelType::float32, 8}));

TEST(WriteImage, MakesPartsThatAreReadOneByOne) {
  const TemporaryFolder folder;
  ImageJob job;
  job.format = ImageFormat::exr;
  job.block = {7, 5, 3, PixelType::float32, {"R", "G", "B"}, -1};
  job.num_blocks = 4;
  job.stacking = Stacking::parts;
  job.part_names = {"a", "b", "c", "d"};
  std::vector<std::byte> block;
  write_image(folder / "parts.exr", job, [&](int b) {
    block = pattern(job.block, b);
    return std::span<const std::byte>(block);
  });
  ImageReader reader(folder / "parts.exr");
  ASSERT_EQ(reader.num_parts(), 4);
  for (int b = 0; b < 4; ++b) {
    std::vector<std::byte> read(job.block.num_bytes());
    reader.read_rows(b, 0, 5, read);
    EXPECT_EQ(read, pattern(job.block, b));
  }
}

TEST(WriteImage, KeepsEightBitsOfEveryNumberInHdr) {
  const TemporaryFolder folder;
  ImageJob job;
  job.format = ImageFormat::hdr;
  job.block = {17, 3, 3, PixelType::float32, {"R", "G", "B"}, -1};
  std::vector<float> values(17 * 3 * 3);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i % 53) / 53;
  write_image(folder / "image.hdr", job, [&](int) { return std::as_bytes(std::span(values)); });
  ImageReader reader(folder / "image.hdr");
  std::vector<float> read(values.size());
  reader.read_rows(0, 0, 3, std::as_writable_bytes(std::span(read)));
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_NEAR(read[i], values[i], 1.0 / 128) << i;
}

TEST(WriteImage, SaysThatTheFolderIsMissing) {
  ImageJob job;
  job.block = {1, 1, 1, PixelType::uint8, {"Y"}, -1};
  const std::byte pixel{7};
  try {
    write_image("/nonexistent-folder/image.png", job, [&](int) { return std::span(&pixel, 1); });
    FAIL() << "nothing was thrown";
  } catch (const EnvironmentError& error) {
    EXPECT_THAT(error.what(), HasSubstr("/nonexistent-folder/image.png: cannot write the image"));
  }
}

TEST(ImageReader, RefusesWhatIsNoImage) {
  const TemporaryFolder folder;
  write_bytes(folder / "text.png", "not an image");
  EXPECT_THAT(user_error_of([&] { ImageReader reader(folder / "text.png"); }),
              HasSubstr("not an image that can be read"));
  EXPECT_THAT(user_error_of([&] { ImageReader reader(folder / "none.png"); }), HasSubstr("no such file"));
}

TEST(ImageReader, NoticesAFileCutShort) {
  const TemporaryFolder folder;
  ImageJob job;
  job.block = {64, 64, 3, PixelType::uint8, {"R", "G", "B"}, -1};
  const std::vector<std::byte> bytes = pattern(job.block, 0);
  write_image(folder / "whole.png", job, [&](int) { return std::span<const std::byte>(bytes); });
  const std::string whole = read_bytes(folder / "whole.png");
  write_bytes(folder / "cut.png", whole.substr(0, whole.size() / 2));
  std::vector<std::byte> read(bytes.size());
  EXPECT_NE(user_error_of([&] {
              ImageReader reader(folder / "cut.png");
              reader.read_rows(0, 0, 64, read);
            }),
            "");
}

}  // namespace
}  // namespace noiseloom
