// Damage is found before HDF5 sees the file, and named.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <bit>
#include <random>

#include "noiseloom/files/digest.h"
#include "noiseloom/files/generations.h"
#include "noiseloom/files/run_file.h"
#include "support/failing_file_ops.h"
#include "support/run_file_digests.h"
#include "support/sample_run_file.h"
#include "support/sanitizers.h"

// HDF5 1.10 loses some hundred bytes of its own where it gives a damaged file up.
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

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
  EXPECT_THAT(opening_with(std::string(10'000, 'x')), AllOf(HasSubstr("user: "), HasSubstr("not a noiseloom")));
  EXPECT_THAT(opening(folder_ / "missing.h5"), AllOf(HasSubstr("user: "), HasSubstr("no such file")));
  EXPECT_THAT(opening(folder_.path()), AllOf(HasSubstr("user: "), HasSubstr("folder")));
}

// --- going on from the generation before ---

class RunFileFallback : public RunFileDamage {
 protected:
  void SetUp() override {
    RunFileDamage::SetUp();
    std::filesystem::copy_file(path_, path_ + ".prev");
  }
  // "" where it goes on from PATH.prev with a reason, else what happens instead.
  std::string fallback(FileOps& ops = posix_file_ops()) const {
    try {
      refuse_foreign_output(path_);
      const NewestGeneration newest = open_newest_generation(path_, ops);
      if (!newest.reader) return "nothing";
      if (!newest.is_previous) return "opened";
      return newest.trouble.empty() ? "no reason" : "";
    } catch (const std::exception& error) {
      return error.what();
    }
  }
};

TEST_F(RunFileFallback, EveryBitOfTheFirstPage) {
  for (std::size_t byte = 0; byte < 4096; ++byte) {
    // Under sanitizers one bit of each byte.
    constexpr int step = testing_support::under_sanitizers ? 8 : 1;
    for (int bit = step == 8 ? static_cast<int>(byte % 8) : 0; bit < 8; bit += step) {
      put_bytes(path_, byte, {static_cast<char>(good_[byte] ^ (1 << bit))});
      ASSERT_TRUE(looks_like_run_file(path_)) << "byte " << byte << " bit " << bit;
      ASSERT_THAT(opening(path_), HasSubstr("damaged: ")) << "byte " << byte << " bit " << bit;
    }
    if (byte % 37 == 0 || byte < 24) {
      ASSERT_EQ(fallback(), "") << "byte " << byte;
    }
    put_bytes(path_, byte, {good_[byte]});
  }
}

TEST_F(RunFileFallback, WhatPowerCutsAndBadSectorsLeave) {
  const std::string zeros(good_.size(), '\0');
  for (const std::size_t length :
       {std::size_t{1}, std::size_t{19}, std::size_t{512}, std::size_t{4096}, std::size_t{8192}}) {
    EXPECT_THAT(opening_with(zeros.substr(0, length) + good_.substr(length)), HasSubstr("damaged: ")) << length;
    EXPECT_EQ(fallback(), "") << length;
  }
  for (const std::string& left :
       {zeros, std::string(), good_.substr(0, 5), std::string(512, 'x') + good_.substr(512)}) {
    EXPECT_THAT(opening_with(left), HasSubstr("damaged: "));
    EXPECT_EQ(fallback(), "") << left.size();
  }
}

TEST_F(RunFileFallback, AReadThatFailsIsNoDamage) {
  FailingFileOps counting(posix_file_ops(), FailingFileOps::never, FailingFileOps::Mode::fail_once);
  EXPECT_EQ(fallback(counting), "opened");
  // The first two operations look up which generations there are, the third opens PATH.
  for (int k = 2; k < counting.num_operations() - 1; ++k) {
    FailingFileOps passing(posix_file_ops(), k, FailingFileOps::Mode::fail_once);
    EXPECT_EQ(fallback(passing), "opened") << "operation " << k;
    FailingFileOps lasting(posix_file_ops(), k, FailingFileOps::Mode::fail_on);
    EXPECT_THAT(fallback(lasting), AllOf(HasSubstr("was made to fail"),
                                         HasSubstr(path_ + ".prev, the generation before"), HasSubstr("move it away")))
        << "operation " << k;
  }
}

TEST_F(RunFileFallback, NotFromAFileOfSomebodyElse) {
  const std::string picture = "\x89PNG\r\n\x1a\n and more";
  EXPECT_THAT(opening_with(picture), HasSubstr("user: "));
  EXPECT_THAT(fallback(), HasSubstr("is not a run file of noiseloom, and is not replaced"));
  EXPECT_EQ(read_bytes(path_), picture);
}

TEST_F(RunFileFallback, BothGenerationsAreNamedWhereBothAreDamaged) {
  write_bytes(path_ + ".prev", good_.substr(0, 1000));
  write_bytes(path_, "noiseloom");
  EXPECT_THAT(fallback(), AllOf(HasSubstr(path_ + ": truncated"), HasSubstr(path_ + ".prev: truncated")));
}

TEST_F(RunFileFallback, OnlyThePreviousGenerationIsLeft) {
  EXPECT_FALSE(only_previous_generation(path_));
  std::filesystem::remove(path_);
  EXPECT_TRUE(only_previous_generation(path_));
  EXPECT_EQ(fallback(), "");
  write_bytes(path_ + ".prev", "somebody else's");
  EXPECT_FALSE(only_previous_generation(path_));
  std::filesystem::remove(path_ + ".prev");
  EXPECT_FALSE(only_previous_generation(path_));
  EXPECT_EQ(fallback(), "nothing");
}

// --- right digests and wrong contents ---

class RunFileMadeUp : public RunFileDamage {
 protected:
  // The file with its text block changed and a digest that fits.
  std::string opening_with_block(const std::string& from, const std::string& to) const {
    std::string bytes = good_;
    const std::size_t at = bytes.find(from);
    if (at == std::string::npos || at > 4096) return "no " + from;
    std::string block = bytes.substr(0, 4096 - 24);
    block.replace(at, from.size(), to);
    block.resize(4096 - 25, ' ');
    block += "\n";
    return opening_with(block + "digest " + to_hex(digest_of(std::as_bytes(std::span(block)))) + "\n" +
                        bytes.substr(4096));
  }
  std::string line(const std::string& start) const {
    const std::size_t at = good_.find(start);
    return good_.substr(at, good_.find('\n', at) - at);
  }
};

TEST_F(RunFileMadeUp, PlacesThatCannotBeAreRefused) {
  const std::string samples = line("slices ");
  std::istringstream words(samples);
  std::string kind, name;
  std::uint64_t offset = 0, count = 0, bytes = 0, checksums = 0;
  words >> kind >> offset >> count >> bytes >> checksums >> name;
  const auto with = [&](std::uint64_t o, std::uint64_t n, std::uint64_t b, std::uint64_t c, const std::string& called) {
    return opening_with_block(samples, "slices " + std::to_string(o) + " " + std::to_string(n) + " " +
                                           std::to_string(b) + " " + std::to_string(c) + " " + called);
  };
  ASSERT_EQ(with(offset, count, bytes, checksums, name), "good");
  const std::uint64_t huge = ~std::uint64_t{0};
  for (const std::uint64_t wrong : {std::uint64_t{0}, std::uint64_t{1}, offset + 1, huge, huge / 8 + 1}) {
    EXPECT_THAT(with(wrong, count, bytes, checksums, name), HasSubstr("user: ")) << wrong;
    EXPECT_THAT(with(offset, wrong, bytes, checksums, name), HasSubstr("user: ")) << wrong;
    EXPECT_THAT(with(offset, count, wrong, checksums, name), HasSubstr("user: ")) << wrong;
  }
  EXPECT_THAT(with(offset, count, bytes, huge - 8, name), HasSubstr("user: "));
  EXPECT_THAT(with(offset, count * bytes, 1, checksums, name), Not(HasSubstr("good")));
  EXPECT_THAT(with(offset, 1, count * bytes, checksums, name), Not(HasSubstr("good")));
  EXPECT_THAT(with(offset, count, bytes, checksums, "/other"), HasSubstr("user: "));
  EXPECT_THAT(with(offset, count, bytes, checksums, "/pdf"), HasSubstr("user: "));
  const std::string rest = line("rest ");
  EXPECT_THAT(opening_with_block(rest, "rest 0 18446744073709551615 0123456789abcdef"), HasSubstr("user: "));
  EXPECT_THAT(opening_with_block(rest, std::string(rest.size(), ' ')), HasSubstr("user: "));  // bytes left unchecked
}

TEST_F(RunFileMadeUp, ExtentsThatCannotBeAreRefused) {
  constexpr std::int64_t huge = std::numeric_limits<std::int64_t>::max();
  using Sizes = std::array<std::int64_t, 4>;
  for (const Sizes& sizes : {Sizes{0, 5, 3, 2}, Sizes{7, 5, 3, -2}, Sizes{7, 5, std::int64_t{1} << 31, 2},
                             Sizes{7, 5, 1 << 16, 1 << 16}, Sizes{huge, huge, 1, 1}, Sizes{7, 5, 2, 3}}) {
    write_bytes(path_, good_);
    const hid_t file = H5Fopen(path_.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    const hid_t attribute = H5Aopen_by_name(file, "/", "extents", H5P_DEFAULT, H5P_DEFAULT);
    EXPECT_GE(H5Awrite(attribute, H5T_NATIVE_INT64, sizes.data()), 0);
    H5Aclose(attribute);
    H5Fclose(file);
    const std::string bytes = read_bytes(path_);
    ASSERT_EQ(bytes.size(), good_.size());
    EXPECT_THAT(opening_with(with_fitting_digests(bytes)), AllOf(HasSubstr("user: "), HasSubstr("not laid out")));
  }
}

// Thousands of small changes anywhere, the digests made to fit: opening throws or gives the file, and no more.
TEST_F(RunFileMadeUp, RandomChangesWithFittingDigestsEndInNothingWorseThanAnException) {
  std::mt19937 random(4711);
  unsigned opened = 0;
  for (unsigned round = 0; round < testing_support::tried(1500); ++round) {
    std::string bytes = good_;
    for (unsigned change = 0; change < 1 + round % 4; ++change) {
      const std::size_t at = random() % (round % 3 == 0 ? std::size_t{600} : bytes.size());
      if (round % 2 == 0) bytes[at] = static_cast<char>(random());
      if (round % 2 == 1 && bytes[at] >= '0' && bytes[at] <= '9') bytes[at] = static_cast<char>('0' + random() % 10);
    }
    const std::string result = opening_with(with_fitting_digests(bytes));
    opened += result == "good";
  }
  EXPECT_GT(opened, testing_support::tried(100));  // changes inside slices: the digests do fit
}

}  // namespace
}  // namespace noiseloom
