// The loop on several ranks: what one rank sees, all do.
#include "noiseloom/run/loop.h"

#include <gtest/gtest.h>
#include <signal.h>

#include "support/fake_job.h"

namespace noiseloom {
namespace {

struct LoopOfRanks {
  const Communicator communicator = Communicator::world();
  FakeWorld world;
  FakeJob job{20};
  int num_saves = 0;

  LoopResult run(const LoopSettings& settings, const std::function<bool(int)>& fails_on_root) {
    Progress progress(ProgressKind::silent);
    const Surroundings surroundings = world.surroundings();
    const SaveRun save = [&] {
      const int number = num_saves++;
      communicator.on_root([&] {
        if (fails_on_root(number)) throw EnvironmentError("no space left");
      });
      return std::string("saved");
    };
    return RunLoop(job, settings, 0, surroundings, save, communicator, progress).run();
  }
};

bool never(int) { return false; }

TEST(LoopOnRanks, ASignalToOneRankStopsAll) {
  LoopOfRanks loop;
  const Rank victim(loop.communicator.size() - 1);
  loop.job.after_step = [&](int step) {
    if (step == 5 && loop.communicator.rank() == victim) loop.world.signal = SIGUSR1;
  };
  EXPECT_FALSE(loop.run({}, never).finished);
  EXPECT_EQ(loop.job.steps(), 5);
  EXPECT_EQ(loop.num_saves, 1);
}

TEST(LoopOnRanks, OnlyTheClockOfRankZeroCounts) {
  LoopOfRanks loop;
  loop.job.after_step = [&](int) { loop.world.now_s += loop.communicator.is_root() ? 1 : 1000; };
  EXPECT_EQ(loop.run({.time_limit_s = 7}, never).finished, false);
  EXPECT_EQ(loop.job.steps(), 7);
}

TEST(LoopOnRanks, AllGoOnAfterACheckpointThatRankZeroCannotWrite) {
  LoopOfRanks loop;
  loop.job.after_step = [&](int) { loop.world.now_s += 1; };
  EXPECT_TRUE(loop.run({.checkpoint_every_s = 8}, [](int number) { return number == 0; }).finished);
  EXPECT_EQ(loop.job.steps(), 20);
  EXPECT_EQ(loop.num_saves, 3);  // at 8 s in vain, at 16 s, at the end
}

TEST(LoopOnRanks, AllEndWhenTheLastSaveFails) {
  LoopOfRanks loop;
  EXPECT_THROW(loop.run({}, [](int) { return true; }), SharedEnvironmentError);
  EXPECT_EQ(loop.num_saves, 3);
}

}  // namespace
}  // namespace noiseloom
