// A checkpoint is published whole or not at all, wherever it is interrupted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <csignal>

#include "noiseloom/files/generations.h"
#include "noiseloom/files/run_file.h"
#include "support/failing_file_ops.h"
#include "support/sample_run_file.h"
#include "support/sanitizers.h"

namespace noiseloom {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::UnorderedElementsAre;
using Mode = FailingFileOps::Mode;

// Runs `body` in a child process and gives its exit status; -1 if a signal ended it.
template <class Body>
int status_of_child(Body body) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(body());
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

class RunFilePublish : public testing::Test {
 protected:
  void write(FileOps& ops, int generation) const { write_sample_file(ops, path_, content_, generation); }

  // Generations 0 and 1 in place: PATH holds 1, PATH.prev holds 0.
  void write_two_generations() const {
    FailingFileOps ops(posix_file_ops(), FailingFileOps::never, Mode::fail_once);
    for (const char* suffix : {"", ".prev", ".damaged"}) std::filesystem::remove(path_ + suffix);
    write(ops, 0);
    write(ops, 1);
  }
  int operations_of_a_checkpoint() const {
    write_two_generations();
    FailingFileOps ops(posix_file_ops(), FailingFileOps::never, Mode::fail_once);
    write(ops, 2);
    return ops.num_operations();
  }
  // -1 where there is no file; throws where it is not good.
  int generation_at(const std::string& path) const {
    return std::filesystem::exists(path) ? sample_generation(path, content_, 3) : -1;
  }
  int newest_generation() const { return std::max(generation_at(path_), generation_at(previous_generation(path_))); }

  TemporaryFolder folder_;
  std::string path_ = folder_ / "run.h5";
  RunFileContent content_ = sample_content();
};

TEST_F(RunFilePublish, KeepsTheGenerationBefore) {
  write_two_generations();
  EXPECT_EQ(generation_at(path_), 1);
  EXPECT_EQ(generation_at(path_ + ".prev"), 0);
  EXPECT_THAT(folder_.names(), UnorderedElementsAre("run.h5", "run.h5.prev"));
}

TEST_F(RunFilePublish, UnpublishedWriterLeavesNothing) {
  { const RunFileWriter writer(posix_file_ops(), path_, content_); }
  EXPECT_THAT(folder_.names(), ElementsAre());
}

TEST_F(RunFilePublish, AnyFailingOperationLeavesTheOldOrTheNewGenerationAndNoTemporary) {
  const int operations = operations_of_a_checkpoint();
  EXPECT_GT(operations, 15);
  for (int k = 0; k < operations; ++k) {
    SCOPED_TRACE("operation " + std::to_string(k));
    write_two_generations();
    FailingFileOps ops(posix_file_ops(), k, Mode::fail_once);
    EXPECT_THROW(write(ops, 2), EnvironmentError);
    EXPECT_GE(generation_at(path_), 1);  // even between the renames: the first one is taken back
    for (const std::string& name : folder_.names()) EXPECT_TRUE(name == "run.h5" || name == "run.h5.prev") << name;
    EXPECT_EQ(H5Fget_obj_count(H5F_OBJ_ALL, H5F_OBJ_ALL), 0);  // HDF5 holds nothing that it would write later
  }
}

TEST_F(RunFilePublish, ADiskThatStaysBrokenLosesNoGeneration) {
  const int operations = operations_of_a_checkpoint();
  for (int k = 0; k < operations; ++k) {
    SCOPED_TRACE("operation " + std::to_string(k));
    write_two_generations();
    FailingFileOps ops(posix_file_ops(), k, Mode::fail_on);
    EXPECT_THROW(write(ops, 2), EnvironmentError);
    EXPECT_GE(newest_generation(), 1);
    remove_stale_temporaries(posix_file_ops(), path_);
  }
}

TEST_F(RunFilePublish, APathOnceThereIsNeverAbsent) {
  const int operations = operations_of_a_checkpoint();
  for (int k = 0; k < operations; k += testing_support::stride) {
    SCOPED_TRACE("operation " + std::to_string(k));
    write_two_generations();
    EXPECT_EQ(status_of_child([&] {
                FailingFileOps ops(posix_file_ops(), k, Mode::end_process);
                write(ops, 2);
                return 0;
              }),
              FailingFileOps::stopped_status);
    EXPECT_GE(generation_at(path_), 1);
    EXPECT_GE(generation_at(path_ + ".prev"), 0);
    remove_stale_temporaries(posix_file_ops(), path_);
    EXPECT_THAT(folder_.names(), UnorderedElementsAre("run.h5", "run.h5.prev"));
    // And once more from there: where the kill left both names on one file, too.
    const int there = generation_at(path_);
    write(posix_file_ops(), 2);
    EXPECT_EQ(generation_at(path_), 2);
    EXPECT_EQ(generation_at(path_ + ".prev"), there);
    EXPECT_THAT(folder_.names(), UnorderedElementsAre("run.h5", "run.h5.prev"));
  }
}

TEST_F(RunFilePublish, AReaderAlwaysFindsAGoodFile) {
  write(posix_file_ops(), 0);
  const pid_t writer = ::fork();
  if (writer == 0) {
    for (unsigned generation = 1; generation < testing_support::tried(300); ++generation)
      write(posix_file_ops(), static_cast<int>(generation % 3));
    ::_exit(0);
  }
  unsigned looks = 0;
  int status = 0;
  while (::waitpid(writer, &status, WNOHANG) == 0) {
    ASSERT_TRUE(std::filesystem::exists(path_));
    if (++looks % testing_support::tried(64) == 0) {
      ASSERT_GE(generation_at(path_), 0);
    }
  }
  EXPECT_EQ(status, 0);
  EXPECT_GT(looks, testing_support::tried(1000));
}

TEST_F(RunFilePublish, WithoutHardLinksAProcessKilledAtAnyOperationLosesNoGeneration) {
  write_two_generations();
  FailingFileOps counting(posix_file_ops(), FailingFileOps::never, Mode::fail_once);
  counting.take_links_away();
  write(counting, 2);
  const int operations = counting.num_operations();
  int only_previous = 0;
  for (int k = 0; k < operations; k += testing_support::stride) {
    SCOPED_TRACE("operation " + std::to_string(k));
    write_two_generations();
    EXPECT_EQ(status_of_child([&] {
                FailingFileOps ops(posix_file_ops(), k, Mode::end_process);
                ops.take_links_away();
                write(ops, 2);
                return 0;
              }),
              FailingFileOps::stopped_status);
    EXPECT_GE(newest_generation(), 1);
    if (!std::filesystem::exists(path_)) {
      ++only_previous;
      EXPECT_TRUE(only_previous_generation(path_));
      EXPECT_TRUE(open_newest_generation(path_).is_previous);
      restore_previous_generation(posix_file_ops(), path_);
      EXPECT_EQ(generation_at(path_), 1);
    }
    remove_stale_temporaries(posix_file_ops(), path_);
    for (const std::string& name : folder_.names()) EXPECT_TRUE(name == "run.h5" || name == "run.h5.prev") << name;
  }
  // The one moment, between the renames.
  EXPECT_LE(only_previous, 1);
  EXPECT_TRUE(only_previous == 1 || testing_support::stride > 1);
}

TEST_F(RunFilePublish, FirstFailureIsTheOneReported) {
  write_two_generations();
  for (int k = 0; k < 12; ++k) {
    FailingFileOps ops(posix_file_ops(), k, Mode::fail_on);
    try {
      write(ops, 2);
      ADD_FAILURE() << "operation " << k << " did not fail";
    } catch (const EnvironmentError& error) {
      EXPECT_THAT(error.what(), HasSubstr("operation " + std::to_string(k) + ","));
    }
    remove_stale_temporaries(posix_file_ops(), path_);
  }
}

TEST_F(RunFilePublish, RestoringPutsTheDamagedGenerationAside) {
  write_two_generations();
  write_bytes(path_, "noiseloom run");
  restore_previous_generation(posix_file_ops(), path_);
  EXPECT_EQ(generation_at(path_), 0);
  write(posix_file_ops(), 2);
  EXPECT_EQ(generation_at(path_), 2);
  EXPECT_EQ(generation_at(path_ + ".prev"), 0);
  EXPECT_THAT(folder_.names(), Contains("run.h5.damaged"));
}

TEST_F(RunFilePublish, DamagedGenerationsOfBeforeStayWhatTheyAre) {
  for (const char* damaged : {"first", "second", "third"}) {
    write(posix_file_ops(), 0);
    write(posix_file_ops(), 1);
    write_bytes(path_, damaged);
    restore_previous_generation(posix_file_ops(), path_);
    EXPECT_EQ(generation_at(path_), 0);
  }
  EXPECT_EQ(read_bytes(path_ + ".damaged"), "first");
  EXPECT_EQ(read_bytes(path_ + ".damaged2"), "second");
  EXPECT_EQ(read_bytes(path_ + ".damaged3"), "third");
}

TEST_F(RunFilePublish, ThroughASymbolicLinkItsTargetIsWrittenAndTheLinkStays) {
  std::filesystem::create_directory(folder_ / "disk");
  const std::string link = folder_ / "link.h5";
  std::filesystem::create_symlink("disk/target.h5", link);
  for (int generation = 0; generation < 3; ++generation) {
    write_sample_file(posix_file_ops(), link, content_, generation);
    EXPECT_TRUE(std::filesystem::is_symlink(link));
    EXPECT_EQ(generation_at(folder_ / "disk/target.h5"), generation);
  }
  EXPECT_EQ(generation_at(folder_ / "disk/target.h5.prev"), 1);
  EXPECT_THAT(folder_.names(), UnorderedElementsAre("disk", "link.h5"));
  EXPECT_EQ(previous_generation(link), folder_ / "disk/target.h5.prev");
  std::filesystem::remove(folder_ / "disk/target.h5");
  EXPECT_TRUE(only_previous_generation(link));
  restore_previous_generation(posix_file_ops(), link);
  EXPECT_EQ(generation_at(link), 1);
}

TEST_F(RunFilePublish, RemovesTemporariesOfThisOutputOnly) {
  for (const char* name : {"run.h5.tmp-host-1-2-3", "run.h5.tmp-host-9-9-9", "other.h5.tmp-host-1-2-3", "run.h5"}) {
    write_bytes(folder_ / name, "x");
  }
  remove_stale_temporaries(posix_file_ops(), path_);
  EXPECT_THAT(folder_.names(), UnorderedElementsAre("other.h5.tmp-host-1-2-3", "run.h5"));
}

TEST_F(RunFilePublish, AFileSizeLimitIsAnErrorWithPathAndReason) {
  write_two_generations();
  const auto limited_write = [&] {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{10'000, 10'000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    try {
      write(posix_file_ops(), 2);
    } catch (const EnvironmentError& error) {
      const std::string text = error.what();
      const bool good = text.find(path_ + ".tmp-") != text.npos && text.find("File too large") != text.npos &&
                        text.find("ulimit -f") != text.npos;
      return good ? 17 : 1;
    }
    return 0;
  };
  EXPECT_EQ(status_of_child(limited_write), 17);
  EXPECT_EQ(generation_at(path_), 1);
  EXPECT_THAT(folder_.names(), UnorderedElementsAre("run.h5", "run.h5.prev"));
}

TEST_F(RunFilePublish, AnHdf5FailureBecomesAnErrorInItsOwnWordsAndPrintsNothing) {
  content_.datasets.push_back(content_.datasets.front());
  testing::internal::CaptureStderr();
  try {
    const RunFileWriter writer(posix_file_ops(), path_, content_);
    ADD_FAILURE() << "two datasets of one name";
  } catch (const EnvironmentError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("cannot create /samples"), HasSubstr("HDF5: "), HasSubstr("exists")));
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_THAT(folder_.names(), ElementsAre());
}

TEST_F(RunFilePublish, AMissingFolderIsNamed) {
  try {
    const RunFileWriter writer(posix_file_ops(), folder_ / "no/run.h5", content_);
    ADD_FAILURE() << "created";
  } catch (const EnvironmentError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr(folder_ / "no/run.h5"), HasSubstr("No such file or directory")));
  }
}

}  // namespace
}  // namespace noiseloom
