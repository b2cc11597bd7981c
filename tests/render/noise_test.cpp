#include "noiseloom/render/noise.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>

#include "noiseloom/core/error.h"
#include "noiseloom/files/run_lock.h"
#include "render/noises/sampler_tables.h"
#include "render/scene_support.h"
#include "support/run_files.h"

namespace noiseloom::render {
namespace {

Noise computed(NoiseKind kind) {
  NoiseSpec spec;
  spec.kind = kind;
  spec.name = "n";
  return open_noise(spec, "", nullptr);
}

TEST(Noise, ATextureIsReadAroundItsEdges) {
  const Noise noise = mask(13, 11, 5);
  const Move move{.x = 7, .y = 9, .t = 3};
  NoiseReader reader(noise, move, 1, 40);
  for (const std::int64_t frame : {0, 1, 4})
    for (const int y : {0, 1, 12, 30}) {
      reader.read(y, frame);
      for (int x = 0; x < 40; ++x) {
        const auto slice = SliceIndex((frame + 3) % 5);
        EXPECT_EQ(reader.at(x)(0), noise.texture->slice(slice)[(y + 9) % 11 * 13 + (x + 7) % 13]);
      }
    }
}

TEST(Noise, FurtherValuesLieAtTheOffsetsOfTheShader) {
  const Noise noise = mask(13, 11, 5);
  NoiseReader reader(noise, {}, 4, 20);
  EXPECT_EQ(reader.values(), 4);
  const TextureRead read{.width = 13, .height = 11, .num_slices = 5, .values = 4};
  for (const std::int64_t frame : {2, 5, 17}) {
    reader.read(6, frame);
    for (int value = 0; value < 4; ++value) {
      const TextureRead::Place place = read.place(frame, value);
      EXPECT_EQ(reader.at(3)(value), noise.texture->slice(place.slice)[(6 + place.dy) % 11 * 13 + (3 + place.dx) % 13]);
    }
  }
}

TEST(Noise, ComputedNumbersAreOfTheUnitIntervalAndEven) {
  for (const NoiseKind kind : {NoiseKind::white, NoiseKind::ign, NoiseKind::sobol_owen, NoiseKind::sobol_rotated}) {
    const Noise noise = computed(kind);
    NoiseReader reader(noise, move_of_repeat(5, 3), 6, 64);
    double sum = 0;
    double squares = 0;
    for (int y = 0; y < 64; ++y) {
      reader.read(y, y % 9);
      for (int x = 0; x < 64; ++x)
        for (int i = 0; i < 6; ++i) {
          const double u = static_cast<double>(reader.at(x)(i));
          ASSERT_GE(u, 0);
          ASSERT_LT(u, 1);
          sum += u;
          squares += u * u;
        }
    }
    const double n = 64.0 * 64 * 6;
    EXPECT_NEAR(sum / n, 0.5, 5 * std::sqrt(1 / 12.0 / n));
    EXPECT_NEAR(squares / n, 1.0 / 3, 5 * std::sqrt(4 / 45.0 / n));
  }
}

TEST(Noise, SobolStratifiesEveryPixelOverTheFrames) {
  for (const NoiseKind kind : {NoiseKind::sobol_owen, NoiseKind::sobol_rotated}) {
    const Noise noise = computed(kind);
    NoiseReader reader(noise, move_of_repeat(2, 1), 5, 3);
    std::vector<std::multiset<int>> strata(5);
    for (std::int64_t frame = 0; frame < 16; ++frame) {
      reader.read(8, frame);
      for (int i = 0; i < 5; ++i)
        strata[static_cast<std::size_t>(i)].insert(static_cast<int>(16 * static_cast<double>(reader.at(1)(i))));
    }
    for (const auto& one : strata) {
      if (kind == NoiseKind::sobol_owen) {
        EXPECT_EQ(std::set<int>(one.begin(), one.end()).size(), 16U);
      } else {
        EXPECT_GE(std::set<int>(one.begin(), one.end()).size(), 15U);  // rotation may cut two strata
      }
    }
  }
}

TEST(Noise, GoldenRatioMovesOnAndBeginsAgain) {
  Noise noise = mask(8, 8, 1);
  noise.spec.kind = NoiseKind::golden_ratio;
  noise.spec.slices = 64;
  NoiseReader reader(noise, {}, 1, 8);
  const auto at = [&](std::int64_t frame) {
    reader.read(2, frame);
    return static_cast<double>(reader.at(5)(0));
  };
  const double first = at(0);
  const double step = at(1) - first;
  EXPECT_NEAR(step - std::floor(step), 0.6180339887, 1e-6);
  EXPECT_EQ(at(64), first);
  EXPECT_NE(at(63), at(64));
  EXPECT_EQ(at((std::int64_t{1} << 31) + 3), at(3 + (std::int64_t{1} << 31) % 64));
}

TEST(Noise, RepeatsMoveNoisesToOtherPlaces) {
  EXPECT_EQ(move_of_repeat(1, 0).x, 0);
  std::set<std::int64_t> places;
  for (int repeat = 1; repeat < 50; ++repeat) places.insert(move_of_repeat(1, repeat).x);
  EXPECT_GT(places.size(), 45U);
}

NoiseSpec blue_2d() {
  NoiseSpec spec;
  spec.kind = NoiseKind::blue_2d;
  spec.name = "blue-2d";
  return spec;
}

TEST(Noise, TexturesOfOtherConfigsAreKeptUnderOtherNames) {
  NoiseSpec spec = blue_2d();
  const std::string first = cached_texture(spec, "folder");
  spec.seed = 2;
  EXPECT_NE(cached_texture(spec, "folder"), first);
  EXPECT_EQ(describe_noise(spec).numbers_in_value(), 1);
}

// What has no digests that do not fit is not a damaged texture: it may be anybody's.
TEST(Noise, OnlyDamagedTexturesAreMadeAnew) {
  const TemporaryFolder folder;
  NoiseSpec spec = blue_2d();
  const std::string path = cached_texture(spec, folder / "noise");
  std::filesystem::create_directories(path);
  const auto refuse = [](const auto&...) { throw UserError("maker", "was asked"); };
  EXPECT_THROW(open_noise(spec, folder / "noise", refuse), UserError);
  EXPECT_TRUE(std::filesystem::exists(path));
}

// Two commands that share a folder make what is kept there one after the other: the second waits for the first.
TEST(Noise, WhatAnotherCommandIsMakingIsWaitedFor) {
  const TemporaryFolder folder;
  NoiseSpec spec = blue_2d();
  const std::string path = cached_texture(spec, folder / "noise");
  std::filesystem::create_directories(folder / "noise");
  auto other = std::make_unique<RunLock>(path + ".making");
  int waits = 0;
  const auto wait = [&](const std::string& at) {
    EXPECT_EQ(at, path);
    if (++waits == 3) other.reset();
  };
  bool is_made = false;
  const auto make = [&](const auto&...) {
    is_made = true;
    EXPECT_EQ(waits, 3);
    throw UserError("maker", "was asked");
  };
  EXPECT_THROW(open_noise(spec, folder / "noise", make, wait), UserError);
  EXPECT_TRUE(is_made);
  EXPECT_FALSE(std::filesystem::exists(path + ".making.lock"));  // and no other needs to wait for what failed
}

class Tables : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("noiseloom-tables-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  static std::string array(const std::string& head, std::size_t size, unsigned step, const std::string& last = "") {
    std::string text = head + " = {";
    for (std::size_t i = 0; i + 1 < size; ++i)
      text += std::to_string(i * step / 3 % 256) + (i % 16 == 15 ? ",\n" : ", ");
    return text + (last.empty() ? std::to_string((size - 1) * step / 3 % 256) : last) + "};\n";
  }
  Noise opened(const std::string& text) const {
    const std::string path = (folder_ / "tables.cpp").string();
    std::ofstream(path) << text;
    return open_noise({.kind = NoiseKind::tables, .name = "n", .file = path}, "", nullptr);
  }
  std::string fault_of(const std::string& text) const {
    try {
      opened(text);
    } catch (const UserError& error) {
      return error.what();
    }
    return "no fault";
  }

  std::filesystem::path folder_;
  const std::string sequence_ = array("static const int sobol_256spp_256d[256*256]", 65536, 37);
  const std::string scramble_ =
      array("// int scramblingTile[1] = {1};\nconst int scramblingTile[128*128*8]", 131072, 91);
  const std::string order_ = array("uint8_t ranking_tile[128 * 128][8]", 131072, 53, "7, /* the last */");
};

TEST_F(Tables, GiveThePointsOfTheirSequenceByTheKeysOfThePixel) {
  const std::string text = "float f(int i) { return sobol_256spp_256d[i]; }\n" + sequence_ + scramble_;
  for (const bool ordered : {true, false}) {
    const Noise noise = opened(ordered ? text + order_ : text);
    EXPECT_EQ(noise.numbers_in_value(), 1);
    NoiseReader reader(noise, {.x = 100, .y = 3, .t = 9}, 10, 40);
    for (const std::int64_t frame : {0, 5, 300}) {
      reader.read(127, frame);
      for (const int x : {0, 27, 28, 39})
        for (const int i : {0, 1, 7, 8}) {
          const auto key = static_cast<unsigned>((130 % 128 * 128 + (x + 100) % 128) * 8 + i % 8);
          const unsigned order = !ordered ? 0 : key == 131071 ? 7 : key * 53 / 3 % 256;
          const unsigned place = ((static_cast<unsigned>(frame) % 256) ^ order) * 256 + static_cast<unsigned>(i);
          EXPECT_EQ(reader.at(x)(i), (static_cast<float>(place * 37 / 3 % 256 ^ key * 91 / 3 % 256) + 0.5F) / 256);
        }
    }
  }
}

TEST_F(Tables, AreRefusedWithWhatIsWrong) {
  const auto expect = [&](const std::string& text, const std::string& words) {
    EXPECT_NE(fault_of(text).find(words), std::string::npos) << fault_of(text);
  };
  expect("", "has no array sobol_256spp_256d");
  expect(sequence_, "has no array scramblingTile");
  expect(array("sobol_256spp_256d[]", 65535, 1) + scramble_, "sobol_256spp_256d has 65535 numbers, must have 65536");
  expect(sequence_ + array("scramblingTile", 131072, 1, "256"), "number 131071 (counted from 0) is \"256\"");
  expect(sequence_ + array("scramblingTile", 131072, 1, "-1"), "is \"-1\": accepted are integers from 0 to 255");
  expect(sequence_ + array("scramblingTile", 131072, 1, "1 2"), "after 131072 numbers neither , nor }");
  expect(sequence_ + "scramblingTile = {1, 2", "neither , nor }");
  expect(sequence_ + "scramblingTile = {", "is \"\"");
  EXPECT_EQ(fault_of(sequence_ + scramble_), "no fault");
  std::filesystem::remove(folder_ / "tables.cpp");
  EXPECT_THROW(load_sampler_tables((folder_ / "tables.cpp").string()), UserError);
}

}  // namespace
}  // namespace noiseloom::render
