// Files that others made: what fits loads, what does not is refused with what was found and what was expected.
#include "noiseloom/image/texture_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "noiseloom/files/npy.h"
#include "noiseloom/image/image_io.h"
#include "support/run_files.h"

namespace noiseloom {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

// Channel c of pixel i of an image.
std::uint8_t code(int c, std::size_t i) {
  return static_cast<std::uint8_t>(i * 29 + static_cast<std::size_t>(c) * 71 + 3);
}

void write_bytes_image(const std::string& path, int width, int height, int channels, bool grey = false) {
  std::vector<std::byte> bytes;
  for (std::size_t i = 0; i < static_cast<std::size_t>(width * height); ++i)
    for (int c = 0; c < channels; ++c) bytes.push_back(std::byte{c == 3 ? std::uint8_t{255} : code(grey ? 0 : c, i)});
  ImageJob job;
  job.block = {width, height, channels, PixelType::uint8, {}, channels == 4 ? 3 : -1};
  write_image(path, job, [&](int) { return std::span<const std::byte>(bytes); });
}

void write_float_image(const std::string& path, int width, int height, int channels, const std::vector<float>& values) {
  ImageJob job;
  job.format = ImageFormat::exr;
  job.block = {width, height, channels, PixelType::float32, {}, -1};
  write_image(path, job, [&](int) { return std::as_bytes(std::span(values)); });
}

TEST(LoadTexture, TakesRedOfScalarsStoredAsRgba) {
  const TemporaryFolder folder;
  write_bytes_image(folder / "grey.png", 11, 7, 4, true);
  const TextureFile file = load_texture(folder / "grey.png", small_config("uniform", "x = 11, y = 7"));
  ASSERT_EQ(file.texture.channels, 1);
  for (std::size_t i = 0; i < 77; ++i)
    EXPECT_FLOAT_EQ(file.texture.values[i], static_cast<float>((code(0, i) + 0.5) / 256));
  EXPECT_EQ(file.source, "one image, 8 bit");
}

// A direction for every pixel, stored as codes of 8 bits, and the codes themselves.
std::vector<std::byte> direction_codes(int count) {
  std::vector<std::byte> bytes;
  for (int i = 0; i < count; ++i) {
    const double z = 2 * (i + 0.5) / count - 1;
    const double angle = 2.4 * i;
    for (const double v : {std::sqrt(1 - z * z) * std::cos(angle), std::sqrt(1 - z * z) * std::sin(angle), z})
      bytes.push_back(std::byte(quantise(0.5 + 0.5 * v, 8)));
  }
  return bytes;
}

TEST(LoadTexture, NormalisesDirectionsOfImages) {
  const TemporaryFolder folder;
  const std::vector<std::byte> codes = direction_codes(77);
  ImageJob job;
  job.block = {11, 7, 3, PixelType::uint8, {}, -1};
  write_image(folder / "n.png", job, [&](int) { return std::span<const std::byte>(codes); });
  const Texture texture = load_texture(folder / "n.png", small_config("sphere", "x = 11, y = 7")).texture;
  for (std::size_t i = 0; i < 77; ++i) {
    double raw[3];
    double length = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      raw[c] = 2 * (std::to_integer<int>(codes[3 * i + c]) + 0.5) / 256 - 1;
      length += raw[c] * raw[c];
    }
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(texture.values[c * 77 + i], raw[c] / std::sqrt(length), 1e-6) << c << " of " << i;
  }
}

TEST(LoadTexture, SplitsAStripIntoSlices) {
  const TemporaryFolder folder;
  write_bytes_image(folder / "strip.png", 11, 21, 1);
  const TextureFile file = load_texture(folder / "strip.png", small_config("uniform"));
  ASSERT_EQ(file.texture.extents.num_slices(), 3);
  for (const SliceIndex s : first_indices<SliceIndex>(3))
    for (std::size_t i = 0; i < 77; ++i)
      EXPECT_FLOAT_EQ(file.texture.slice(s)[i],
                      static_cast<float>((code(0, i + 77 * static_cast<std::size_t>(s)) + 0.5) / 256));
}

TEST(LoadTexture, FindsASequenceFromItsFirstFile) {
  const TemporaryFolder folder;
  for (int s = 0; s < 3; ++s) write_bytes_image(folder / fmt::format("a_{}.png", s), 11, 7, 1);
  const RunConfig config = small_config("uniform");
  for (const std::string& name : {folder / "a_0.png", folder / "a_{}.png", folder.path()}) {
    const TextureFile file = load_texture(name, config);
    EXPECT_EQ(file.source, "3 images, 8 bit");
    EXPECT_THAT(file.notes, IsEmpty());
  }
  write_bytes_image(folder / "a_3.png", 11, 7, 1);
  EXPECT_THAT(load_texture(folder / "a_0.png", config).notes, Contains(HasSubstr("left out")));
  EXPECT_THAT(user_error_of([&] { load_texture(folder.path(), config); }),
              AllOf(HasSubstr("4 images"), HasSubstr("3 slices of 11 x 7")));
}

TEST(LoadTexture, SaysWhichSizeWasFoundAndExpected) {
  const TemporaryFolder folder;
  write_bytes_image(folder / "a.png", 11, 20, 1);
  EXPECT_THAT(user_error_of([&] { load_texture(folder / "a.png", small_config("uniform")); }),
              AllOf(HasSubstr("a.png: 11 x 20 pixels"), HasSubstr("3 slices of 11 x 7")));
  write_bytes_image(folder / "b_0.png", 11, 7, 1);
  write_bytes_image(folder / "b_1.png", 11, 7, 1);
  write_bytes_image(folder / "b_2.png", 11, 7, 3);
  EXPECT_THAT(user_error_of([&] { load_texture(folder / "b_{}.png", small_config("uniform")); }),
              AllOf(HasSubstr("b_2.png"), HasSubstr("3 channels")));
}

TEST(LoadTexture, SaysWhichChannelsWereFoundAndExpected) {
  const TemporaryFolder folder;
  write_bytes_image(folder / "a.png", 11, 7, 1);
  write_bytes_image(folder / "rgb.png", 11, 7, 3);
  EXPECT_THAT(user_error_of([&] { load_texture(folder / "a.png", small_config("sphere", "x = 11, y = 7")); }),
              HasSubstr("1 channel (Y), but samples of the config have 3"));
  EXPECT_THAT(user_error_of([&] { load_texture(folder / "rgb.png", small_config("vector4", "x = 11, y = 7")); }),
              HasSubstr("3 channels (R, G, B), but samples of the config have 4"));
}

TEST(LoadTexture, DecodesSignedFloatsOnlyWhereNoneIsNegative) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("disk", "x = 2, y = 1");
  write_float_image(folder / "signed.exr", 2, 1, 2, {-0.5F, 0.25F, 0.5F, 0.75F});
  EXPECT_FLOAT_EQ(load_texture(folder / "signed.exr", config).texture.values[0], -0.5F);
  write_float_image(folder / "unsigned.exr", 2, 1, 2, {0.25F, 0.625F, 0.75F, 0.875F});
  const TextureFile decoded = load_texture(folder / "unsigned.exr", config);
  EXPECT_FLOAT_EQ(decoded.texture.values[0], -0.5F);
  EXPECT_FLOAT_EQ(decoded.texture.values[2], 0.25F);
  EXPECT_THAT(decoded.notes, Contains(HasSubstr("2 v - 1")));
}

TEST(LoadTexture, NamesThePlaceOfAValueThatIsNotFinite) {
  const TemporaryFolder folder;
  std::vector<float> values(2 * 3 * 5 * 2, 0.5F);
  values[((1 * 3 + 2) * 5 + 4) * 2 + 1] = std::numeric_limits<float>::quiet_NaN();
  const std::vector<std::int64_t> shape = {2, 3, 5, 2};
  write_npy(folder / "a.npy", shape, values);
  EXPECT_THAT(user_error_of([&] { load_texture(folder / "a.npy", small_config("vector2", "x = 5, y = 3, t = 2")); }),
              AllOf(HasSubstr("x 4, y 2, slice 1, channel 1"), HasSubstr("nan")));
}

TEST(LoadTexture, RefusesADirectionOfLengthZero) {
  const TemporaryFolder folder;
  std::vector<float> values(1 * 3 * 5 * 3, -0.57735F);
  for (std::size_t c = 0; c < 3; ++c) values[(1 * 5 + 2) * 3 + c] = 0;
  const std::vector<std::int64_t> shape = {3, 5, 3};
  write_npy(folder / "a.npy", shape, values);
  EXPECT_THAT(user_error_of([&] { load_texture(folder / "a.npy", small_config("sphere", "x = 5, y = 3")); }),
              HasSubstr("x 2, y 1, slice 0"));
}

TEST(LoadTexture, FitsNpyShapesToTheConfig) {
  const TemporaryFolder folder;
  const RunConfig scalar = small_config("uniform", "x = 5, y = 3, t = 2, z = 2");
  std::vector<float> values;
  for (int i = 0; i < 60; ++i) values.push_back(static_cast<float>(i) / 60);
  const auto load = [&](std::vector<std::int64_t> shape, const RunConfig& config) {
    write_npy(folder / "a.npy", shape, values);
    return load_texture(folder / "a.npy", config).texture;
  };
  for (const std::vector<std::int64_t>& shape :
       {std::vector<std::int64_t>{2, 2, 3, 5}, {4, 3, 5}, {2, 2, 3, 5, 1}, {4, 3, 5, 1}}) {
    const Texture texture = load(shape, scalar);
    EXPECT_EQ(texture.extents, scalar.problem.extents);
    EXPECT_EQ(texture.values, values);
  }
  EXPECT_EQ(load({2, 3, 5, 2}, small_config("vector2", "x = 5, y = 3, t = 2")).values[15], values[1]);
  EXPECT_THAT(user_error_of([&] {
                load({4, 5, 3}, scalar);
              }),
              AllOf(HasSubstr("shape [4, 5, 3]"), HasSubstr("[2, 2, 3, 5]")));
  EXPECT_THAT(user_error_of([&] { load({60}, scalar); }), HasSubstr("shape [60]"));
}

TEST(LoadTexture, TellsTheTypeOfRawNumbersByTheirSize) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("uniform", "x = 5, y = 3");
  std::string bytes;
  for (int i = 0; i < 15; ++i) bytes += static_cast<char>(16 * i + 7);
  write_bytes(folder / "a.raw", bytes);
  const Texture texture = load_texture(folder / "a.raw", config).texture;
  for (std::size_t i = 0; i < 15; ++i)
    EXPECT_FLOAT_EQ(texture.values[i], static_cast<float>((16 * static_cast<double>(i) + 7.5) / 256));
  write_bytes(folder / "b.raw", bytes.substr(1));
  EXPECT_THAT(user_error_of([&] { load_texture(folder / "b.raw", config); }),
              AllOf(HasSubstr("14 bytes"), HasSubstr("15 bytes with 8 bits, 30 with 16, 60 as float")));
  EXPECT_THAT(user_error_of([&] { load_texture(folder / "a.raw", std::nullopt); }), HasSubstr("--config"));
}

TEST(LoadTexture, TakesOnlyTheFilterOfAConfigForARunFile) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("vector2");
  const Texture texture = start_texture(config);
  write_run_file(folder / "run.h5", config, texture);
  RunConfig other = small_config("sphere");
  other.problem.filter.groups[0].kernel.size = 5;
  const TextureFile file = load_texture(folder / "run.h5", other);
  EXPECT_EQ(file.texture.values, texture.values);
  EXPECT_EQ(file.config->problem.samples.space, "vector2");
  EXPECT_EQ(file.config->problem.filter.groups[0].kernel.size, 5);
  EXPECT_EQ(file.history.size(), 3U);
  EXPECT_EQ(file.checksum.size(), 16U);
}

TEST(LoadTexture, GuessesSizeAndChannelsWithoutAConfig) {
  const TemporaryFolder folder;
  write_bytes_image(folder / "strip.png", 7, 21, 4, true);
  const TextureFile strip = load_texture(folder / "strip.png", std::nullopt);
  EXPECT_EQ(strip.texture.extents, Extents({7, 7, 3}));
  EXPECT_EQ(strip.texture.channels, 1);
  EXPECT_THAT(strip.notes, Contains(HasSubstr("strip of 3 slices")));
  write_bytes_image(folder / "wide.png", 9, 7, 3);
  const TextureFile wide = load_texture(folder / "wide.png", std::nullopt);
  EXPECT_EQ(wide.texture.extents, Extents({9, 7}));
  EXPECT_EQ(wide.texture.channels, 3);
}

TEST(LoadTexture, RefusesFilesThatAreNotThereOrNotRunFiles) {
  const TemporaryFolder folder;
  EXPECT_THAT(user_error_of([&] { load_texture(folder / "none.png", std::nullopt); }), HasSubstr("no such file"));
  for (const std::string place : {"%3d", "$F3", "@@@", "<frame>", "{0}", "{000..004}"})  // as other programs write it
    EXPECT_THAT(user_error_of([&] { load_texture(folder / ("none_" + place + ".png"), std::nullopt); }),
                AllOf(HasSubstr("no such file"), HasSubstr("\"" + place + "\" is no place for the number of a slice"),
                      HasSubstr("{slice:03}, {}, %d, %03d, %i, ####")));
  write_bytes(folder / "bad.h5", "nothing of the kind");
  EXPECT_THAT(user_error_of([&] { load_texture(folder / "bad.h5", std::nullopt); }), HasSubstr("not a run file"));
}

}  // namespace
}  // namespace noiseloom
