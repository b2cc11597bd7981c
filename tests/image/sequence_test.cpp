// Numbered files.
#include "noiseloom/image/sequence.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/run_files.h"

namespace noiseloom {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

TEST(Sequence, IsSortedByNumberNotByName) {
  const TemporaryFolder folder;
  for (int i = 8; i < 12; ++i) write_bytes(folder / fmt::format("a_{}.png", i), "");
  write_bytes(folder / "a_x.png", "");
  write_bytes(folder / "a_8.exr", "");
  const auto expected = ElementsAre(folder / "a_8.png", folder / "a_9.png", folder / "a_10.png", folder / "a_11.png");
  EXPECT_THAT(find_sequence(folder / "a_{}.png"), expected);
  EXPECT_THAT(find_sequence(folder / "a_{slice}.png"), expected);
  EXPECT_THAT(find_sequence(folder / "a_%d.png"), expected);
  for (const char* const pattern : {"a_%i.png", "a_%02d.png", "a_#.png", "a_####.png"})
    EXPECT_THAT(find_sequence(folder / pattern), expected) << pattern;
  ASSERT_EQ(sequences_from_first(folder / "a_8.png").size(), 1U);
  EXPECT_THAT(sequences_from_first(folder / "a_8.png").front().files, expected);
  EXPECT_EQ(sequences_from_first(folder / "a_8.png").front().gap, "");
  EXPECT_THAT(sequences_from_first(folder / "a_10.png").front().files,
              ElementsAre(folder / "a_10.png", folder / "a_11.png"));
  EXPECT_TRUE(is_one_sequence({folder / "a_8.png", folder / "a_9.png"}));
  EXPECT_FALSE(is_one_sequence({folder / "a_9.png", folder / "a_8.png"}));
  EXPECT_FALSE(is_one_sequence({folder / "a_8.png", folder / "a_8.exr"}));
}

TEST(Sequence, IsTheOnlyOneOfAFolder) {
  const TemporaryFolder folder;
  write_bytes(folder / "n1.png", "");
  write_bytes(folder / "n0.png", "");
  write_bytes(folder / "readme.txt", "");
  EXPECT_THAT(find_sequence(folder.path()), ElementsAre(folder / "n0.png", folder / "n1.png"));
  write_bytes(folder / "m0.png", "");
  const std::string error = user_error_of([&] { find_sequence(folder.path()); });
  EXPECT_THAT(error, HasSubstr("more than one set of images"));
  EXPECT_THAT(error, HasSubstr("n{}.png"));
}

TEST(Sequence, NamesTheMissingNumber) {
  const TemporaryFolder folder;
  for (const int i : {0, 1, 3}) write_bytes(folder / fmt::format("a{}.png", i), "");
  EXPECT_THAT(user_error_of([&] { find_sequence(folder / "a{}.png"); }), HasSubstr("number 2 is missing"));
  EXPECT_THAT(user_error_of([&] { find_sequence(folder / "b{}.png"); }), HasSubstr("no file has a name like this"));
  EXPECT_THAT(user_error_of([&] { find_sequence(folder.path() + "/none/b{}.png"); }), HasSubstr("no such folder"));
  const TemporaryFolder empty;
  EXPECT_THAT(user_error_of([&] { find_sequence(empty.path()); }), HasSubstr("no images"));
}

TEST(Sequence, IsFoundWithAStarAsInAShell) {
  const TemporaryFolder folder;
  for (int i = 0; i < 3; ++i) write_bytes(folder / fmt::format("a_{}.png", i), "");
  write_bytes(folder / "b_0.png", "");
  write_bytes(folder / "a_0.txt", "");
  const auto expected = ElementsAre(folder / "a_0.png", folder / "a_1.png", folder / "a_2.png");
  EXPECT_THAT(find_sequence(folder / "a_*.png"), expected);
  EXPECT_THAT(find_sequence(folder / "a*"), expected);
  EXPECT_THAT(user_error_of([&] { find_sequence(folder / "*.png"); }), HasSubstr("a_{}.png, b_{}.png"));
  EXPECT_THAT(user_error_of([&] { find_sequence(folder / "c*.png"); }), HasSubstr("no file has a name like this"));
}

TEST(Sequence, NamesTheGapBehindTheFirstFiles) {
  const TemporaryFolder folder;
  for (const int i : {3, 4, 7, 8}) write_bytes(folder / fmt::format("n{:02}.png", i), "");
  const std::vector<Sequence> sequences = sequences_from_first(folder / "n03.png");
  ASSERT_EQ(sequences.size(), 1U);
  EXPECT_EQ(sequences.front().files.size(), 2U);
  EXPECT_EQ(sequences.front().pattern, folder / "n{}.png");
  EXPECT_EQ(sequences.front().gap, "numbers 5 to 6 are missing, but 7 to 8 are there");
}

TEST(Sequence, MayRunOverAnyNumberOfTheName) {
  const TemporaryFolder folder;
  for (int z = 0; z < 4; ++z) write_bytes(folder / fmt::format("out_{}.0.png", z), "");
  for (int step = 1; step < 3; ++step) write_bytes(folder / fmt::format("out_0.{}.png", step), "");
  const std::vector<Sequence> sequences = sequences_from_first(folder / "out_0.0.png");
  ASSERT_EQ(sequences.size(), 2U);
  EXPECT_EQ(sequences[0].pattern, folder / "out_0.{}.png");
  EXPECT_EQ(sequences[0].files.size(), 3U);
  EXPECT_EQ(sequences[1].pattern, folder / "out_{}.0.png");
  EXPECT_EQ(sequences[1].files.size(), 4U);
}

TEST(Sequence, SaysWhatItSawInAFolderWithoutImagesThatAreRead) {
  const TemporaryFolder folder;
  for (int i = 0; i < 5; ++i) write_bytes(folder / fmt::format("n{}.JPG", i), "");
  write_bytes(folder / "noise.psd", "");
  write_bytes(folder / "readme.txt", "");
  EXPECT_THAT(user_error_of([&] { find_sequence(folder.path()); }),
              AllOf(HasSubstr("5 x .jpg (lossy"), HasSubstr("1 x .psd (not read by this version"),
                    HasSubstr("accepted: .png, .exr"), Not(HasSubstr("txt"))));
}

TEST(Sequence, RefusesOneNumberTwice) {
  const TemporaryFolder folder;
  for (const char* const name : {"a_0.png", "a_1.png", "a_01.png"}) write_bytes(folder / name, "");
  EXPECT_THAT(user_error_of([&] { find_sequence(folder / "a_{}.png"); }), HasSubstr("number 1 is there twice"));
}

TEST(Pattern, IsFilledWithTheNumber) {
  EXPECT_EQ(fill_pattern("a_{}.png", 7), "a_7.png");
  EXPECT_EQ(fill_pattern("a_{slice}.png", 12), "a_12.png");
  EXPECT_EQ(fill_pattern("a_{slice:03}.png", 7), "a_007.png");
  EXPECT_EQ(fill_pattern("a_%04d", 123), "a_0123");
  EXPECT_EQ(fill_pattern("a_%d", 123456), "a_123456");
  EXPECT_EQ(fill_pattern("a_%i.png", 7), "a_7.png");
  EXPECT_EQ(fill_pattern("a_%03u.png", 7), "a_007.png");
  EXPECT_EQ(fill_pattern("a_####.png", 42), "a_0042.png");
  EXPECT_EQ(fill_pattern("take#2/a_##.png", 3), "take#2/a_03.png");
  EXPECT_EQ(fill_pattern("plain.png", 3), "plain.png");
  EXPECT_THAT(user_error_of([] { fill_pattern("a_*.png", 3); }), HasSubstr("does not say how the number is written"));
  EXPECT_THAT(user_error_of([] { fill_pattern("a_{}_%d.png", 3); }), HasSubstr("more than one place"));
  EXPECT_TRUE(is_sequence_pattern("%03d.png"));
  EXPECT_TRUE(is_sequence_pattern("a_*.png"));
  EXPECT_FALSE(is_sequence_pattern("take#2/a.png"));
  EXPECT_FALSE(is_sequence_pattern("a_{x}.png"));
  EXPECT_FALSE(is_sequence_pattern("100%.png"));
}

}  // namespace
}  // namespace noiseloom
