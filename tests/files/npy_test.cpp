#include "noiseloom/files/npy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

using ::testing::HasSubstr;

std::string temporary(const std::string& name) {
  return (std::filesystem::path(::testing::TempDir()) / ("noiseloom_npy_" + std::to_string(::getpid()) + "_" + name))
      .string();
}

void write_bytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

template <class T>
std::string raw(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

// A version 1 file, built by hand from the format's description.
std::string npy_file(const std::string& dict, const std::string& values) {
  std::string file("\x93NUMPY\x01\x00", 8);
  file += static_cast<char>(dict.size() & 0xff);
  file += static_cast<char>(dict.size() >> 8);
  return file + dict + values;
}

std::string dict(const std::string& type, const std::string& shape, const std::string& order = "False") {
  return "{'descr': '" + type + "', 'fortran_order': " + order + ", 'shape': " + shape + ", }\n";
}

std::string message_of_reading(const std::string& bytes) {
  const std::string path = temporary("faulty.npy");
  write_bytes(path, bytes);
  try {
    read_npy(path);
  } catch (const UserError& error) {
    EXPECT_EQ(error.faults().at(0).where, path);
    return error.faults().at(0).text;
  }
  return "";
}

TEST(Npy, WritesWhatItReadsBitForBit) {
  const float denormal = std::numeric_limits<float>::denorm_min();
  const std::vector<float> values = {0.1F, -0.0F, denormal, -INFINITY, 3e38F, 7};
  const std::string path = temporary("round_trip.npy");
  for (const std::vector<std::int64_t>& shape : {std::vector<std::int64_t>{6}, {2, 3}, {1, 3, 2, 1}}) {
    write_npy(path, shape, values);
    const NpyArray array = read_npy(path);
    EXPECT_EQ(array.shape, shape);
    ASSERT_EQ(array.values.size(), values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
      EXPECT_EQ(std::bit_cast<std::uint32_t>(static_cast<float>(array.values[i])),
                std::bit_cast<std::uint32_t>(values[i]));
    }
  }
}

TEST(Npy, HeaderIsAlignedAndEndsInANewline) {
  for (const std::vector<std::int64_t>& shape :
       {std::vector<std::int64_t>{}, {5}, {64, 128, 128, 3}, {1'000'000'007, 1'000'003, 101}}) {
    const std::string header = npy_float32_header(shape);
    EXPECT_EQ(header.size() % 64, 0U);
    EXPECT_EQ(header.back(), '\n');
  }
  EXPECT_THAT(npy_float32_header(std::vector<std::int64_t>{5}), HasSubstr("'shape': (5,), }"));
  EXPECT_THAT(npy_float32_header(std::vector<std::int64_t>{7, 5}), HasSubstr("'shape': (7, 5), }"));
  EXPECT_THAT(npy_float32_header(std::vector<std::int64_t>{}), HasSubstr("'shape': (), }"));
}

template <class T>
void expect_reads(const std::string& type, const std::vector<T>& values) {
  const std::string path = temporary("typed.npy");
  write_bytes(path, npy_file(dict(type, "(" + std::to_string(values.size()) + ",)"), raw(values)));
  EXPECT_EQ(read_npy(path).values, std::vector<double>(values.begin(), values.end())) << type;
}

TEST(Npy, ReadsEveryPlainNumberType) {
  expect_reads<float>("<f4", {0.5F, -1e-40F});
  expect_reads<double>("<f8", {0.1, -1e300, 5e-324});
  expect_reads<std::int8_t>("|i1", {-128, 127});
  expect_reads<std::uint8_t>("|u1", {0, 255});
  expect_reads<std::int16_t>("<i2", {-32768, 32767});
  expect_reads<std::uint16_t>("<u2", {0, 65535});
  expect_reads<std::int32_t>("<i4", {std::numeric_limits<std::int32_t>::min(), 7});
  expect_reads<std::uint32_t>("<u4", {std::numeric_limits<std::uint32_t>::max()});
  expect_reads<std::int64_t>("<i8", {-(std::int64_t{1} << 53), std::int64_t{1} << 53});
  expect_reads<std::uint64_t>("<u8", {std::uint64_t{1} << 53});
}

template <class T>
std::string reversed_raw(const std::vector<T>& values) {
  std::string bytes = raw(values);
  for (std::size_t at = 0; at < bytes.size(); at += sizeof(T))
    std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                 bytes.begin() + static_cast<std::ptrdiff_t>(at + sizeof(T)));
  return bytes;
}

template <class T>
void expect_reads_big_endian(const std::string& type, const std::vector<T>& values) {
  const std::string path = temporary("big_endian.npy");
  write_bytes(path, npy_file(dict(type, "(" + std::to_string(values.size()) + ",)"), reversed_raw(values)));
  EXPECT_EQ(read_npy(path).values, std::vector<double>(values.begin(), values.end())) << type;
}

TEST(Npy, ReadsBigEndianNumbers) {
  expect_reads_big_endian<float>(">f4", {0.7F, -1e-40F, 3e38F});
  expect_reads_big_endian<double>(">f8", {0.1, -1e300});
  expect_reads_big_endian<std::int16_t>(">i2", {-2, 513});
  expect_reads_big_endian<std::uint16_t>(">u2", {258, 65279});
  expect_reads_big_endian<std::int32_t>(">i4", {-7, 1 << 20});
  expect_reads_big_endian<std::uint32_t>(">u4", {0xfffefdfc});
  expect_reads_big_endian<std::int64_t>(">i8", {-(std::int64_t{1} << 53), 5});
  expect_reads_big_endian<std::uint64_t>(">u8", {std::uint64_t{1} << 52});
}

TEST(Npy, ReadsHalfFloats) {
  // Bits and values as IEEE 754 defines them: zero, the least and the largest denormal, 1, just above 1, the largest,
  // -2, 1/3 rounded.
  const std::vector<std::uint16_t> bits = {0x0000, 0x0001, 0x03ff, 0x3c00, 0x3c01, 0x7bff, 0xc000, 0x3555};
  const std::vector<double> values = {0, 0x1p-24, 1023 * 0x1p-24, 1, 1 + 0x1p-10, 65504, -2, 1365 * 0x1p-12};
  const std::string path = temporary("half.npy");
  write_bytes(path, npy_file(dict("<f2", "(8,)"), raw(bits)));
  EXPECT_EQ(read_npy(path).values, values);
  EXPECT_EQ(read_npy(path).type, (NumberType{NumberType::Kind::floating, 2, false}));
  write_bytes(path, npy_file(dict(">f2", "(8,)"), reversed_raw(bits)));
  EXPECT_EQ(read_npy(path).values, values);
  EXPECT_TRUE(std::isinf(half_to_double(0xfc00)));
  EXPECT_TRUE(std::isnan(half_to_double(0x7c01)));
}

TEST(Npy, PutsFortranOrderIntoCOrder) {
  const std::vector<std::int64_t> shape = {2, 3, 5};
  std::vector<float> stored(30);  // the first index varies fastest
  std::vector<double> expected;
  for (std::size_t a = 0; a < 2; ++a)
    for (std::size_t b = 0; b < 3; ++b)
      for (std::size_t c = 0; c < 5; ++c) {
        stored[a + 2 * (b + 3 * c)] = static_cast<float>(100 * a + 10 * b + c);
        expected.push_back(static_cast<double>(100 * a + 10 * b + c));
      }
  const std::string path = temporary("fortran.npy");
  write_bytes(path, npy_file(dict("<f4", "(2, 3, 5)", "True"), raw(stored)));
  EXPECT_EQ(read_npy(path).shape, shape);
  EXPECT_EQ(read_npy(path).values, expected);
  write_bytes(path, npy_file(dict(">f4", "(2, 3, 5)", "True"), reversed_raw(stored)));
  EXPECT_EQ(read_npy(path).values, expected);
}

TEST(Npy, TellsTheShapeAlone) {
  const std::string path = temporary("shape.npy");
  write_bytes(path, npy_file(dict("<f4", "(7, 5, 3)"), std::string(4 * 7 * 5 * 3, '\0')));
  EXPECT_EQ(read_npy_shape(path), (std::vector<std::int64_t>{7, 5, 3}));
  // Of a file that is too short it is not told, whatever the header says.
  write_bytes(path, npy_file(dict("<f4", "(7, 5, 3)"), std::string(4 * 7 * 5, '\0')));
  EXPECT_THROW(read_npy_shape(path), UserError);
  write_bytes(path, npy_file(dict("<U8", "(7, 5, 3)"), ""));
  EXPECT_THROW(read_npy_shape(path), UserError);
}

TEST(Npy, ReadsOtherSpellingsOfTheHeader) {
  const std::string path = temporary("spelling.npy");
  const std::string reordered = R"({"shape":(2,3),"fortran_order":False,"descr":"<f4"})";
  std::string file("\x93NUMPY\x02\x00", 8);
  file += raw<std::uint32_t>({static_cast<std::uint32_t>(reordered.size())}) + reordered;
  write_bytes(path, file + raw<float>({1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(read_npy(path).shape, (std::vector<std::int64_t>{2, 3}));

  // One dimension is stored alike in both orders.
  write_bytes(path, npy_file(dict("<f4", "(2,)", "True"), raw<float>({1, 2})));
  EXPECT_EQ(read_npy(path).values, (std::vector<double>{1, 2}));
  write_bytes(path, npy_file(dict("<f4", "()"), raw<float>({4})));
  EXPECT_EQ(read_npy(path).values, (std::vector<double>{4}));
  write_bytes(path, npy_file(dict("<f4", "(0, 3)"), ""));
  EXPECT_TRUE(read_npy(path).values.empty());
}

TEST(Npy, RefusesWhatItCannotReadSayingWhatItFound) {
  const std::string two = raw<float>({1, 2});
  EXPECT_EQ(message_of_reading("P5 2 2 255"), "not a .npy file");
  EXPECT_EQ(message_of_reading(""), "not a .npy file");
  EXPECT_THAT(message_of_reading(std::string("\x93NUMPY\x09\x00\x00\x00", 10)),
              HasSubstr("format 9; accepted: 1 to 3"));
  EXPECT_THAT(message_of_reading(npy_file(dict("<c8", "(1,)"), two)), HasSubstr("type \"<c8\"; accepted: float16"));
  EXPECT_THAT(message_of_reading(npy_file(dict("|f4", "(2,)"), two)), HasSubstr("type \"|f4\""));
  EXPECT_THAT(message_of_reading(npy_file(dict("<f16", "(1,)"), two)), HasSubstr("type \"<f16\""));
  EXPECT_THAT(message_of_reading(npy_file("{'descr': [('a', '<f4')], 'fortran_order': False, 'shape': (2,)}", two)),
              HasSubstr("structured"));
  EXPECT_THAT(message_of_reading(npy_file("{'descr': '<f4', 'fortran_order': False}", two)),
              HasSubstr("names no shape"));
  EXPECT_THAT(message_of_reading(npy_file(dict("<f4", "(2, -1)"), two)), HasSubstr("shape"));
  EXPECT_THAT(message_of_reading(npy_file(dict("<f4", "(a,)"), two)), HasSubstr("shape"));
  EXPECT_THAT(message_of_reading(npy_file(dict("<f4", "(3,)"), two)),
              HasSubstr("shape (3,) needs 12 bytes of values; the file holds 8"));
  EXPECT_THAT(message_of_reading(npy_file(dict("<f4", "(1,)"), two)), HasSubstr("holds 8"));
  EXPECT_THAT(message_of_reading(npy_file(dict("<f4", "(4611686018427387904, 4)"), two)), HasSubstr("too large"));
  EXPECT_THAT(message_of_reading(npy_file(dict("<f4", "(0, 4611686018427387904, 4)"), "")), HasSubstr("too large"));
  std::string many = "(";
  for (int i = 0; i < 65; ++i) many += "1, ";
  EXPECT_THAT(message_of_reading(npy_file(dict("<f4", many + ")"), two.substr(4))), HasSubstr("65 dimensions"));
  EXPECT_THAT(message_of_reading(npy_file(dict("<i8", "(2,)"), raw<std::int64_t>({1, (std::int64_t{1} << 53) + 1}))),
              HasSubstr("value 1 = 9007199254740993"));
  EXPECT_THAT(message_of_reading(npy_file(dict("<f4", "(2,)"), two).substr(0, 40)),
              HasSubstr("inside the .npy header"));
}

TEST(Npy, NamesFilesThatCannotBeOpenedOrWritten) {
  EXPECT_THROW(read_npy(temporary("no_such_file.npy")), UserError);
  EXPECT_THROW(read_npy(::testing::TempDir()), UserError);
  const std::vector<std::int64_t> shape = {1};
  const std::vector<float> values = {1};
  EXPECT_THROW(write_npy("/no/such/directory/a.npy", shape, values), EnvironmentError);
  EXPECT_THROW(write_npy("/dev/full", shape, values), EnvironmentError);
}

}  // namespace
}  // namespace noiseloom
