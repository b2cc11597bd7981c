// Ends a run that would wait for ever: for a rank whose process is stopped, whose node hangs or is cut off, or that all
// others wait for. Neither MPI nor its launcher notices these.
//
// A thread of every rank tells rank 0's, some times a second, that the rank lives, what it does and how many steps it
// has made; rank 0's answers. These threads talk over connections of their own (TCP), as MPI's calls block with the
// rank that calls them. A rank counts as lost when nothing was heard of it for `silence_s`; the run counts as stuck
// when all ranks live and none makes a step for much longer than steps of this run take. Whoever finds that out says
// which rank it is and what it did last, and ends its process with `exit_lost_rank`: the launcher then ends all others,
// and those that it cannot reach end by themselves, as nobody answers them any more.
//
// Time in which this process itself is suspended does not count: where a batch system suspends a whole job, nobody is
// lost when it goes on.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "noiseloom/dist/communicator.h"

namespace noiseloom {

// Of a process that its watchdog ended: what was saved last is whole, and the run can go on from there.
inline constexpr int exit_lost_rank = 76;

struct WatchSettings {
  bool is_on = true;
  double silence_s = 120;  // after which a rank counts as lost
  double stuck_s = 0;      // without a step; 0: half an hour, or 100 times the longest step where that is more
};

class Watchdog {
 public:
  // Does nothing on one rank, or where it is off. `warn` is told on rank 0 of ranks that cannot be watched. `print`
  // shows the last words of a process, from another thread. *Collective*
  Watchdog(const Communicator& communicator, const WatchSettings& settings,
           const std::function<void(const std::string&)>& warn, const std::function<void(const std::string&)>& print);
  ~Watchdog();
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace noiseloom
