// Numbered files.
#include "noiseloom/image/sequence.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/run_files.h"

namespace noiseloom {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(Sequence, IsSortedByNumberNotByName) {
  const TemporaryFolder folder;
  for (int i = 8; i < 12; ++i) write_bytes(folder / fmt::format("a_{}.png", i), "");
  write_bytes(folder / "a_x.png", "");
  write_bytes(folder / "a_8.exr", "");
  const auto expected = ElementsAre(folder / "a_8.png", folder / "a_9.png", folder / "a_10.png", folder / "a_11.png");
  EXPECT_THAT(find_sequence(folder / "a_{}.png"), expected);
  EXPECT_THAT(find_sequence(folder / "a_{slice}.png"), expected);
  EXPECT_THAT(find_sequence(folder / "a_%d.png"), expected);
  EXPECT_THAT(sequence_from_first(folder / "a_8.png"), expected);
  EXPECT_THAT(sequence_from_first(folder / "a_10.png"), ElementsAre(folder / "a_10.png", folder / "a_11.png"));
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
  EXPECT_TRUE(is_sequence_pattern("%03d.png"));
  EXPECT_FALSE(is_sequence_pattern("a_{x}.png"));
  EXPECT_FALSE(is_sequence_pattern("100%.png"));
}

}  // namespace
}  // namespace noiseloom
