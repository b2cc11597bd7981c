// The loop of a run: one step of its job after the other, with checkpoints at intervals, until the job is finished or
// something asks for a stop: a signal, the time limit, or a log that nobody reads any more.
//
// All ranks decide the same at every safe point, from bits that are or-ed over them: any rank may have got a signal,
// but only rank 0's clock and rank 0's log count.
//
// A checkpoint that fails does not end the run: it warns, keeps what was saved before, and tries again, soon at first.
// Only the last save must succeed; it is tried several times, since a disk may be full for a moment only. At a stop
// that is the save that holds the state: a second one, which only says more of it, may fail.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "noiseloom/dist/communicator.h"
#include "noiseloom/run/job.h"
#include "noiseloom/run/progress.h"

namespace noiseloom {

struct LoopSettings {
  double time_limit_s = 0;  // of this part of the run; 0: none
  double checkpoint_every_s = 600;
};

// What the loop asks of the world; a test gives answers of its own.
struct Surroundings {
  std::function<double()> part_s;      // seconds since this part of the run began
  std::function<int()> stop_signal;    // the number of one that arrived, 0: none
  std::function<void(double)> wait_s;  // returns after so many seconds
};

// A clock that starts now, and the signals of run/stop_signals.h.
Surroundings real_surroundings();

// Publishes the present state and returns a checksum; throws SharedEnvironmentError on every rank where it cannot.
// *Collective*
using SaveRun = std::function<std::string()>;

struct LoopResult {
  bool finished = false;
  std::string stopped_by;  // where it is not finished: "SIGUSR1", "--time-limit"; on rank 0
  std::string checksum;    // what the last save returned
};

class RunLoop {
 public:
  // `earlier_s`: what the earlier parts of this run took. All arguments outlive the loop.
  RunLoop(Job& job, const LoopSettings& settings, double earlier_s, const Surroundings& surroundings,
          const SaveRun& save, const Communicator& communicator, Progress& progress);

  // From a job that has been started or restored to its end or a stop, saved either way. Throws SharedEnvironmentError
  // when the last save fails. *Collective*
  LoopResult run();

 private:
  double run_s() const { return earlier_s_ + surroundings_.part_s(); }
  std::uint32_t bits_due() const;
  std::string stop_cause(std::uint32_t bits) const;
  void report(bool as_json);
  std::vector<JsonMember> figures_of_ranks();
  void checkpoint();
  std::string save_at_stop();
  std::string save_at_last();

  Job& job_;
  const LoopSettings& settings_;
  const double earlier_s_;
  const Surroundings& surroundings_;
  const SaveRun& save_;
  const Communicator& communicator_;
  Progress& progress_;
  double next_save_s_;
  double retry_s_;              // until the next try, should one fail
  std::string saved_position_;  // of the job at the last save of this part
  double saved_s_ = -1;         // when that was
  bool has_moved_ = false;
  double reported_s_ = 0;  // when the last report was made, and how long this rank had waited for others by then
  double waited_s_ = 0;
};

}  // namespace noiseloom
