// Images of other programs: windows, tiles, and headers that claim what the file cannot hold.
#include "noiseloom/image/image_reader.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "support/run_files.h"

namespace noiseloom {
namespace {

using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;

constexpr int width = 37;
constexpr int height = 29;

std::vector<float> pixels() {
  std::vector<float> values;
  for (int i = 0; i < width * height; ++i) values.push_back(static_cast<float>(i % 251) / 256);
  return values;
}

OIIO::ImageSpec spec_at(int x, int y, OIIO::TypeDesc type = OIIO::TypeDesc::FLOAT) {
  OIIO::ImageSpec spec(width, height, 1, type);
  spec.x = x;
  spec.y = y;
  return spec;
}

void write_with_library(const std::string& path, const OIIO::ImageSpec& spec) {
  const std::vector<float> values = pixels();
  auto out = OIIO::ImageOutput::create(path);
  ASSERT_TRUE(out && out->open(path, spec)) << OIIO::geterror();
  ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, values.data())) << out->geterror();
  ASSERT_TRUE(out->close());
}

// The numbers of an image of one channel, read in two pieces.
std::vector<float> read_numbers(const std::string& path) {
  ImageReader reader(path);
  EXPECT_EQ(reader.shape(0).width, width);
  EXPECT_EQ(reader.shape(0).height, height);
  std::vector<float> values(static_cast<std::size_t>(width * height));
  const auto bytes = std::as_writable_bytes(std::span(values));
  const std::size_t row = width * sizeof(float);
  reader.read_rows(0, 11, height - 11, bytes.subspan(11 * row));
  reader.read_rows(0, 0, 11, bytes.first(11 * row));
  return values;
}

TEST(ImageReader, ReadsTheDataWindowWhereverItLies) {
  const TemporaryFolder folder;
  for (const auto& [x, y] : {std::pair{0, 0}, {5, 19}, {-40, -3}, {1000, -1000}}) {
    const std::string path = folder / "a.exr";
    OIIO::ImageSpec spec = spec_at(x, y);
    spec.full_x = x;
    spec.full_y = y;
    write_with_library(path, spec);
    EXPECT_EQ(read_numbers(path), pixels()) << x << ", " << y;
    EXPECT_EQ(ImageReader(path).window(0), "");
  }
  write_with_library(folder / "p.tif", spec_at(0, 17));
  EXPECT_EQ(read_numbers(folder / "p.tif"), pixels());
}

TEST(ImageReader, SaysWhereTheDisplayWindowIsAnother) {
  const TemporaryFolder folder;
  OIIO::ImageSpec spec = spec_at(3, -2);
  spec.full_width = 100;
  spec.full_height = 90;
  write_with_library(folder / "a.exr", spec);
  EXPECT_EQ(read_numbers(folder / "a.exr"), pixels());
  EXPECT_EQ(ImageReader(folder / "a.exr").window(0),
            "data window 37 x 29 at 3, -2 in a display window of 100 x 90 at 0, 0");
}

TEST(ImageReader, ReadsTiles) {
  const TemporaryFolder folder;
  for (const char* const name : {"a.tif", "a.exr", "b.exr"}) {
    OIIO::ImageSpec spec = name[0] == 'b' ? spec_at(-7, 12) : spec_at(0, 0);
    spec.tile_width = 16;
    spec.tile_height = 16;
    write_with_library(folder / name, spec);
    EXPECT_EQ(read_numbers(folder / name), pixels()) << name;
  }
}

std::string exr_attribute(const std::string& name, const std::string& type, const std::string& value) {
  const std::uint32_t size = static_cast<std::uint32_t>(value.size());
  return name + '\0' + type + '\0' + std::string(reinterpret_cast<const char*>(&size), 4) + value;
}

std::string little(std::initializer_list<std::int32_t> numbers) {
  std::string bytes;
  for (const std::int32_t n : numbers) bytes += std::string(reinterpret_cast<const char*>(&n), 4);
  return bytes;
}

// A header that claims this size, and no pixels.
std::string exr_header(std::int32_t columns, std::int32_t rows, bool tiled) {
  using namespace std::string_literals;
  std::string head = "\x76\x2f\x31\x01"s + (tiled ? "\x02\x02\x00\x00"s : "\x02\x00\x00\x00"s);
  head += exr_attribute("channels", "chlist", "Y\0"s + little({2, 0, 1, 1}) + '\0');
  head += exr_attribute("compression", "compression", "\0"s);
  head += exr_attribute("dataWindow", "box2i", little({0, 0, columns - 1, rows - 1}));
  head += exr_attribute("displayWindow", "box2i", little({0, 0, columns - 1, rows - 1}));
  head += exr_attribute("lineOrder", "lineOrder", "\0"s);
  head += exr_attribute("pixelAspectRatio", "float", "\0\0\x80\x3f"s);
  head += exr_attribute("screenWindowCenter", "v2f", std::string(8, '\0'));
  head += exr_attribute("screenWindowWidth", "float", "\0\0\x80\x3f"s);
  if (tiled) head += exr_attribute("tiles", "tiledesc", little({1, 1}) + '\0');
  return head + '\0';
}

std::string tiff_header(std::uint32_t columns, std::uint32_t rows) {
  using namespace std::string_literals;
  std::string file = "II*\0\x08\0\0\0\x02\0"s;
  file += "\x00\x01\x04\x00\x01\x00\x00\x00"s + little({static_cast<std::int32_t>(columns)});
  file += "\x01\x01\x04\x00\x01\x00\x00\x00"s + little({static_cast<std::int32_t>(rows)});
  return file + little({0});
}

std::string big(std::uint32_t n) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(n >> shift & 255);
  return bytes;
}

std::string png_header(std::uint32_t columns, std::uint32_t rows) {
  using namespace std::string_literals;
  return "\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR"s + big(columns) + big(rows) + "\x08\0\0\0\0"s + big(0);
}

TEST(ImageReader, RefusesClaimsThatTheFileCannotHold) {
  const TemporaryFolder folder;
  const std::vector<std::pair<std::string, std::string>> files = {
      {"wide.exr", exr_header(50000, 40000, false)},
      {"tiles.exr", exr_header(3000, 300, true)},  // 900,000 tiles of a pixel: 7 MB of offsets
      {"wide.tif", tiff_header(100000, 70000)},
      {"wide.png", png_header(60000, 60001)},
      {"wide.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 90000 +X 80000\n"},
      {"wide.ppm", "P6 # comment\n 70000 70000 255\n"},
      {"wide.bmp", std::string("BM") + std::string(12, '\0') + little({40, 99999, -99999}) + std::string(40, '\0')}};
  for (const auto& file : files) {
    const std::string& name = file.first;
    const std::string& bytes = file.second;
    write_bytes(folder / name, bytes);
    EXPECT_THAT(user_error_of([&] { ImageReader reader(folder / name); }), HasSubstr("cannot hold so many")) << name;
  }
}

// The image library would fill a gigabyte and more for such a chunk, for seconds.
TEST(ImageReader, RefusesPngChunksThatAreLongerThanTheFile) {
  const TemporaryFolder folder;
  const std::string text = "Description" + std::string(1, '\0') + "noise";
  const std::string rest = "tEXt" + text + big(0) + big(0) + "IEND" + big(0xAE426082U);
  const auto said = [&](std::uint32_t length) {
    write_bytes(folder / "a.png", png_header(4, 3) + big(length) + rest);
    return user_error_of([&] { ImageReader reader(folder / "a.png"); });
  };
  const auto there = static_cast<std::uint32_t>(text.size()) + 16;
  EXPECT_THAT(
      said(0x56776569),
      AllOf(HasSubstr("chunk tEXt at byte 33 is said to have 1450665321 bytes, and 33 follow"), HasSubstr("cut off")));
  EXPECT_THAT(said(there + 1), HasSubstr("is said to have 34 bytes"));
  EXPECT_THAT(said(there), Not(HasSubstr("is said to have")));
}

TEST(ImageReader, RefusesExrAttributesThatAreLongerThanTheFile) {
  const TemporaryFolder folder;
  const auto said = [&](const std::string& bytes) {
    write_bytes(folder / "a.exr", bytes);
    return user_error_of([&] { ImageReader reader(folder / "a.exr"); });
  };
  using namespace std::string_literals;
  const std::string longer = "notes\0string\0"s + little({1 << 30}) + "noise";
  const std::string header = exr_header(4, 3, false);
  const std::string words = "is said to have 1073741824 bytes, and 5 follow; is it cut off?";
  EXPECT_THAT(said(header.substr(0, 8) + longer), AllOf(HasSubstr("attribute at byte 8 "), HasSubstr(words)));
  EXPECT_THAT(said(header.substr(0, header.size() - 1) + longer), HasSubstr(words));
  // Of the second part; in a file of one part that is no header.
  EXPECT_THAT(said(header + longer), Not(HasSubstr("is said to have")));
  std::string parts = header + longer;
  parts[5] = '\x10';
  EXPECT_THAT(said(parts), HasSubstr(words));
}

TEST(ImageReader, ReadsLongAttributesAndWhatHasBytesBehindItsEnd) {
  const TemporaryFolder folder;
  OIIO::ImageSpec spec = spec_at(0, 0);
  spec.attribute("a", std::string(3U << 20, 'x'));  // before the data window
  write_with_library(folder / "a.exr", spec);
  EXPECT_EQ(read_numbers(folder / "a.exr"), pixels());
  write_with_library(folder / "a.png", spec_at(0, 0, OIIO::TypeDesc::UINT8));
  const auto bytes_of_png = [&] {
    ImageReader reader(folder / "a.png");
    std::vector<std::byte> bytes(reader.shape(0).num_bytes());
    reader.read_rows(0, 0, reader.shape(0).height, bytes);
    return bytes;
  };
  const std::vector<std::byte> plain = bytes_of_png();
  write_bytes(folder / "a.png", read_bytes(folder / "a.png") + big(0x56776569) + "tEXt");
  EXPECT_EQ(bytes_of_png(), plain);
}

// What the image library reads past its buffers for.
TEST(ImageReader, RefusesBmpFilesThatNameWhatTheyDoNotHold) {
  const TemporaryFolder folder;
  const auto bmp = [](std::int32_t bits, std::int32_t compression, std::int32_t colours) {
    return std::string("BM") + little({200, 0, 54}) +
           little({40, 4, 3, 1 + bits * 65536, compression, 128, 0, 0, colours, 0}) + std::string(146, '\x17');
  };
  const std::vector<std::tuple<std::string, std::string, std::string>> files = {
      {"runs24.bmp", bmp(24, 1, 0), "compressed"}, {"runs8.bmp", bmp(8, 1, 0), "compressed"},
      {"runs4.bmp", bmp(4, 2, 0), "compressed"},   {"fields.bmp", bmp(32, 3, 0), "compressed"},
      {"short8.bmp", bmp(8, 0, 3), "palette"},     {"short4.bmp", bmp(4, 0, 15), "palette"},
      {"long1.bmp", bmp(1, 0, -5), "palette"}};
  for (const auto& file : files) {
    const std::string& name = std::get<0>(file);
    const std::string& bytes = std::get<1>(file);
    const std::string& words = std::get<2>(file);
    write_bytes(folder / name, bytes);
    EXPECT_THAT(user_error_of([&] { ImageReader reader(folder / name); }), HasSubstr(words)) << name;
  }
}

TEST(ImageReader, RefusesImagesWithoutPixels) {
  const TemporaryFolder folder;
  const std::vector<std::pair<std::string, std::string>> files = {
      {"a.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 3 +X 0\n"},
      {"b.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n"},
      {"a.pgm", "P5 7 0 255\n"},
      {"a.ppm", "P6 0 7 255\n"},
      {"b.ppm", "P6 # no size at all"},
      {"a.png", png_header(0, 5)},
      {"a.exr", exr_header(0, 5, false)},
      {"a.tif", tiff_header(5, 0)},
      {"a.tga", std::string(18, '\0')}};
  for (const auto& file : files) {
    const std::string& name = file.first;
    const std::string& bytes = file.second;
    write_bytes(folder / name, bytes);
    EXPECT_THAT(user_error_of([&] { ImageReader reader(folder / name); }), HasSubstr("its header says")) << name;
  }
}

TEST(ImageReader, GivesAReasonForEveryTruncation) {
  const TemporaryFolder folder;
  for (const char* const name : {"a.exr", "a.tif", "a.png", "a.bmp", "a.tga", "a.hdr", "a.ppm"}) {
    OIIO::ImageSpec spec = spec_at(0, 0, name[2] == 'e' ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::UINT8);
    spec.nchannels = 3;
    spec.default_channel_names();
    const std::vector<float> values(static_cast<std::size_t>(width * height * 3), 0.5F);
    auto out = OIIO::ImageOutput::create(folder / name);
    ASSERT_TRUE(out && out->open(folder / name, spec));
    ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, values.data()) && out->close());
    const std::string whole = read_bytes(folder / name);
    for (const std::size_t kept :
         {std::size_t{0}, std::size_t{1}, std::size_t{7}, whole.size() / 5, whole.size() / 2}) {
      write_bytes(folder / name, whole.substr(0, kept));
      const std::string error = user_error_of([&] {
        ImageReader reader(folder / name);
        std::vector<std::byte> bytes(reader.shape(0).num_bytes());
        reader.read_rows(0, 0, reader.shape(0).height, bytes);
      });
      // The library fills what it does not find in some formats with zeros; it must not crash or be silent about a
      // header.
      if (kept < 8) {
        EXPECT_GT(error.size(), (folder / name).size() + 10) << name << " " << kept << ": " << error;
      }
    }
  }
}

TEST(ImageReader, NamesWhatIsNotRead) {
  const TemporaryFolder folder;
  write_bytes(folder / "a.jpg", "\xff\xd8\xff\xe0 and so on");
  EXPECT_THAT(user_error_of([&] { ImageReader reader(folder / "a.jpg"); }),
              AllOf(HasSubstr(".jpg: lossy"), HasSubstr("accepted: .png")));
  EXPECT_THAT(user_error_of([&] { ImageReader reader(folder.path()); }), HasSubstr("folder"));
}

TEST(ImageReader, TrustsTheContentsNotTheName) {
  const TemporaryFolder folder;
  write_with_library(folder / "a.exr", spec_at(0, 0));
  std::filesystem::rename(folder / "a.exr", folder / "a.png");
  EXPECT_EQ(read_numbers(folder / "a.png"), pixels());
}

}  // namespace
}  // namespace noiseloom
