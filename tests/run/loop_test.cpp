#include "noiseloom/run/loop.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <array>

#include "support/fake_job.h"
#include "support/mpi_session.h"

namespace noiseloom {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

// A loop over ten steps of one second each, with what it prints.
class Loop : public testing::Test {
 protected:
  Loop() {
    EXPECT_EQ(::pipe(pipe_.data()), 0);
    job_.after_step = [this](int step) {
      world_.now_s += 1;
      if (at_step_) at_step_(step);
    };
  }
  ~Loop() override {
    for (const int end : pipe_) ::close(end);
  }

  LoopResult run(const LoopSettings& settings = {}, ProgressKind kind = ProgressKind::none) {
    Progress progress(kind, pipe_[1]);
    const Surroundings surroundings = world_.surroundings();
    job_.on_refresh = [this] { events_.push_back(refreshed); };
    const SaveRun save = [this] {
      const int number = num_saves_++;
      if (save_fails_ && save_fails_(number)) throw SharedEnvironmentError("no space left");
      saved_steps_.push_back(job_.steps());
      events_.push_back(job_.steps());
      return "sum of step " + std::to_string(job_.steps());
    };
    return RunLoop(job_, settings, 0, surroundings, save, communicator_, progress).run();
  }

  // Everything printed so far.
  std::string printed() {
    ::close(pipe_[1]);
    std::string text;
    std::array<char, 4096> piece{};
    for (ssize_t size = 0; (size = ::read(pipe_[0], piece.data(), piece.size())) > 0;) {
      text.append(piece.data(), static_cast<std::size_t>(size));
    }
    pipe_[1] = ::dup(0);
    return text;
  }

  const Communicator communicator_ = Communicator::self();
  std::array<int, 2> pipe_{};
  FakeWorld world_;
  FakeJob job_{10};
  std::function<void(int)> at_step_;
  std::function<bool(int)> save_fails_;  // by the number of the try
  int num_saves_ = 0;
  std::vector<int> saved_steps_;
  static constexpr int refreshed = -1;
  std::vector<int> events_;  // the same, and when it was refreshed
};

TEST_F(Loop, RunsToTheEndAndSavesOnce) {
  const LoopResult result = run();
  EXPECT_TRUE(result.finished);
  EXPECT_EQ(result.checksum, "sum of step 10");
  EXPECT_THAT(saved_steps_, ElementsAre(10));
}

TEST_F(Loop, StopsSavedAtTheStepThatASignalArrivesIn) {
  at_step_ = [this](int step) { world_.signal = step == 3 ? SIGHUP : world_.signal; };
  const LoopResult result = run();
  EXPECT_FALSE(result.finished);
  EXPECT_EQ(result.stopped_by, "SIGHUP");
  EXPECT_EQ(job_.steps(), 3);
  EXPECT_THAT(saved_steps_, ElementsAre(3));
}

TEST_F(Loop, ASignalBeforeTheFirstStepSavesTheStart) {
  world_.signal = SIGUSR1;
  EXPECT_FALSE(run().finished);
  EXPECT_THAT(saved_steps_, ElementsAre(0));
}

TEST_F(Loop, TimeLimitStopsSavedButNotBeforeOneStep) {
  EXPECT_EQ(run({.time_limit_s = 2.5}).stopped_by, "--time-limit");
  EXPECT_THAT(saved_steps_, ElementsAre(3));
  world_.now_s = 100;  // a start-up that takes longer than the limit
  EXPECT_FALSE(run({.time_limit_s = 2.5}).finished);
  EXPECT_THAT(saved_steps_, ElementsAre(3, 4));
}

TEST_F(Loop, ALogThatNobodyReadsStopsSaved) {
  signal(SIGPIPE, SIG_IGN);
  ::close(pipe_[0]);
  pipe_[0] = ::dup(0);
  const LoopResult result = run({}, ProgressKind::json);
  EXPECT_FALSE(result.finished);
  EXPECT_THAT(result.stopped_by, HasSubstr("nobody reads"));
  EXPECT_THAT(saved_steps_, ElementsAre(1));
}

TEST_F(Loop, CheckpointsAtIntervals) {
  run({.checkpoint_every_s = 3});
  EXPECT_THAT(saved_steps_, ElementsAre(3, 6, 9, 10));
}

TEST_F(Loop, RefreshesWhatIsKnownOfTheRunAtAStopAlone) {
  run({.time_limit_s = 5, .checkpoint_every_s = 3});
  EXPECT_THAT(events_, ElementsAre(3, refreshed, 5));
  events_.clear();
  world_.now_s = 0;
  run();
  EXPECT_THAT(events_, ElementsAre(10));
}

TEST_F(Loop, SavesBeforeARefreshThatTakesLong) {
  job_.quick_refresh = false;
  run({.time_limit_s = 5});
  EXPECT_THAT(events_, ElementsAre(5, refreshed, 5));
}

TEST_F(Loop, AStopIsSavedThoughTheRefreshedSaveFails) {
  job_.quick_refresh = false;
  save_fails_ = [](int number) { return number > 0; };
  const LoopResult result = run({.time_limit_s = 5}, ProgressKind::plain);
  EXPECT_FALSE(result.finished);
  EXPECT_EQ(result.stopped_by, "--time-limit");
  EXPECT_EQ(result.checksum, "sum of step 5");
  EXPECT_EQ(num_saves_, 2);
  EXPECT_THAT(printed(), HasSubstr("WARNING: saved, but not once more with what is known of the run at its stop (step "
                                   "5): no space left"));
}

TEST_F(Loop, AStopThatIsNotSavedAtAllFails) {
  job_.quick_refresh = false;
  save_fails_ = [](int) { return true; };
  EXPECT_THROW(run({.time_limit_s = 5}), SharedEnvironmentError);
  EXPECT_EQ(num_saves_, 3);
}

TEST_F(Loop, AFailedCheckpointWarnsAndIsTriedAgainSoon) {
  at_step_ = [this](int) { world_.now_s += 9; };  // a step takes ten seconds
  save_fails_ = [](int number) { return number == 1; };
  EXPECT_TRUE(run({.checkpoint_every_s = 40}).finished);
  // At 40 s as planned, at 80 s in vain, 30 s later again; then at the end.
  EXPECT_THAT(saved_steps_, ElementsAre(4, 10));
  EXPECT_EQ(num_saves_, 3);
  const std::string text = printed();
  EXPECT_THAT(text, HasSubstr("WARNING: not saved at step 8: no space left; still saved: step 4"));
  EXPECT_THAT(text, HasSubstr("trying again in 30.0 s"));
}

TEST_F(Loop, FailedCheckpointsAreTriedLessAndLessOften) {
  FakeJob long_job(1000);
  at_step_ = [this](int) { world_.now_s += 9; };
  std::vector<double> tries_s;
  save_fails_ = [&](int) {
    tries_s.push_back(world_.now_s);
    return world_.now_s < 1500;
  };
  long_job.after_step = job_.after_step;
  Progress progress(ProgressKind::silent);
  const Surroundings surroundings = world_.surroundings();
  const SaveRun save = [&] {
    if (save_fails_(0)) throw SharedEnvironmentError("no space left");
    return std::string();
  };
  const LoopSettings settings{.checkpoint_every_s = 400};
  RunLoop(long_job, settings, 0, surroundings, save, communicator_, progress).run();
  tries_s.resize(8);
  // Waits of 30, 60, 120, 240 s, then the interval; the interval again once it has worked.
  EXPECT_THAT(tries_s, ElementsAre(400, 430, 490, 610, 850, 1250, 1650, 2050));
}

TEST_F(Loop, TheLastSaveIsTriedAgain) {
  save_fails_ = [](int number) { return number < 2; };
  const LoopResult result = run();
  EXPECT_TRUE(result.finished);
  EXPECT_EQ(result.checksum, "sum of step 10");
  EXPECT_THAT(world_.waits_s, ElementsAre(1, 4));
}

TEST_F(Loop, EndsOnlyWhenTheLastSaveFails) {
  save_fails_ = [](int number) { return number > 0; };
  try {
    run({.checkpoint_every_s = 6});
    FAIL();
  } catch (const SharedEnvironmentError& error) {
    EXPECT_THAT(error.what(), HasSubstr("no space left"));
    EXPECT_THAT(error.what(), HasSubstr("step 10 is not saved; what was saved last is whole: step 6"));
  }
  EXPECT_EQ(job_.steps(), 10);
}

TEST_F(Loop, SaysWhereItSaved) {
  run({.checkpoint_every_s = 4}, ProgressKind::plain);
  const std::string text = printed();
  EXPECT_THAT(text, HasSubstr("saved at step 4\n"));
  EXPECT_THAT(text, HasSubstr("saved at step 8\n"));
  EXPECT_THAT(text, Not(HasSubstr("saved at step 10")));  // the summary says that
}

TEST_F(Loop, TellsProgramsOfTheSaveAndOfRanks) {
  run({.checkpoint_every_s = 4}, ProgressKind::json);
  const std::string text = printed();
  EXPECT_THAT(text, HasSubstr("\"seconds_since_save\": null, \"bytes_sent\": 0, \"slowest_rank\": 0, "
                              "\"slowest_computed\": 1, \"fastest_rank\": 0"));
  EXPECT_THAT(text, HasSubstr("\"seconds_since_save\": 2"));
}

TEST_F(Loop, AFullDiskUnderTheLogIsNoReasonToStop) {
  ::close(pipe_[1]);
  pipe_[1] = ::open("/dev/full", O_WRONLY);
  ASSERT_GE(pipe_[1], 0);
  EXPECT_TRUE(run({}, ProgressKind::json).finished);
}

}  // namespace
}  // namespace noiseloom
