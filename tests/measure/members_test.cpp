// Members that are not independent or not alike are found, each by what is wrong with it.
#include "noiseloom/measure/members.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "noiseloom/files/npy.h"
#include "noiseloom/measure/covariance.h"
#include "support/sample_run_file.h"

namespace noiseloom {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr int members_width = 17;
constexpr int members_height = 13;
constexpr int members_slices = 5;

class MembersTest : public testing::Test {
 protected:
  static std::vector<float> white(unsigned seed) {
    std::mt19937 draw(seed);
    std::vector<float> values(members_width * members_height * members_slices);
    for (float& value : values) value = static_cast<float>(draw()) * 0x1p-32F;
    return values;
  }
  // Of the seed that is its number.
  void add(const std::vector<float>& values, int slices = members_slices, int channels = 1) {
    const std::string name = "m" + std::to_string(files_.size());
    const std::string path = folder_ / (name + ".npy");
    const std::int64_t shape[] = {slices, members_height, members_width, channels};
    write_npy(path, shape, values);
    files_.push_back({name, path, name, "", name});
  }
  std::vector<std::string> kinds() {
    ThreadPool pool(2);
    found_ = verify_members(files_, pool);
    text_ = members_text(found_, "made");
    std::vector<std::string> kinds;
    for (const Finding& finding : found_.findings) kinds.push_back(finding.kind);
    return kinds;
  }

  TemporaryFolder folder_;
  std::vector<MemberFile> files_;
  MembersVerification found_;
  std::string text_;
};

TEST_F(MembersTest, IndependentOnesAreSound) {
  for (unsigned seed = 1; seed <= 12; ++seed) add(white(seed));
  EXPECT_THAT(kinds(), ElementsAre());
  EXPECT_EQ(found_.pairs, 66);
  EXPECT_NEAR(found_.bands[2].power, 1, 0.15);
  EXPECT_THAT(text_, HasSubstr("uncorrelated and alike"));
  EXPECT_THAT(text_, Not(HasSubstr("left out")));
}

TEST_F(MembersTest, ChannelsMayDependOnEachOther) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    std::vector<float> values;
    for (const float value : white(seed)) values.insert(values.end(), 3, value);
    add(values, members_slices, 3);
  }
  EXPECT_THAT(kinds(), ElementsAre());
  EXPECT_EQ(found_.pairs, 15);
}

TEST_F(MembersTest, AMemberThatIsAnotherOneMovedIsFound) {
  for (unsigned seed = 1; seed <= 4; ++seed) add(white(seed));
  const std::vector<float> first = white(2);
  std::vector<float> moved = white(5);
  for (std::size_t i = 0; i < moved.size(); ++i) {  // by 3 along x and 2 along t, and half of it another's
    const std::size_t x = i % members_width;
    const std::size_t plane = members_width * members_height;
    const std::size_t from =
        (i - x + (x + members_width - 3) % members_width + (members_slices - 2) * plane) % first.size();
    moved[i] = (moved[i] + first[from]) / 2;
  }
  add(moved);
  EXPECT_THAT(kinds(), testing::Contains("correlation"));
  EXPECT_THAT(found_.shifted.where, HasSubstr("m1 and m4"));
  EXPECT_NEAR(std::abs(found_.shifted.value), 0.707, 0.06);
}

TEST_F(MembersTest, OtherValuesAndOtherSpectraAreFound) {
  for (unsigned seed = 1; seed <= 11; ++seed) add(white(seed));
  std::vector<float> other = white(12);
  for (float& value : other) value = value * value;
  add(other);
  EXPECT_THAT(kinds(), testing::Contains("distribution"));
  files_.pop_back();
  other = white(12);
  for (int times = 0; times < 4; ++times) {
    for (std::size_t i = 0; i + 1 < other.size(); ++i) other[i] += other[i + 1];
  }
  add(other);
  EXPECT_THAT(kinds(), testing::Contains("spectrum"));
}

TEST_F(MembersTest, TheSameValuesTwiceAreFound) {
  add(white(1));
  add(white(2));
  files_[1].checksum = files_[0].checksum;
  EXPECT_THAT(kinds(), ElementsAre("repeated"));
}

TEST_F(MembersTest, MembersOfOneSizeAreComparedAndTheOtherPairsAreCounted) {
  constexpr std::size_t plane = members_width * members_height;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const std::vector<float> values = white(seed);
    add({values.begin(), values.begin() + 2 * plane}, 2);
    files_.back().settings = "size.t = 2";
    add(white(seed + 10));
    files_.back().settings = "size.t = 5";
    files_.back().seed = files_[files_.size() - 2].seed;
  }
  EXPECT_THAT(kinds(), ElementsAre());
  EXPECT_EQ(found_.compared, 8);
  EXPECT_EQ(found_.pairs, 12);
  EXPECT_EQ(found_.pairs_of_other_sizes, 16);
  EXPECT_EQ(found_.alike, 8);
  EXPECT_NEAR(found_.bands[2].power, 1, 0.2);
  // Of each size what is wrong is found.
  files_[6].path = files_[0].path;
  EXPECT_THAT(kinds(), testing::Contains("correlation"));
  EXPECT_EQ(found_.unshifted.where, "m0 and m6");
}

TEST_F(MembersTest, WhereNoPairWasComparedNothingIsSaidOfThem) {
  add(white(1));
  const std::vector<float> values = white(2);
  add({values.begin(), values.begin() + 2 * members_width * members_height}, 2);
  files_[1].settings = "size.t = 2";
  EXPECT_THAT(kinds(), ElementsAre());
  EXPECT_EQ(found_.compared, 0);
  EXPECT_EQ(found_.pairs_of_other_sizes, 1);
  EXPECT_THAT(text_, HasSubstr("left out: 1 pair of different sizes"));
  EXPECT_THAT(text_, Not(HasSubstr("uncorrelated")));
  EXPECT_THAT(text_, HasSubstr("nothing is known"));
}

TEST_F(MembersTest, MembersOfOneSeedMayBeCorrelated) {
  const std::vector<float> first = white(1);
  add(first);
  add(white(2));
  add(white(3));
  std::vector<float> similar = white(4);
  for (std::size_t i = 0; i < first.size(); ++i) similar[i] = (similar[i] + first[i]) / 2;
  add(similar);
  files_[3].seed = files_[0].seed;
  files_[3].settings = "sigma = 1.0";
  EXPECT_THAT(kinds(), ElementsAre());
  EXPECT_EQ(found_.pairs, 5);
  EXPECT_EQ(found_.pairs_of_one_seed, 1);
  EXPECT_THAT(text_, HasSubstr("left out: 1 pair of one seed"));
  files_[3].seed = "4";
  EXPECT_THAT(kinds(), testing::Contains("correlation"));
  EXPECT_EQ(found_.unshifted.where, "m0 and m3");
}

TEST_F(MembersTest, APairThatIsCorrelatedWhereItStandsIsToldOnce) {
  add(white(1));
  add(white(2));
  add(white(3));
  files_[2].path = files_[0].path;
  EXPECT_THAT(kinds(), ElementsAre("correlation"));
  EXPECT_EQ(found_.unshifted.where, "m0 and m2");
}

TEST_F(MembersTest, ValuesThatAreClippedUpwardAreFound) {
  for (unsigned seed = 1; seed <= 3; ++seed) add(white(seed));
  std::vector<float> clipped = white(4);
  for (float& value : clipped) value = value < 0.1F ? value : 1;
  add(clipped);
  EXPECT_THAT(kinds(), testing::Contains("distribution"));
  EXPECT_THAT(text_, HasSubstr("the values of m3 are not distributed"));
}

TEST_F(MembersTest, AMemberWhoseValuesAreAllEqualIsFound) {
  add(white(1));
  add(std::vector<float>(white(2).size(), 0.5F));
  EXPECT_THAT(kinds(), ElementsAre("constant"));
  EXPECT_EQ(found_.pairs, 0);
}

TEST(Cholesky, TimesItsTransposeIsTheMatrix) {
  constexpr std::size_t size = 131;  // more than two blocks, and a part of one
  std::vector<double> matrix(size * size);
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t j = 0; j < size; ++j)
      matrix[i * size + j] =
          (i == j ? 2.0 : 0.0) + std::exp(-std::abs(static_cast<double>(i) - static_cast<double>(j)));
  }
  std::vector<double> factor = matrix;
  ThreadPool pool(2);
  cholesky(factor, size, pool);
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t j = 0; j < size; ++j) {
      double sum = 0;
      for (std::size_t k = 0; k < size; ++k) sum += factor[i * size + k] * factor[j * size + k];
      ASSERT_NEAR(sum, matrix[i * size + j], 1e-12);
      if (j > i) {
        ASSERT_EQ(factor[i * size + j], 0);
      }
    }
  }
}

}  // namespace
}  // namespace noiseloom
