// One run at a time writes an output.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <thread>

#include "files/lock_record.h"
#include "noiseloom/files/generations.h"
#include "noiseloom/files/run_file.h"
#include "noiseloom/files/run_lock.h"
#include "support/lock_holder.h"
#include "support/sample_run_file.h"
#include "support/sanitizers.h"

namespace noiseloom {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(RunLock, ASecondRunIsToldWhoHoldsIt) {
  const TemporaryFolder folder;
  const std::string path = folder / "run.h5";
  Child holder([&](auto ready) {
    const RunLock lock(path);
    ready();
    ::pause();
  });
  ASSERT_TRUE(holder.wait_until_ready());
  char host[256] = {};
  ::gethostname(host, sizeof host - 1);
  EXPECT_THAT(refusal(path), AllOf(HasSubstr(path), HasSubstr("process " + std::to_string(holder.pid())),
                                   HasSubstr(host), HasSubstr("since 2"), HasSubstr("UTC")));
  EXPECT_EQ(refusal(folder / "other.h5"), "locked");
}

TEST(RunLock, AKilledHolderFreesIt) {
  const TemporaryFolder folder;
  const std::string path = folder / "run.h5";
  Child holder([&](auto ready) {
    const RunLock lock(path);
    ready();
    ::pause();
  });
  ASSERT_TRUE(holder.wait_until_ready());
  holder.kill_and_wait();
  EXPECT_TRUE(std::filesystem::exists(path + ".lock"));
  const RunLock lock(path);
  EXPECT_TRUE(lock.enforced());
  EXPECT_THAT(read_bytes(path + ".lock"), HasSubstr("process " + std::to_string(::getpid())));
}

TEST(LockWatch, SeesWhetherAProcessOfThisMachineHoldsIt) {
  const TemporaryFolder folder;
  const std::string path = folder / "run.h5";
  LockWatch watch(path);
  EXPECT_FALSE(watch.is_held());
  Child holder([&](auto ready) {
    const RunLock lock(path);
    ready();
    ::pause();
  });
  ASSERT_TRUE(holder.wait_until_ready());
  EXPECT_TRUE(watch.is_held());
  ::kill(holder.pid(), SIGKILL);
  siginfo_t ended;
  ASSERT_EQ(::waitid(P_PID, static_cast<id_t>(holder.pid()), &ended, WEXITED | WNOWAIT), 0);
  EXPECT_FALSE(watch.is_held());  // though its process is not collected yet
  holder.kill_and_wait();
  EXPECT_FALSE(watch.is_held());
  EXPECT_TRUE(std::filesystem::exists(path + ".lock"));
  const RunLock lock(path);
  EXPECT_TRUE(watch.is_held());
}

// In a container of its own a process has another number there than here.
TEST(LockWatch, BelievesTheSystemsLockWhereTheProcessIsNotSeen) {
  const TemporaryFolder folder;
  const std::string path = folder / "run.h5";
  LockRecord record = own_record();
  record.started -= 1;
  write_bytes(path + ".lock", to_text(record));
  LockWatch watch(path);
  EXPECT_FALSE(watch.is_held());
  const int fd = ::open((path + ".lock").c_str(), O_RDWR);
  ASSERT_EQ(::flock(fd, LOCK_EX), 0);
  EXPECT_TRUE(watch.is_held());
  ::close(fd);
  EXPECT_FALSE(watch.is_held());
}

TEST(RunLock, LeavesNoFileBehind) {
  const TemporaryFolder folder;
  { const RunLock lock(folder / "run.h5"); }
  EXPECT_THAT(folder.names(), ElementsAre());
}

// Holders come and go, each removing the file that the others may just have opened; a file that each holder measures
// and then lengthens by a byte loses no byte only if there never are two holders.
TEST(RunLock, IsNeverHeldTwiceWhileFilesAreRemoved) {
  const TemporaryFolder folder;
  const std::string path = folder / "run.h5";
  const std::string counter = folder / "counter";
  write_bytes(counter, "");
  constexpr int num_children = 4;
  constexpr int steps = testing_support::tried(150);
  {
    std::vector<std::unique_ptr<Child>> children;
    for (int i = 0; i < num_children; ++i) {
      children.push_back(std::make_unique<Child>([&](auto ready) {
        for (int done = 0; done < steps;) {
          try {
            const RunLock lock(path);
            const std::size_t size = std::filesystem::file_size(counter);
            ::usleep(200);  // time for a second holder to come in between, if one can
            put_bytes(counter, size, "x");
            ++done;
          } catch (const UserError&) {
            ::usleep(100);
          }
        }
        ready();
      }));
    }
    for (const auto& child : children) ASSERT_TRUE(child->wait_until_ready());
  }
  EXPECT_EQ(std::filesystem::file_size(counter), static_cast<std::uintmax_t>(num_children * steps));
}

TEST(RunLock, NamesAFolderThatCannotBeWritten) {
  const TemporaryFolder folder;
  const std::string closed = folder / "closed";
  std::filesystem::create_directory(closed);
  ASSERT_EQ(::chmod(closed.c_str(), 0555), 0);
  ASSERT_EQ(::chmod(folder.path().c_str(), 0755), 0);
  const Child other_user([&](auto ready) {
    constexpr uid_t nobody = 65534;
    if (::getuid() == 0 && ::seteuid(nobody) != 0) return;  // root may write anywhere
    try {
      const RunLock lock(closed + "/run.h5");
    } catch (const EnvironmentError& error) {
      const std::string text = error.what();
      if (text.starts_with(closed + ": ") && text.find("Permission denied") != text.npos) ready();
    }
  });
  EXPECT_TRUE(other_user.wait_until_ready());
}

TEST(RunLock, AMissingFolderIsTheUsersFault) {
  const TemporaryFolder folder;
  EXPECT_THAT(refusal(folder / "no/run.h5"), AllOf(HasSubstr(folder / "no"), HasSubstr("no such folder")));
}

// --- holders on other machines, as far as a file can play them ---

using namespace std::chrono_literals;

class LockOfAnotherMachine : public testing::Test {
 protected:
  void SetUp() override { ::unsetenv("SLURM_JOB_ID"); }
  void TearDown() override {
    for (const char* name : {"SLURM_JOB_ID", "SLURM_RESTART_COUNT", "SLURM_CLUSTER_NAME"}) ::unsetenv(name);
  }
  void leave(const LockRecord& record) const { write_bytes(lock_path_, to_text(record)); }
  void age(std::chrono::seconds by) const {
    std::filesystem::last_write_time(lock_path_, std::filesystem::last_write_time(lock_path_) - by);
  }
  // "locked", or the refusal; `said` gets what the user is told while it waits.
  std::string attempt(LockTiming timing = quick) {
    said_.clear();
    try {
      const RunLock lock(
          path_, [&](const std::string& text) { said_ = text; }, timing);
      return "locked";
    } catch (const UserError& error) {
      return error.what();
    }
  }

  TemporaryFolder folder_;
  std::string path_ = folder_ / "run.h5";
  std::string lock_path_ = path_ + ".lock";
  std::string said_;
};

TEST_F(LockOfAnotherMachine, IsRemovedByWhoeverSawItSilentForLongEnough) {
  LockTiming timing;
  timing.silence = 500ms;
  for (const bool beats : {false, true}) {
    leave(record_of_another_machine());
    age(3600s);
    LockWatch watch(path_, timing);
    watch.remove_if_dead();  // its clock may have jumped
    EXPECT_TRUE(watch.is_held());
    std::this_thread::sleep_for(550ms);
    if (beats) std::filesystem::last_write_time(lock_path_, std::filesystem::file_time_type::clock::now());
    LockWatch(path_, timing).remove_if_dead();  // has seen nothing yet
    EXPECT_EQ(folder_.names().size(), 1U);
    watch.remove_if_dead();
    EXPECT_EQ(folder_.names().size(), beats ? 1U : 0U);
  }
}

TEST_F(LockOfAnotherMachine, LongSilentIsTakenAfterABeat) {
  leave(record_of_another_machine());
  age(3600s);
  const auto begun = std::chrono::steady_clock::now();
  LockTiming timing;
  timing.beat = 20ms;
  EXPECT_EQ(attempt(timing), "locked");
  EXPECT_LT(std::chrono::steady_clock::now() - begun, 5s);
  EXPECT_THAT(folder_.names(), ElementsAre());
}

TEST_F(LockOfAnotherMachine, ThatBeatsIsRefusedThoughTheClockJumpedByAYear) {
  for (const std::chrono::seconds jump : {365 * 24 * 3600s, -365 * 24 * 3600s}) {
    leave(record_of_another_machine());
    age(jump);  // its last beat was before the jump
    std::atomic<bool> ending = false;
    std::thread heart([&] {
      while (!ending) {
        std::this_thread::sleep_for(20ms);
        std::filesystem::last_write_time(lock_path_, std::filesystem::file_time_type::clock::now());
      }
    });
    LockTiming timing;
    timing.beat = 40ms;
    EXPECT_THAT(attempt(timing), HasSubstr("another run is writing it"));
    ending = true;
    heart.join();
  }
}

// Our predecessor on this machine, of a job that Slurm has started anew: given a while to end, unless it is suspended.
TEST_F(LockOfAnotherMachine, OfOurOwnPredecessorHereIsTakenOver) {
  ::setenv("SLURM_JOB_ID", "123", 1);
  ::setenv("SLURM_RESTART_COUNT", "0", 1);
  for (const bool suspended : {false, true}) {
    Child holder([&](auto ready) {
      const RunLock lock(path_, {}, quick);
      ready();
      ::pause();
    });
    ASSERT_TRUE(holder.wait_until_ready());
    EXPECT_THAT(attempt(), HasSubstr("another run is writing it"));  // the same start of the job
    ::setenv("SLURM_RESTART_COUNT", "1", 1);
    if (suspended) ::kill(holder.pid(), SIGSTOP);
    LockTiming timing = quick;
    timing.dying = suspended ? 60s : 100ms;
    EXPECT_EQ(attempt(timing), "locked");
    EXPECT_THAT(said_, HasSubstr("taking over"));
    ::setenv("SLURM_RESTART_COUNT", "0", 1);
  }
  EXPECT_THAT(folder_.names(), ElementsAre());
}

TEST_F(LockOfAnotherMachine, LatelySilentIsTakenAfterAWhile) {
  leave(record_of_another_machine());
  EXPECT_EQ(attempt(), "locked");
  EXPECT_THAT(said_, AllOf(HasSubstr(path_), HasSubstr("node7"), HasSubstr("waiting")));
}

TEST_F(LockOfAnotherMachine, ThatBeatsIsRefused) {
  leave(record_of_another_machine());
  std::atomic<bool> ending = false;
  std::thread heart([&] {
    while (!ending) {
      std::this_thread::sleep_for(20ms);
      std::filesystem::last_write_time(lock_path_, std::filesystem::file_time_type::clock::now());
    }
  });
  EXPECT_THAT(attempt(), AllOf(HasSubstr("another run is writing it"), HasSubstr("node7")));
  ending = true;
  heart.join();
  EXPECT_THAT(read_bytes(lock_path_), HasSubstr("node7"));  // its file is left alone
}

TEST_F(LockOfAnotherMachine, IsWatchedUntilItsHeartbeatEnds) {
  leave(record_of_another_machine());
  LockTiming timing;
  timing.silence = 200ms;
  LockWatch watch(path_, timing);
  EXPECT_TRUE(watch.is_held());
  std::this_thread::sleep_for(250ms);
  age(1s);  // another time of change: a beat
  EXPECT_TRUE(watch.is_held());
  std::this_thread::sleep_for(250ms);
  EXPECT_FALSE(watch.is_held());
  EXPECT_THAT(read_bytes(lock_path_), HasSubstr("node7"));
}

// The server of a network file system keeps the lock of a dead node: here a child of ours holds it and says nothing.
TEST_F(LockOfAnotherMachine, KeptByTheServerIsReplaced) {
  leave(record_of_another_machine());
  Child server([&](auto ready) {
    const int fd = ::open(lock_path_.c_str(), O_RDWR);
    if (::flock(fd, LOCK_EX) == 0) ready();
    ::pause();
  });
  ASSERT_TRUE(server.wait_until_ready());
  {
    const RunLock lock(path_, {}, quick);
    EXPECT_TRUE(lock.enforced());
    EXPECT_THAT(read_bytes(lock_path_), HasSubstr("process " + std::to_string(::getpid())));
    EXPECT_THAT(refusal(path_), HasSubstr("another run is writing it"));
  }
  EXPECT_THAT(folder_.names(), ElementsAre());
}

TEST_F(LockOfAnotherMachine, OfTheSameSlurmJobBeforeItsRequeueIsTakenAtOnce) {
  ::setenv("SLURM_JOB_ID", "123", 1);
  ::setenv("SLURM_CLUSTER_NAME", "snow", 1);
  ::setenv("SLURM_RESTART_COUNT", "2", 1);
  LockRecord predecessor = record_of_another_machine();
  predecessor.slurm_job = "snow/123";
  predecessor.slurm_restarts = 1;
  leave(predecessor);
  EXPECT_EQ(attempt(), "locked");
  EXPECT_EQ(said_, "");
  // The same number on another cluster, another job, or the same start of the job: these may live.
  for (const auto& [job, restarts] : {std::pair{"rain/123", 1}, std::pair{"snow/124", 1}, std::pair{"snow/123", 2}}) {
    predecessor.slurm_job = job;
    predecessor.slurm_restarts = restarts;
    leave(predecessor);
    EXPECT_EQ(attempt(), "locked");
    EXPECT_THAT(said_, HasSubstr("waiting")) << job << " " << restarts;
  }
}

TEST_F(LockOfAnotherMachine, IsNotAskedForWhereTheHolderIsHere) {
  LockRecord here = own_record();
  const LockRecord ours = own_record();
  EXPECT_EQ(judge(here, ours, SystemLock::held), Holder::alive);
  EXPECT_EQ(judge(here, ours, SystemLock::free), Holder::dead);
  // Without locks the process itself is looked at: this one lives; one with its number before it did not.
  EXPECT_EQ(judge(here, ours, SystemLock::unsupported), Holder::alive);
  here.started -= 1;
  EXPECT_EQ(judge(here, ours, SystemLock::unsupported), Holder::dead);
  EXPECT_EQ(judge({}, ours, SystemLock::held), Holder::alive);
  EXPECT_EQ(judge({}, ours, SystemLock::free), Holder::dead);
  EXPECT_EQ(judge(record_of_another_machine(), ours, SystemLock::free), Holder::unknown);
}

TEST_F(LockOfAnotherMachine, ALiveHolderBeats) {
  const RunLock lock(path_, {}, quick);
  const auto before = std::filesystem::last_write_time(lock_path_);
  for (int i = 0; i < 500 && std::filesystem::last_write_time(lock_path_) == before; ++i) {
    std::this_thread::sleep_for(10ms);
  }
  EXPECT_GT(std::filesystem::last_write_time(lock_path_), before);
}

TEST(LockRecord, SurvivesItsText) {
  LockRecord record = record_of_another_machine();
  record.slurm_job = "snow/123";
  record.slurm_restarts = 3;
  const LockRecord read = parse_record(to_text(record));
  EXPECT_EQ(read.holder, record.holder);
  EXPECT_EQ(read.machine, record.machine);
  EXPECT_EQ(read.pid, record.pid);
  EXPECT_EQ(read.started, record.started);
  EXPECT_EQ(read.number, record.number);
  EXPECT_EQ(read.slurm_job, record.slurm_job);
  EXPECT_EQ(read.slurm_restarts, record.slurm_restarts);
}

}  // namespace
}  // namespace noiseloom
