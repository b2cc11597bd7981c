// Runs that no longer own their output write nothing more.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "noiseloom/files/generations.h"
#include "noiseloom/files/run_file.h"
#include "noiseloom/files/run_lock.h"
#include "support/lock_holder.h"
#include "support/sample_run_file.h"

namespace noiseloom {
namespace {

using testing::HasSubstr;

class LostOutput : public testing::Test {
 protected:
  void write(int generation) const { write_sample_file(posix_file_ops(), path_, content_, generation); }
  int generation() const { return sample_generation(path_, content_, 4); }

  TemporaryFolder folder_;
  std::string path_ = folder_ / "run.h5";
  RunFileContent content_ = sample_content();
};

TEST_F(LostOutput, ARunThatWasTakenOverWritesNothingMore) {
  const RunLock lock(path_, {}, quick);
  write(0);
  LockRecord other = record_of_another_machine();
  std::filesystem::remove(path_ + ".lock");
  write_bytes(path_ + ".lock", to_text(other));
  EXPECT_THROW(write(1), OutputLost);
  EXPECT_EQ(generation(), 0);
  EXPECT_THAT(folder_.names(), testing::UnorderedElementsAre("run.h5", "run.h5.lock"));
  EXPECT_THAT(read_bytes(path_ + ".lock"), HasSubstr("node7"));
}

TEST_F(LostOutput, AFileThatANewerRunFinishedIsNotReplacedByAnOlderOne) {
  const RunLock older(path_, {}, quick);
  write(0);
  std::filesystem::remove(path_ + ".lock");  // by hand
  Child newer([&](auto ready) {
    const RunLock lock(path_, {}, quick);
    content_.provenance["version"] = std::string("newer");  // as its time of saving would differ
    write(2);
    ready();
    ::pause();
  });
  ASSERT_TRUE(newer.wait_until_ready());
  EXPECT_THROW(write(1), OutputLost);
  newer.kill_and_wait();
  std::filesystem::remove(path_ + ".lock");
  EXPECT_THROW(write(1), OutputLost);  // nor when the newer one and its lock are gone
  EXPECT_EQ(generation(), 2);
}

TEST_F(LostOutput, ALockFileRemovedByHandIsPutBack) {
  const RunLock lock(path_, {}, quick);
  write(0);
  std::filesystem::remove(path_ + ".lock");
  write(1);
  EXPECT_EQ(generation(), 1);
  Child second([&](auto ready) {
    if (refusal(path_).find("another run is writing it") != std::string::npos) ready();
  });
  EXPECT_TRUE(second.wait_until_ready());
}

TEST_F(LostOutput, AnOutputRemovedByHandIsWrittenAgain) {
  const RunLock lock(path_, {}, quick);
  write(0);
  std::filesystem::remove(path_);
  write(1);
  EXPECT_EQ(generation(), 1);
}

// A directory opens and does not read: so may a file on a server that is away for a moment.
TEST_F(LostOutput, AnOutputThatCannotBeReadJustNowIsNoLoss) {
  const RunLock lock(path_, {}, quick);
  write(0);
  std::filesystem::rename(path_, folder_ / "aside");
  std::filesystem::create_directory(path_);
  try {
    confirm_output(path_);
    ADD_FAILURE() << "confirmed";
  } catch (const OutputLost& error) {
    ADD_FAILURE() << error.what();
  } catch (const EnvironmentError& error) {
    EXPECT_THAT(error.what(), HasSubstr("cannot be read"));
  }
  std::filesystem::remove(path_);
  std::filesystem::rename(folder_ / "aside", path_);
  write(1);
  EXPECT_EQ(generation(), 1);
}

TEST_F(LostOutput, WhatCouldNotBeReadAtFirstIsKnownFromTheFirstLook) {
  std::filesystem::create_directory(path_);
  const RunLock lock(path_, {}, quick);
  std::filesystem::remove(path_);
  write_bytes(path_, "seen first");
  confirm_output(path_);
  confirm_output(path_);
  write_bytes(path_, "another");
  EXPECT_THROW(confirm_output(path_), OutputLost);
}

TEST_F(LostOutput, GoingOnFromThePreviousGenerationIsNoLoss) {
  write(0);
  write(1);
  write_bytes(path_, "noiseloom run");
  const RunLock lock(path_, {}, quick);
  restore_previous_generation(posix_file_ops(), path_);
  write(2);
  EXPECT_EQ(generation(), 2);
}

TEST_F(LostOutput, TheTargetOfALinkIsWhatIsLocked) {
  const std::string link = folder_ / "link.h5";
  std::filesystem::create_symlink("run.h5", link);
  const RunLock lock(link, {}, quick);
  EXPECT_THAT(refusal(path_), HasSubstr("another run is writing it"));
  EXPECT_TRUE(std::filesystem::exists(path_ + ".lock"));
}

}  // namespace
}  // namespace noiseloom
