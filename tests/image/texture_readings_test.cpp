// Files that can be read in more than one way: the right one is taken, or the user is asked with the choices named.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "image/texture_readings.h"
#include "noiseloom/files/npy.h"
#include "noiseloom/image/image_io.h"
#include "noiseloom/image/sample_check.h"
#include "noiseloom/image/texture_file.h"

namespace noiseloom {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(Headerless, FloatsAreKnownByTheirValuesInEitherByteOrder) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("vector3", "x = 13, y = 7");
  const std::vector<float> values = noise_floats(13 * 7 * 3);
  for (const bool big_endian : {false, true}) {
    write_bytes(folder / "a.raw", raw(values, big_endian));
    const TextureFile file = load_texture(folder / "a.raw", config);
    EXPECT_EQ(file.source, big_endian ? "raw array, float32bex3" : "raw array, float32x3");
    EXPECT_EQ(interleaved_slice(file.texture, SliceIndex(0)), values);
  }
}

// Read as doubles, these floats in the other byte order are so small that they vanish.
TEST(Headerless, NumbersThatVanishAreNoReading) {
  const TemporaryFolder folder;
  std::vector<float> values;
  for (std::size_t i = 0; i < 77 * 2; ++i) values.push_back(static_cast<float>(std::floor(256 * noise(i)) / 256));
  write_bytes(folder / "a.raw", raw(values, true));
  EXPECT_EQ(load_texture(folder / "a.raw", small_config("vector2", "x = 11, y = 7")).source, "raw array, float32bex2");
}

TEST(Headerless, SixteenBitsAreAskedFor) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("uniform", "x = 13, y = 7, t = 3");
  std::vector<std::uint16_t> codes;
  for (std::size_t i = 0; i < 13 * 7 * 3; ++i) codes.push_back(static_cast<std::uint16_t>(65536 * noise(i)));
  for (const bool big_endian : {false, true}) {
    write_bytes(folder / "a.bin", raw(codes, big_endian));
    EXPECT_THAT(error_of(folder / "a.bin", config),
                AllOf(HasSubstr("546 bytes for 3 slices of 13 x 7"), HasSubstr("--type uint16,"),
                      HasSubstr("--type uint16be"), HasSubstr("--type uint8x2")));
    const TextureReading reading{.type = big_endian ? "uint16be" : "uint16"};
    const Texture texture = load_texture(folder / "a.bin", config, reading).texture;
    for (std::size_t i = 0; i < codes.size(); ++i)
      ASSERT_FLOAT_EQ(texture.values[i], static_cast<float>((codes[i] + 0.5) / 65536)) << i;
  }
}

TEST(Headerless, FourBytesForTwoValuesAreAskedFor) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("vector2", "x = 11, y = 7");
  std::string bytes;
  for (std::size_t i = 0; i < 77 * 4; ++i) bytes += static_cast<char>(static_cast<std::uint8_t>(256 * noise(i)));
  write_bytes(folder / "a.raw", bytes);
  EXPECT_THAT(error_of(folder / "a.raw", config),
              AllOf(HasSubstr("--type uint8x4"), HasSubstr("--type uint16x2"), HasSubstr("--type uint16bex2")));
  const TextureFile file = load_texture(folder / "a.raw", config, {.type = "uint8x4", .channels = "2,3"});
  EXPECT_FLOAT_EQ(file.texture.values[0], static_cast<float>((std::floor(256 * noise(2)) + 0.5) / 256));
  EXPECT_THAT(file.further_channels, ElementsAre("0", "1"));
}

TEST(Headerless, HalfFloatsAndDoublesAreRead) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("uniform", "x = 11, y = 7");
  std::vector<std::uint16_t> halves;  // 0.5 to 1
  std::vector<double> doubles;
  for (std::size_t i = 0; i < 77; ++i) {
    halves.push_back(static_cast<std::uint16_t>(0x3800 + 1024 * noise(i)));
    doubles.push_back(noise(i));
  }
  write_bytes(folder / "a.raw", raw(halves));
  const TextureFile half = load_texture(folder / "a.raw", config);
  EXPECT_EQ(half.source, "raw array, float16");
  EXPECT_FLOAT_EQ(half.texture.values[3], static_cast<float>(0.5 + std::floor(1024 * noise(3)) / 2048));
  write_bytes(folder / "a.raw", raw(doubles));
  EXPECT_FLOAT_EQ(load_texture(folder / "a.raw", config).texture.values[3], static_cast<float>(noise(3)));
}

TEST(Headerless, TypesAreNamedWhereTheyAreWrong) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("uniform", "x = 11, y = 7");
  write_bytes(folder / "a.raw", std::string(77, 'x'));
  for (const char* const type : {"int8", "uint8x0", "uint8x", "uint16le", "x2"})
    EXPECT_THAT(error_of(folder / "a.raw", config, {.type = type}), HasSubstr("accepted: uint8, uint16")) << type;
  EXPECT_THAT(error_of(folder / "a.raw", config, {.type = "float32"}), HasSubstr("77 bytes, but --type float32"));
}

TEST(Headerless, AJsonOfSomethingElseIsLeftAlone) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("uniform", "x = 11, y = 7");
  write_bytes(folder / "a.bin", std::string(77, 'x'));
  for (const char* const text : {"{\"camera\": \"left\", \"type\": \"pinhole\"}", "[1, 2]", "no JSON"}) {
    write_bytes(folder / "a.json", text);
    const TextureFile file = load_texture(folder / "a.bin", config);
    EXPECT_EQ(file.source, "raw array, uint8");
    EXPECT_THAT(file.notes, Contains(HasSubstr("a.json"))) << text;
    EXPECT_THAT(user_error_of([&] { load_texture(folder / "a.bin", std::nullopt); }),
                AllOf(HasSubstr("a.json"), HasSubstr("--type")));
  }
}

TEST(Channels, AScalarOfSeveralIsSaidAndCanBeChosen) {
  const TemporaryFolder folder;
  write_codes(folder / "a.png", 11, 7, 4, [](int x, int y, int c) { return 3 * x + 29 * y + 60 * c * x; });
  const RunConfig config = small_config("uniform", "x = 11, y = 7");
  const TextureFile red = load_texture(folder / "a.png", config);
  EXPECT_THAT(red.further_channels, ElementsAre("G", "B", "A"));
  EXPECT_THAT(red.notes, Contains(HasSubstr("G, B, A hold values of their own")));
  for (const char* const name : {"B", "b", "2"}) {
    const TextureFile blue = load_texture(folder / "a.png", config, {.channels = name});
    EXPECT_FLOAT_EQ(blue.texture.values[1], static_cast<float>((123 + 0.5) / 256)) << name;
    EXPECT_THAT(blue.further_channels, ElementsAre("R", "G", "A"));
  }
  EXPECT_THAT(error_of(folder / "a.png", config, {.channels = "X"}),
              HasSubstr("no channel \"X\"; the file has R, G, B, A"));
  EXPECT_THAT(error_of(folder / "a.png", config, {.channels = "RG"}), HasSubstr("names 2 channels"));
}

TEST(Channels, GreyAsRgbaAndUnusedOnesAreNotWorthAWord) {
  const TemporaryFolder folder;
  write_codes(folder / "grey.png", 11, 7, 4, [](int x, int y, int c) { return c == 3 ? 255 : 3 * x + 29 * y; });
  EXPECT_THAT(load_texture(folder / "grey.png", small_config("uniform", "x = 11, y = 7")).notes, IsEmpty());
  write_codes(folder / "two.png", 11, 7, 3,
              [](int x, int y, int c) { return c == 2 ? 0 : 3 * x + 29 * y + 7 * c * x; });
  EXPECT_THAT(load_texture(folder / "two.png", small_config("vector2", "x = 11, y = 7")).notes, IsEmpty());
}

// Directions in the plane, from a list: the third channel of the image is none of theirs.
TEST(Channels, OfAListAreAsManyAsTheListHas) {
  const TemporaryFolder folder;
  std::vector<float> list;
  for (int i = 0; i < 77; ++i)
    for (const double phase : {0.0, std::numbers::pi / 2})
      list.push_back(static_cast<float>(std::cos(0.08 * i - phase)));
  const std::vector<std::int64_t> shape = {77, 2};
  write_npy(folder / "list.npy", shape, list);
  const RunConfig config =
      parse_config("[texture]\nsize = { x = 11, y = 7 }\nsamples = { file = \"" + folder.path() +
                       "/list.npy\", distance = \"angle\" }\n[filter]\ngroups = [ { axes = \"xy\", "
                       "kernel = \"box\", size = 3 } ]\n",
                   "test.toml", "", {});
  write_codes(folder / "a.png", 11, 7, 3, [](int x, int y, int c) {
    const double angle = 0.08 * (x + 11 * y);
    return c == 2 ? 0 : quantise(0.5 + 0.5 * (c == 0 ? std::cos(angle) : std::sin(angle)), 8);
  });
  const Texture texture = load_texture(folder / "a.png", config).texture;
  ASSERT_EQ(texture.channels, 2);
  EXPECT_NEAR(texture.values[5], std::cos(0.4), 0.01);
  EXPECT_NEAR(texture.values[77 + 5], std::sin(0.4), 0.01);
}

TEST(Space, AnglesInOtherUnitsAreRefusedAndNamed) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("circle", "x = 11, y = 7");
  const std::vector<std::int64_t> shape = {7, 11};
  const auto error_for = [&](double scale, double shift) {
    std::vector<float> values;
    for (std::size_t i = 0; i < 77; ++i) values.push_back(static_cast<float>(scale * noise(i) + shift));
    write_npy(folder / "a.npy", shape, values);
    return error_of(folder / "a.npy", config);
  };
  EXPECT_EQ(error_for(1, 0), "");
  EXPECT_THAT(error_for(360, 0), AllOf(HasSubstr("degrees"), HasSubstr("divide them by 360"), HasSubstr("x 0, y 0")));
  EXPECT_THAT(error_for(2 * std::numbers::pi, 0), HasSubstr("radians? divide them by 2 pi"));
  EXPECT_THAT(error_for(2 * std::numbers::pi, -std::numbers::pi), HasSubstr("divide them by 2 pi and add 0.5"));
  EXPECT_THAT(error_for(2, -1), HasSubstr("halve them and add 0.5"));
}

TEST(Space, CountsWhatLiesOutside) {
  const TemporaryFolder folder;
  std::vector<float> values = noise_floats(77);
  values[20] = 1.25F;
  values[50] = -0.25F;
  const std::vector<std::int64_t> shape = {7, 11};
  write_npy(folder / "a.npy", shape, values);
  EXPECT_THAT(
      error_of(folder / "a.npy", small_config("uniform", "x = 11, y = 7")),
      AllOf(HasSubstr("x 9, y 1, slice 0 is 1.25"), HasSubstr("2 of 77 lie outside"), HasSubstr("from -0.25 to 1.25")));
  EXPECT_THAT(error_of(folder / "a.npy", small_config("tent", "x = 11, y = 7")), HasSubstr("2 of 77"));
}

TEST(Space, LengthsAreHeldToWhatTheFileCanHold) {
  const RunConfig config = small_config("sphere", "x = 2, y = 1");
  Texture texture = make_texture(config.problem.extents, 3);
  texture.values = {0.6F, 0, 0.8F, 1, 0, 0};  // planes of x, y, z
  const SampleSpec& sphere = config.problem.samples;
  EXPECT_EQ(user_error_of([&] { check_in_space(texture, sphere, 0, "a"); }), "");
  texture.values[0] = 0.62F;
  EXPECT_THAT(user_error_of([&] { check_in_space(texture, sphere, 0, "a"); }), HasSubstr("of length 1.01213"));
  EXPECT_EQ(user_error_of([&] { check_in_space(texture, sphere, 2.0 / 256, "a"); }), "");
  EXPECT_NE(user_error_of([&] { check_in_space(texture, sphere, 2.0 / 65536, "a"); }), "");
  texture.values = {0.6F, 0, 0, 0, -0.8F, 1};
  EXPECT_THAT(user_error_of(
                  [&] { check_in_space(texture, small_config("hemisphere", "x = 2, y = 1").problem.samples, 0, "a"); }),
              HasSubstr("z >= 0"));
  Texture points = make_texture(config.problem.extents, 2);
  points.values = {0.6F, 0.9F, 0.8F, 0.5F};
  EXPECT_THAT(
      user_error_of([&] { check_in_space(points, small_config("disk", "x = 2, y = 1").problem.samples, 0, "a"); }),
      HasSubstr("x 1, y 0, slice 0"));
}

TEST(Space, HugeNumbersAreRefusedWhateverTheSamples) {
  const TemporaryFolder folder;
  std::vector<float> values = noise_floats(77);
  values[3] = 2e38F;
  const std::vector<std::int64_t> shape = {7, 11};
  write_npy(folder / "a.npy", shape, values);
  EXPECT_THAT(error_of(folder / "a.npy", small_config("gauss", "x = 11, y = 7")), HasSubstr("values within 1e18"));
}

Texture load_array(const TemporaryFolder& folder, const std::vector<std::int64_t>& shape,
                   const std::optional<RunConfig>& config, const TextureReading& reading = {}) {
  std::int64_t count = 1;
  for (const std::int64_t n : shape) count *= n;
  write_npy(folder / "a.npy", shape, noise_floats(static_cast<std::size_t>(count)));
  return load_texture(folder / "a.npy", config, reading).texture;
}

TEST(Array, SlicesMayComeLast) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("uniform", "x = 5, y = 3, t = 4");
  const Texture texture = load_array(folder, {3, 5, 4}, config);
  for (std::size_t t = 0; t < 4; ++t)
    for (std::size_t i = 0; i < 15; ++i)
      ASSERT_EQ(texture.values[15 * t + i], static_cast<float>(noise(4 * i + t))) << t << " " << i;
}

TEST(Array, ACubeIsAskedFor) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("uniform", "x = 4, y = 4, t = 4");
  EXPECT_THAT(user_error_of([&] {
                load_array(folder, {4, 4, 4}, config);
              }),
              AllOf(HasSubstr("--axes tyx"), HasSubstr("--axes yxt")));
  EXPECT_EQ(load_array(folder, {4, 4, 4}, config, {.axes = "tyx"}).values[1], static_cast<float>(noise(1)));
  EXPECT_EQ(load_array(folder, {4, 4, 4}, config, {.axes = "yxt"}).values[1], static_cast<float>(noise(4)));
  EXPECT_EQ(load_array(folder, {4, 4, 4}, config, {.axes = "xyt"}).values[1], static_cast<float>(noise(16)));
  // What export writes has a dimension for the channel, and is not in doubt.
  EXPECT_EQ(load_array(folder, {4, 4, 4, 1}, config).values[1], static_cast<float>(noise(1)));
}

TEST(Array, WithoutAConfigSquareSlicesAreLikelier) {
  const TemporaryFolder folder;
  EXPECT_EQ(load_array(folder, {6, 9, 9}, std::nullopt).extents, Extents({9, 9, 6}));
  EXPECT_EQ(load_array(folder, {9, 9, 3}, std::nullopt).channels, 3);
  EXPECT_EQ(load_array(folder, {9, 10, 11}, std::nullopt).extents, Extents({11, 10, 9}));
  EXPECT_THAT(user_error_of([&] {
                load_array(folder, {9, 9, 11}, std::nullopt);
              }),
              AllOf(HasSubstr("9 slices of 11 x 9 (--axes tyx)"), HasSubstr("11 slices of 9 x 9 (--axes yxt)")));
  EXPECT_EQ(load_array(folder, {9, 9, 11}, std::nullopt, {.axes = "y,x,time"}).extents, Extents({9, 9, 11}));
  EXPECT_THAT(load_texture(folder / "a.npy", std::nullopt, {.axes = "tyx"}).notes,
              Contains(HasSubstr("was taken as 9 slices of 11 x 9 (tyx)")));
}

TEST(Array, NamedAxesFindTheirPlace) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("uniform", "x = 5, y = 3, t = 2, z = 4");
  const Texture plain = load_array(folder, {4, 2, 3, 5}, config);
  EXPECT_EQ(plain.values[15], static_cast<float>(noise(15)));
  const Texture swapped = load_array(folder, {2, 4, 3, 5}, config, {.axes = "tzyx"});
  EXPECT_EQ(swapped.values[15], static_cast<float>(noise(4 * 15)));      // t = 1
  EXPECT_EQ(swapped.values[2 * 15], static_cast<float>(noise(1 * 15)));  // z = 1
  for (const char* const axes : {"tzy", "ttyx", "tzyw", "t,z,y"})
    EXPECT_THAT(user_error_of([&] {
                  load_array(folder, {2, 4, 3, 5}, config, {.axes = axes});
                }),
                HasSubstr("must name the 4 dimensions"))
        << axes;
}

template <class T>
void write_integers(const std::string& path, const std::string& type, const std::vector<T>& values) {
  std::string dict = "{'descr': '" + type + "', 'fortran_order': False, 'shape': (7, 11), }\n";
  std::string bytes("\x93NUMPY\x01\x00", 8);
  bytes += static_cast<char>(dict.size());
  bytes += '\0';
  write_bytes(path, bytes + dict + raw(values));
}

TEST(Array, IntegersAreCodesOrPlacesInAnOrder) {
  const TemporaryFolder folder;
  const RunConfig config = small_config("uniform", "x = 11, y = 7");
  std::vector<std::uint8_t> codes;
  std::vector<std::int64_t> places;
  std::vector<std::uint16_t> wide;
  std::vector<std::int32_t> negative;
  for (int i = 0; i < 77; ++i) {
    codes.push_back(static_cast<std::uint8_t>(3 * i));
    places.push_back(i * 30 % 77);
    wide.push_back(static_cast<std::uint16_t>(800 * i));
    negative.push_back(i - 5);
  }
  write_integers(folder / "a.npy", "|u1", codes);
  EXPECT_FLOAT_EQ(load_texture(folder / "a.npy", config).texture.values[2], 6.5F / 256);
  EXPECT_THAT(load_texture(folder / "a.npy", config).notes, Contains(HasSubstr("8 bit codes")));
  write_integers(folder / "a.npy", "<i8", places);
  EXPECT_FLOAT_EQ(load_texture(folder / "a.npy", config).texture.values[2], 60.5F / 77);
  write_integers(folder / "a.npy", "<u2", wide);
  EXPECT_FLOAT_EQ(load_texture(folder / "a.npy", config).texture.values[2], 1600.5F / 65536);
  EXPECT_THAT(error_of(folder / "a.npy", config, {.type = "uint8"}), HasSubstr("integers up to 60800"));
  write_integers(folder / "a.npy", "<i4", negative);
  EXPECT_THAT(error_of(folder / "a.npy", config), HasSubstr("from -5 to 71"));
  // Whole numbers stored as floats say nothing of their codes.
  std::vector<float> whole;
  for (int i = 0; i < 77; ++i) whole.push_back(static_cast<float>(3 * i));
  const std::vector<std::int64_t> shape = {7, 11};
  write_npy(folder / "a.npy", shape, whole);
  EXPECT_THAT(error_of(folder / "a.npy", config), HasSubstr("codes of 8 bits?"));
}

}  // namespace
}  // namespace noiseloom
