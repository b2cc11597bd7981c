// Damage is found before HDF5 sees the file, and named.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>

#include "noiseloom/files/digest.h"
#include "noiseloom/files/run_file.h"
#include "support/sample_run_file.h"

namespace noiseloom {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// The message of the error that opening throws: "user: ...", "damaged: ..." or "environment: ..."; "good" if it opens.
std::string opening(const std::string& path) {
  try {
    const RunFileReader reader(path);
    return "good";
  } catch (const DamagedRunFile& error) {
    return std::string("damaged: ") + error.what();
  } catch (const UserError& error) {
    return std::string("user: ") + error.what();
  } catch (const EnvironmentError& error) {
    return std::string("environment: ") + error.what();
  }
}

class RunFileDamage : public testing::Test {
 protected:
  void SetUp() override {
    write_sample_file(posix_file_ops(), path_, sample_content());
    good_ = read_bytes(path_);
    ASSERT_EQ(opening(path_), "good");
  }
  // Begin of the slices of a dataset and bytes of one.
  std::pair<std::size_t, std::size_t> slices(const std::string& dataset) const {
    std::istringstream lines(good_.substr(0, 4096));
    for (std::string line; std::getline(lines, line);) {
      std::istringstream words(line);
      std::string kind, name;
      std::size_t offset = 0, count = 0, bytes = 0, checksums = 0;
      words >> kind >> offset >> count >> bytes >> checksums >> name;
      if (kind == "slices" && name == dataset) return {offset, bytes};
    }
    ADD_FAILURE() << "no " << dataset;
    return {};
  }
  std::string opening_with(const std::string& bytes) const {
    write_bytes(path_, bytes);
    return opening(path_);
  }

  TemporaryFolder folder_;
  std::string path_ = folder_ / "run.h5";
  std::string good_;
};

TEST_F(RunFileDamage, NamesTheSliceOfAFlippedByte) {
  const auto [offset, bytes] = slices("/samples");
  for (const std::size_t slice : {std::size_t{0}, std::size_t{4}, std::size_t{5}}) {
    std::string damaged = good_;
    const std::size_t begin = offset + slice * bytes;
    damaged[begin + bytes / 2] ^= 0x10;
    EXPECT_THAT(opening_with(damaged), AllOf(HasSubstr("damaged: " + path_ + ": damaged: bytes " +
                                                       std::to_string(begin) + ".." + std::to_string(begin + bytes)),
                                             HasSubstr("inside /samples, slice " + std::to_string(slice) + " of 6")));
  }
}

TEST_F(RunFileDamage, JoinsNeighbouringSlices) {
  const auto [offset, bytes] = slices("/state/permutation");
  std::string damaged = good_;
  std::fill_n(damaged.begin() + static_cast<std::ptrdiff_t>(offset + bytes), 2 * bytes, '\0');
  EXPECT_THAT(opening_with(damaged),
              HasSubstr("inside /state/permutation, slice 1 of 6 to inside /state/permutation, slice 2 of 6"));
}

TEST_F(RunFileDamage, FindsEveryFlippedBit) {
  // Every byte of the text block's used lines and of all structures would take long; a prime stride meets them all.
  for (std::size_t byte = 0; byte < good_.size(); byte += byte < 600 ? 1 : 13) {
    put_bytes(path_, byte, {static_cast<char>(good_[byte] ^ (1 << byte % 8))});
    ASSERT_THAT(opening(path_), HasSubstr("damaged: " + path_ + ": damaged: bytes")) << "byte " << byte;
    put_bytes(path_, byte, {good_[byte]});
  }
}

TEST_F(RunFileDamage, FindsEveryTruncation) {
  for (std::size_t length = good_.size() - 1; length > 0;
       length -= std::min<std::size_t>(length, length > 600 ? 97 : 7)) {
    std::filesystem::resize_file(path_, length);
    ASSERT_THAT(opening(path_),
                AllOf(HasSubstr("damaged: " + path_ + ": truncated"), HasSubstr(std::to_string(length))));
  }
  std::filesystem::resize_file(path_, 0);
  EXPECT_THAT(opening(path_), HasSubstr("damaged: " + path_ + ": empty"));
}

TEST_F(RunFileDamage, SaysWhereATruncatedFileEnds) {
  const auto [offset, bytes] = slices("/order");
  EXPECT_THAT(opening_with(good_.substr(0, offset + 3 * bytes + 1)), HasSubstr("it ends inside /order, slice 3 of 6"));
}

TEST_F(RunFileDamage, FindsBytesAfterTheEnd) {
  EXPECT_THAT(opening_with(good_ + "x"), HasSubstr("follow after its end"));
}

TEST_F(RunFileDamage, ListsFewOfManyDamagedRanges) {
  std::string damaged = good_;
  for (const char* name : {"/samples", "/pdf", "/order", "/state/permutation"}) {
    const auto [offset, bytes] = slices(name);
    for (std::size_t slice = 0; slice < 6; slice += 2) damaged[offset + slice * bytes] ^= 1;
  }
  const std::string message = opening_with(damaged);
  EXPECT_EQ(std::ranges::count(message, '\n'), 10);
  EXPECT_THAT(message, HasSubstr("and 2 more damaged ranges"));
}

TEST_F(RunFileDamage, BlamesNoSliceForDamagedChecksums) {
  const RunFileReader reader(path_);
  const auto [offset, bytes] = slices("/samples");
  const std::uint64_t digest = digest_of(std::as_bytes(std::span(good_).subspan(offset, bytes)));
  const std::size_t stored = good_.find(std::string(reinterpret_cast<const char*>(&digest), 8));
  ASSERT_NE(stored, std::string::npos);
  std::string damaged = good_;
  damaged[stored] ^= 1;
  EXPECT_THAT(opening_with(damaged), AllOf(HasSubstr("checksums"), Not(HasSubstr("/samples"))));
}

// The block with another format number and a digest that fits, as a later noiseloom may write it.
TEST_F(RunFileDamage, TellsANewerFormatFromDamage) {
  std::string newer = good_;
  newer.replace(newer.find("format 1\n"), 9, "format 7\n");
  EXPECT_THAT(opening_with(newer), HasSubstr("damaged: "));
  const std::string digest = to_hex(digest_of(std::as_bytes(std::span(newer).first(4096 - 24))));
  newer.replace(4096 - 17, 16, digest);
  EXPECT_THAT(opening_with(newer), AllOf(HasSubstr("user: "), HasSubstr("format 7"), HasSubstr("newer")));
}

TEST_F(RunFileDamage, NamesFilesOfOtherKinds) {
  EXPECT_THAT(opening_with("\x89PNG\r\n\x1a\n and more"), AllOf(HasSubstr("user: "), HasSubstr("a PNG image")));
  EXPECT_THAT(opening_with(good_.substr(4096)), AllOf(HasSubstr("user: "), HasSubstr("HDF5 file of another program")));
  EXPECT_THAT(opening_with(std::string(10'000, '\0')), AllOf(HasSubstr("user: "), HasSubstr("not a noiseloom")));
  EXPECT_THAT(opening(folder_ / "missing.h5"), AllOf(HasSubstr("user: "), HasSubstr("no such file")));
  EXPECT_THAT(opening(folder_.path()), AllOf(HasSubstr("user: "), HasSubstr("folder")));
}

}  // namespace
}  // namespace noiseloom
